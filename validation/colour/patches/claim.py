"""Colours of surfaces: the ColorChecker under A, D50, D65, E, F2, F7, F11 and an LED, and everything else under every illuminant

abbe's XYZ = ∫ S ρ (x̄, ȳ, z̄) dλ / ∫ S ȳ dλ, xy and CIELAB (CIE 15:2018, sections 7 and 8) of every reflectance under every illuminant agree with colour-science: ΔE2000 below
0.01 and the relative error of X, Y and Z below 10⁻⁵.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt
from matplotlib.colors import LogNorm

from colour_common import LIGHTS, OBSERVERS, STEP, Surfaces, adapted, ask, catalogue, delta_e, grid, illuminant, lab, linear, observer, reflectance, srgb

METHOD = f"""abbe integrates the product of three piecewise linear functions exactly. colour-science sums it over a grid (`msds_to_XYZ(method="Integration")`), after its own
linear interpolator put its tables there; illuminants are zero beyond their tables, reflectances keep their end values. With every node on the grid the error of such a sum
has a part linear in the step, from the jumps where a table ends, one quadratic, and no other, so three sums of steps h, h/2 and h/4 give the integral exactly,
(s₁ − 6 s₂ + 8 s₃)/3 with h = {STEP} nm (last figure: the plain sum). Both sides use their own white, their own CIELAB; ΔE2000 is colour-science's.

What conventions cost, as against what programs get wrong, is in the table: colour-science's default (`sd_to_XYZ` after ASTM E308, which draws a Sprague curve through coarse tables instead of straight
lines and keeps the ends of illuminants) and the plain sum every 5 nm."""
DATA = """colour-science 0.4.7: `MSDS_CMFS`, `SDS_ILLUMINANTS`, `SDS_LIGHT_SOURCES`, `SDS_COLOURCHECKERS` (BabelColor's mean of 30 charts; Ohta 1997), `SDS_TCS` (CIE 13.3), Mallett and Yuksel's basis.
Minerals and plants of the USGS and the reflectances derived from metals' indices are not in it and are read from `data/`."""

LAB_BOUND, XYZ_BOUND = 0.01, 1e-5
OBSERVER_5NM = "CIE 1931 observer every 5 nm instead of every 1 nm"
TILT = "illuminants scaled by 1 to 1.0001 from 360 to 830 nm"
WHITE = "white of CIELAB off by 10⁻⁴ in x"
PLANTED = [
    Planted("colour-matching functions shifted by 0.1 nm", caught_by=("ColorChecker, cie1931: relative", "ColorChecker, cie1931: ΔE2000", "every reflectance"), mutant="colour_shifted_observer"),
    Planted(OBSERVER_5NM, caught_by=("ColorChecker, cie1931: relative", "ColorChecker, cie1931: ΔE2000")),
    Planted(TILT, caught_by=("ColorChecker, cie1931: relative", "every reflectance")),
    Planted(WHITE, caught_by=("ColorChecker, cie1931: ΔE2000",)),
]


def light_of(claim, file, column):
    sd = illuminant(file, column)[0]
    if claim.planted != TILT:
        return sd
    return colour.SpectralDistribution(sd.values * (1 + 1e-4 * (sd.wavelengths - 360) / 470), sd.wavelengths)


def compare(claim, name, lights, surfaces, witness):
    """abbe's answers and colour-science's: (relative errors of XYZ, differences of xy, ΔE2000), each lights × surfaces; the witness' own errors; its XYZ."""
    asked = "cie1931-5nm" if claim.planted == OBSERVER_5NM and name == "cie1931" else name
    answers = ask(claim.abbe, "colours", observer=asked, illuminants=[light for light, _, _ in lights], reflectances=[surface for surface, _, _ in surfaces])
    relative, chromatic, differences, own, colours = [], [], [], [], []
    for (_, file, column), answer in zip(lights, answers):
        exact, summed = witness.colours(light_of(claim, file, column), name)
        expected, white = exact[:-1], exact[-1]
        if claim.planted == WHITE:
            white = colour.xy_to_XYZ(colour.XYZ_to_xy(white) + [1e-4, 0])
        found = np.array(answer["xyz"])
        relative.append(found / expected - 1)
        chromatic.append(np.array(answer["xy"]) - colour.XYZ_to_xy(expected))
        differences.append(delta_e(np.array(answer["lab"]), lab(expected, white)))
        own.append([np.abs(summed / exact - 1).max(), delta_e(lab(summed[:-1], summed[-1]), lab(expected, exact[-1])).max()])
        colours.append(exact)
    return np.array(relative), np.array(chromatic), np.array(differences), np.array(own), np.array(colours)


def run(claim):
    lights = catalogue(claim.abbe, "illuminant")
    chosen = [next(entry for entry in lights if entry[0] == name) for name in LIGHTS]
    surfaces = catalogue(claim.abbe, "reflectance")
    chart = [entry for entry in surfaces if entry[0].startswith("colorchecker/")]
    patches = Surfaces([reflectance(file, column)[0] for _, file, column in chart])
    for name in OBSERVERS if claim.planted is None else ("cie1931",):
        relative, chromatic, differences, own, colours = compare(claim, name, chosen, chart, patches)
        claim.bounded(f"ColorChecker, {name}: relative error of XYZ", relative, XYZ_BOUND)
        claim.bounded(f"ColorChecker, {name}: x and y", chromatic, XYZ_BOUND)
        claim.bounded(f"ColorChecker, {name}: ΔE2000", differences, LAB_BOUND)
        if name == "cie1931" and claim.planted is None:
            heat(claim, chart, differences, colours)
            conventions(claim, chosen, chart, colours)
    if claim.planted in (OBSERVER_5NM, WHITE):
        return
    # Everything; with --quick every fifth illuminant.
    some = lights[:: 5 if claim.quick else 1]
    everything = Surfaces([reflectance(file, column)[0] for _, file, column in surfaces])
    relative, _, differences, own, _ = compare(claim, "cie1931", some, surfaces, everything)
    claim.bounded("every reflectance under every illuminant: relative error of XYZ", relative, XYZ_BOUND)
    claim.bounded("every reflectance under every illuminant: ΔE2000", differences, LAB_BOUND)
    claim.bounded(f"the witness' own error: its plain sum every {STEP / 4} nm against the extrapolated one, ΔE2000", own[:, 1], LAB_BOUND)
    if claim.planted is None:
        convergence(claim, chart)


def heat(claim, chart, differences, colours):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 5.2), width_ratios=(1, 1.25))
    swatches = np.array([srgb(adapted(of[:-1], of[-1])) for of in colours])
    left.imshow(swatches.transpose(1, 0, 2), aspect="auto", interpolation="nearest")
    image = right.imshow(np.maximum(differences.T, 1e-13), aspect="auto", norm=LogNorm(1e-13, LAB_BOUND), cmap="viridis")
    for axes in (left, right):
        axes.grid(False)
        axes.set_xticks(range(len(LIGHTS)), LIGHTS, rotation=60)
    left.set_yticks(range(len(chart)), [name.split("/")[1] for name, _, _ in chart], fontsize=7)
    right.set_yticks([])
    figure.colorbar(image, label="ΔE2000 of abbe from colour-science (bar ends at the bound)")
    claim.figure("patches", figure, "Left: the 24 patches under eight illuminants as colour-science has them, adapted to daylight (Bradford) to be seen side by side. Right: how far abbe's colours are from them.")


