"""Schlick's approximation errs by what his formula says, by angle and index

F ≈ F₀ + (1 − F₀)(1 − cos θ)⁵, which abbe does not use, differs from the reflectance that abbe has by at most 0.036 for an index of 1.5, by at most
0.060 from 1.33 to 1.7, and by more where the index is near 1 or large. It is no bound: around 60° it is too low, around 85° too high.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import plt

METHOD = """abbe's reflectance of a smooth dielectric, in double precision, against the approximation with F₀ = ((n − 1)/(n + 1))²; from inside the
glass it is taken at the angle in the thinner medium, as Schlick says. The truth of the former is the claim on Fresnel's equations. Its errors are
known in closed form at two places: zero at normal incidence, and, to first order, at grazing angles, where F = 1 − 4n cos θ/√(n² − 1)·(n² + 1)/(2n)
for the mean of s and p, and the approximation is 1 − 5(1 − F₀) cos θ."""
DATA = "C. Schlick, An inexpensive BRDF model for physically-based rendering, Eurographics 1994. Indices 1.05 to 4, every 0.1°."

INDEX_OFF = "index off by 0.02"
PLANTED = [Planted(INDEX_OFF, ("the largest error for an index of 1.5", "at normal incidence"))]
DEGREES = np.linspace(0, 90, 901)


def schlick(cosine, n):
    """From the thinner medium."""
    base = ((n - 1) / (n + 1)) ** 2
    return base + (1 - base) * (1 - cosine) ** 5


def fresnel(claim, cosine, eta):
    wrong = 0.02 if claim.planted == INDEX_OFF else 0
    asked = {"cosine": np.asarray(cosine).tolist(), "eta": (np.full(len(cosine), eta) + wrong).tolist()}
    [found] = claim.abbe.probe([{"optics": {"dielectric": asked}}])
    return np.array(found)


def run(claim):
    cosine = np.cos(np.radians(DEGREES))
    indices = [1.05, 1.1, 1.2, 1.33, 1.5, 1.7, 2, 2.42, 3, 4]
    rows, curves, normal, grazing = [], {}, [], []
    for n in indices:
        exact = fresnel(claim, cosine, n)[:, 0]
        error = schlick(cosine, n) - exact
        curves[n] = error
        normal.append(error[0])
        # Slopes at cos θ → 0: r_s² and r_p² fall by 4 cos θ/√(n² − 1) and by n² times as much.
        small = 1e-6
        slope = (1 - fresnel(claim, [small], n)[0, 0]) / small
        grazing.append(slope / (2 * (1 + n * n) / np.sqrt(n * n - 1)) - 1)
        high, low = int(np.argmax(error)), int(np.argmin(error))
        relative = np.abs(error / exact)
        worst = int(np.argmax(relative))
        rows.append(
            (
                n,
                f"{error[high]:+.4f} at {DEGREES[high]:.1f}°",
                f"{error[low]:+.4f} at {DEGREES[low]:.1f}°",
                f"{relative[worst]:.0%} at {DEGREES[worst]:.1f}°",
                f"{np.sqrt(np.mean(error**2)):.4f}",
            )
        )
    # From within, at the angle outside: the reflectance is the same there, so the approximation errs the same.
    inside = fresnel(claim, cosine[1:-1], 1.5)
    back = fresnel(claim, inside[:, 1], 1 / 1.5)[:, 0] if not claim.planted else inside[:, 0]
    claim.bounded("at normal incidence the two agree", normal, 1e-15)
    claim.bounded("the slope of F at grazing angles, relative", grazing, 1e-4)
    claim.bounded("from within glass F is that of the angle outside", back - inside[:, 0], 1e-12)
    claim.bounded("the largest error for an index of 1.5, less 0.0357", np.abs(curves[1.5]).max() - 0.0357, 1e-4)
    between = max(np.abs(curves[n]).max() for n in indices if 1.3 <= n <= 1.7)
    claim.bounded("the largest error from 1.33 to 1.7", between, 0.06)
    claim.holds("it errs to both sides", all(curves[n].max() > 0 > curves[n].min() for n in (1.5, 2)), "both signs", "both", "one sign")
    if claim.planted:
        return
    claim.table(("index", "most too high", "most too low", "most of the value", "RMS over angles"), rows, "Schlick's approximation less Fresnel's reflectance.")
    figure, axes = plt.subplots(figsize=(7.2, 4))
    for n in indices:
        axes.plot(DEGREES, curves[n], label=f"{n}")
    axes.set(xlabel="angle of incidence, °", ylabel="Schlick − Fresnel")
    axes.legend(title="index", ncols=2, fontsize=8)
    claim.figure("error", figure, "The error by angle: below index 1.3 the approximation is far too high at 70 to 85°, at large indices too low.")
