"""How many equal bands of wavelength a colour needs

A renderer with N equal bands is held to ΔE2000 < 1 against the exact colour. The sources say that about 20 wavelengths suffice, that 10 or more do, or only that 3 do not; this measures it
for every illuminant.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt

from colour_common import LIGHTS, Surfaces, ask, catalogue, delta_e, grid, illuminant, lab, linear, observer, reflectance

METHOD = """The range 380–780 nm is cut into N equal bands, and the 24 patches of the ColorChecker are coloured in two ways that renderers use. *Lines*: everything is known at the middles of the bands only,
XYZ = Σ S(λᵢ) ρ(λᵢ) c(λᵢ) Δλ with c the colour-matching functions. *Averages*: light times colour matching is integrated over each band exactly, and only the reflectance is replaced by its mean in
the band, XYZ = Σ ρ̄ᵢ ∫ S c dλ; then a grey surface and the white have no error. Lines are what "trace N frequencies" means, averages the best that N bands can do for diffuse surfaces. The colour is
compared with abbe's exact one, both with Y = 1 for the white that each way has itself (exposure is adjusted) and the exact white of CIELAB (a tint of white is an error). The number told is the least N from
which on the worst patch, or the mean, stays below 1 up to N = 240."""
DATA = """ColorChecker (BabelColor), illuminants and observer from colour-science 0.4.7; the exact colours from abbe. Sources of the claims: A. S. Glassner (ed.), *An Introduction to Ray Tracing* (1989)
and the works that it collects ("about twenty frequencies", "10+ channels", "more than three")."""

MOST = 240
RANGE = (380.0, 780.0)
FINE = 0.25  # nm, of the integrals
PLANTED = [
    Planted("bands shifted by a quarter of their width", caught_by=("240 bands",)),
    Planted("exact colours of the observer of 1964", caught_by=("240 bands", "exact colours")),
]


def stays_below(counts, values):
    """The least count from which on all values are below 1, as text."""
    above = np.nonzero(np.asarray(values) >= 1)[0]
    if len(above) == 0:
        return counts[0]
    return counts[above[-1] + 1] if above[-1] + 1 < len(counts) else None


class Bands:
    """Colours of surfaces in bands."""

    def __init__(self, sds, shift=0.0):
        self.nm = np.arange(RANGE[0], RANGE[1] + FINE / 2, FINE)
        self.sds = sds
        self.matching = observer("cie1931", FINE).values[(grid(FINE).wavelengths >= RANGE[0]) & (grid(FINE).wavelengths <= RANGE[1])]
        self.rows = np.array([np.interp(self.nm, sd.wavelengths, sd.values) for sd in sds])
        self.cumulated = self.integrate(self.rows)
        self.shift = shift

    @staticmethod
    def integrate(rows):
        """Running integrals over the fine grid, from 0, by the trapezoid rule."""
        return np.concatenate([np.zeros((len(rows), 1)), np.cumsum((rows[:, 1:] + rows[:, :-1]) / 2 * FINE, axis=1)], 1)

    def between(self, cumulated, edges):
        at = np.array([np.interp(edges, self.nm, row) for row in cumulated])
        return np.diff(at, axis=1)

    def colours(self, light, count):
        """XYZ of the surfaces by lines and by averages, relative to the Y of a white in the same bands."""
        edges = np.linspace(*RANGE, count + 1)
        width = edges[1] - edges[0]
        middles = (edges[1:] + edges[:-1]) / 2 + self.shift * width
        at = lambda rows: np.array([np.interp(middles, self.nm, row) for row in rows])
        weight = at([light])[0] * at(self.matching.T)
        rows = np.vstack([at(self.rows), np.ones(count)])
        lines = rows @ weight.T
        weight = self.between(self.integrate(light * self.matching.T), edges + self.shift * width)
        rows = np.vstack([self.between(self.cumulated, edges) / width, np.ones(count)])
        averages = rows @ weight.T
        with np.errstate(invalid="ignore"):
            return [xyz[:-1] / xyz[-1, 1] for xyz in (lines, averages)]


def run(claim):
    entries = [entry for entry in catalogue(claim.abbe, "reflectance") if entry[0].startswith("colorchecker/")]
    sds = [reflectance(file, column)[0] for _, file, column in entries]
    lights = {entry[0]: entry for entry in catalogue(claim.abbe, "illuminant")}
    names = [name for name in LIGHTS if name in lights] if claim.quick else [name for name in lights if name != "A/5nm"]
    asked = "cie1964" if claim.planted == PLANTED[1].what else "cie1931"
    answers = dict(zip(names, ask(claim.abbe, "colours", observer=asked, illuminants=names, reflectances=[name for name, _, _ in entries])))
    bands, witness = Bands(sds, 0.25 if claim.planted == PLANTED[0].what else 0.0), Surfaces(sds)
    counts = [3, 5, 10, 15, 20, 30, 40, 60, 120, 240] if claim.quick else [*range(3, 65), *range(66, MOST + 1, 6)]
    if claim.planted:
        counts = [MOST]
    worst, mean, apart, limit = {}, {}, [], []
    for name in names:
        sd = illuminant(*lights[name][1:])[0]
        light = np.interp(bands.nm, sd.wavelengths, sd.values, left=0, right=0)
        white = np.array(answers[name]["white"])
        target = lab(np.array(answers[name]["xyz"]), white)
        exact, _ = witness.colours(sd)
        apart.append(delta_e(target, lab(exact[:-1], exact[-1])))
        banded = np.array([bands.colours(light, count) for count in counts])  # counts × ways × patches × 3
        # Where no band meets the lamp's lines there is no colour at all.
        differences = np.nan_to_num(delta_e(lab(banded, white), target), nan=np.inf)
        worst[name], mean[name] = differences.max(2), differences.mean(2)
        limit.append(worst[name][-1])
    claim.bounded("exact colours, of abbe and of colour-science: ΔE2000", apart, 0.01)
    claim.bounded(f"{MOST} bands, averages: worst ΔE2000 of all patches and lights", np.array(limit)[:, 1], 0.05)
    claim.bounded(f"{MOST} bands, lines: worst ΔE2000 of all patches and lights", np.array(limit)[:, 0], 0.1)
    if claim.planted:
        return
    enough = {count: [[name for name in names if values[name][counts.index(count), way] < 1] for way in (0, 1) for values in (worst, mean)] for count in (3, 5, 10, 15, 20, 30, 40)}
    claim.table(
        ("bands", "lines, worst patch", "lines, mean", "averages, worst patch", "averages, mean"),
        [(count, *(f"{len(of)} of {len(names)}" for of in ways)) for count, ways in enough.items()],
        "Under how many illuminants ΔE2000 is below 1 with so many bands.",
    )
    claim.holds("3 bands are never enough, neither for the worst patch nor in the mean", not any(enough[3]), f"{sum(map(len, enough[3]))} cases below 1", "none", "one light with less")
    claim.holds("10 bands are not enough for the worst patch, whatever the light", not enough[10][0] and not enough[10][2], f"{len(enough[10][0]) + len(enough[10][2])} cases below 1", "none")
    claim.holds("20 averages are enough in the mean, whatever the light; 20 lines are not", len(enough[20][3]) == len(names) > len(enough[20][1]), f"averages {len(enough[20][3])}, lines {len(enough[20][1])} of {len(names)}", "averages all, lines not all")
    rows = []
    for name in names:
        cells = [stays_below(counts, values[name][:, way]) for way in (0, 1) for values in (worst, mean)]
        rows.append((name, *("over 240" if cell is None else cell for cell in cells), *(f"{worst[name][counts.index(20), way]:.2f}" for way in (0, 1))))
    claim.table(
        ("illuminant", "lines, worst patch < 1", "lines, mean < 1", "averages, worst patch < 1", "averages, mean < 1", "worst ΔE2000 of 20 lines", "of 20 averages"),
        rows,
        "Least number of equal bands from which on ΔE2000 stays below 1." + (" With --quick only the counts 3, 5, 10, 15, 20, 30, 40, 60, 120 and 240 were tried." if claim.quick else ""),
    )
    draw(claim, counts, worst, mean, names)


def draw(claim, counts, worst, mean, names):
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 3.8), sharey=True)
    for way, (panel, title) in enumerate(zip(axes, ("lines: everything at the middles of the bands", "averages: only the reflectance in bands"))):
        for name in names:
            if name not in LIGHTS:
                panel.loglog(counts, worst[name][:, way], color="0.85", lw=0.5, zorder=1)
        for name in LIGHTS:
            panel.loglog(counts, worst[name][:, way], label=name, lw=1.1, zorder=2, ls="--" if name == LIGHTS[-1] else "-")
        panel.axhline(1, color="0.3", lw=0.8, ls="--")
        panel.axvline(20, color="0.3", lw=0.6, ls=":")
        panel.set(xlabel="bands", title=title, ylim=(3e-4, 60))
    axes[0].set_ylabel("ΔE2000, worst patch")
    axes[1].legend(fontsize=7, ncols=2)
    claim.figure("bands", figure, "The worst of 24 patches against the number of equal bands; grey: all other illuminants. Dotted: the “about twenty” of the sources. Lamps with narrow lines need many more lines than that, and their error does not fall steadily: it depends on where the lines of the lamp lie in the bands.")