def conventions(claim, lights, chart, colours):
    """How far other ways of summing are from the exact integral: ΔE2000, mean and worst patch."""
    cmfs = colour.MSDS_CMFS[OBSERVERS["cie1931"]]
    sds = [reflectance(file, column)[0] for _, file, column in chart] + [colour.sd_ones(grid(5))]
    shape = grid(5)
    rows = []
    for (name, file, column), exact in zip(lights, colours):
        light = illuminant(file, column)[0]
        with np.errstate(all="ignore"):
            default = np.array([colour.sd_to_XYZ(sd, cmfs, light) for sd in sds]) / 100
        coarse = colour.msds_to_XYZ(
            np.array([linear(sd, shape, "hold").values for sd in sds]), observer("cie1931", 5), linear(light, shape, "zero"), method="Integration", shape=shape
        ) / 100
        cells = []
        for other in (default, coarse):
            difference = delta_e(lab(other[:-1], other[-1]), lab(exact[:-1], exact[-1]))
            cells.append(f"{difference.mean():.3f}, {difference.max():.3f}")
        rows.append((name, *cells))
    claim.table(("illuminant", "colour-science's default, ASTM E308", "sum every 5 nm"), rows, "What other conventions change: ΔE2000 from the exact integral, mean and worst patch of the ColorChecker. No bound hangs on it: it says how far two right programs may lie apart.")


def convergence(claim, chart):
    """colour-science's plain sum against abbe's exact integral, by the step of the sum."""
    steps = (5, 2, 1, 0.5, 0.2, 0.1, 0.05)
    sds = [reflectance(file, column)[0] for _, file, column in chart]
    known = {name: (file, column) for name, file, column in catalogue(claim.abbe, "illuminant")}
    figure, axes = plt.subplots(figsize=(7.2, 3.4))
    names = ("D65", "A", "FL11", "LED-B3", "lamp/low-pressure-sodium")
    answers = ask(claim.abbe, "colours", observer="cie1931", illuminants=list(names), reflectances=[name for name, _, _ in chart])
    for name, answer in zip(names, answers):
        light = illuminant(*known[name])[0]
        worst = []
        for step in steps:
            shape = grid(step)
            rows = np.array([linear(sd, shape, "hold").values for sd in sds] + [np.ones(len(shape.wavelengths))])
            sums = colour.msds_to_XYZ(rows, observer("cie1931", step), linear(light, shape, "zero"), method="Integration", shape=shape) / 100
            worst.append(np.abs(sums[:-1] / np.array(answer["xyz"]) - 1).max())
        axes.loglog(steps, worst, "o-", label=name.split("/")[-1])
    axes.axhline(XYZ_BOUND, color="0.4", lw=0.8, ls="--")
    axes.text(0.05, XYZ_BOUND * 1.2, "bound", color="0.4")
    axes.loglog(steps, [1e-4 * step**2 for step in steps], ":", color="0.6", label="∝ step²")
    axes.set(xlabel="step of colour-science's sum, nm", ylabel="worst relative difference of X, Y, Z")
    axes.legend(fontsize=7.5)
    claim.figure("convergence", figure, "colour-science's plain sum against abbe's integral, worst of the 24 patches: as its step shrinks it comes to abbe's value, with the order that a sum of this kind has. What differs at 0.05 nm is the sum's own error. (At 2 nm the nodes of tables of 5 nm are not on the grid.)")
