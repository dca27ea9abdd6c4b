"""The manner of all figures: light, small, labelled directly where there are few curves."""

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend comes first)

plt.rcParams.update(
    {
        "figure.figsize": (7.2, 3.6),
        "figure.constrained_layout.use": True,
        "font.family": "sans-serif",
        "font.size": 9,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "grid.color": "#e4e4e4",
        "grid.linewidth": 0.6,
        "lines.linewidth": 1.4,
        "lines.markersize": 3.5,
        "legend.frameon": False,
        # Okabe and Ito's colours, which the colour-blind can tell apart.
        "axes.prop_cycle": matplotlib.cycler(color=["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"]),
        # The same figure is the same file.
        "svg.hashsalt": "abbe",
        "svg.fonttype": "path",
    }
)


RESIDUAL = "residual\n(standard errors)"


def curves_and_residuals(xlabel, ylabel, below=RESIDUAL, height=4.8, ratios=(2, 1)):
    """A figure with axes for curves and, below on the same abscissa, axes for what is left of them: (figure, above, below)."""
    figure, (upper, lower) = plt.subplots(2, 1, sharex=True, figsize=(7.2, height), height_ratios=ratios)
    upper.set(ylabel=ylabel)
    lower.axhline(0, color="black", lw=0.8)
    lower.set(xlabel=xlabel, ylabel=below)
    if below == RESIDUAL:
        lower.set(ylim=(-5, 5))
    return figure, upper, lower
