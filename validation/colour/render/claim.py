"""Colours through the renderer: a rendered ColorChecker is colour-science's

A diffuse patch of reflectance ρ(λ) in light of irradiance π S(λ) is rendered as X, Y, Z = ∫ ρ S (x̄, ȳ, z̄) dλ / 106.7502594 (the unit of Mitsuba's `hdrfilm`), with every observer and
with 1, 4 or 8 wavelengths a path, and its spectral bins as the mean of ρ S over each.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt
from scipy import stats

from colour_common import LIGHTS, Surfaces, adapted, catalogue, chart, delta_e, grid, illuminant, lab, linear, patch_values, reflectance, srgb

METHOD = """24 patches seen from straight above, in light that falls straight down: nothing is random but the wavelengths of the paths, so what is tested is how they are sampled and weighed, the
observer, the film's sums and its unit. What is expected is colour-science's, integrated exactly (claim colour/patches) and not relative to a white: the absolute value is judged, too.

Twice: with the default sampler each patch has 16 pixels, which are independent of one another, so their spread gives the standard error of the patch's mean with 15 degrees of freedom. And
with the regular sampler, in which nothing is random: its samples are a quadrature over wavelength, whose error falls to nothing as they become more (second figure). So the whole
renderer is held to ΔE2000 < 0.01 and a relative error of XYZ of 10⁻⁴ at 2¹⁶ samples, which is the error of that quadrature in narrow lines; for daylight it passes 10⁻⁵ there."""
DATA = """colour-science 0.4.7: observers, illuminants, ColorChecker (BabelColor). The constant 106.7502594 nm is Mitsuba's (the integral of ȳ in its table)."""

UNIT = 106.7502594
BINS = 47
REGULAR = "regular sampler"
PLANTED = [
    Planted("a missing 1/C: colours 4 times too bright with C = 4", caught_by=("D65", "FL11", REGULAR), mutant="colour_missing_1_over_c"),
    Planted("film with the observer of every 5 nm", caught_by=(REGULAR,), mutant="colour_film_5nm"),
    Planted("density of wavelengths off by up to ± 0.2 % from 360 to 830 nm", caught_by=(REGULAR,), mutant="colour_wavelength_density"),
    Planted("spectral bins 0.5 nm off", caught_by=("spectral bins, FL11",), mutant="colour_shifted_bins"),
    Planted("light 0.1 % brighter", caught_by=(REGULAR,)),
]


def run(claim):
    size, spp = 4, 1024 if claim.quick else 4096
    entries = [entry for entry in catalogue(claim.abbe, "reflectance") if entry[0].startswith("colorchecker/")]
    names = [name for name, _, _ in entries]
    lights = {entry[0]: entry for entry in catalogue(claim.abbe, "illuminant")}
    witness = Surfaces([reflectance(file, column)[0] for _, file, column in entries])
    brighter = 1.001 if claim.planted == PLANTED[-1].what else 1.0

    def measure(light, seed, options=(), pixel_format="xyz"):
        scene = chart(claim.work / f"chart-{light.replace('/', '-')}.xml", names, light, size, brighter, pixel_format)
        return claim.abbe.render(scene, spp, seed=seed, options=options)

    def regular(light, samples):
        """One pixel a patch, nothing random: relative errors of XYZ, and ΔE2000."""
        scene = chart(claim.work / "regular.xml", names, light, 1, brighter)
        picture = claim.abbe.render(scene, samples, options=("--sampler", "regular"))
        found = picture.stack("XYZ").reshape(-1, 3)
        relative, luminance = expected(light)
        return found / (luminance * relative[:-1]) - 1, delta_e(lab(found / luminance, relative[-1]), lab(relative[:-1], relative[-1]))

    def expected(light, observer="cie1931"):
        _, file, column = lights[light]
        relative, _ = witness.colours(illuminant(file, column)[0], observer)
        return relative, witness.luminance(illuminant(file, column)[0], observer) / UNIT

    scores, shown = [], []
    for seed, light in enumerate(("D65", "FL11") if claim.quick else LIGHTS):
        found, error, freedom = patch_values(measure(light, seed).stack("XYZ"), len(names), size)
        relative, luminance = expected(light)
        claim.agrees(f"{light}: XYZ of 24 patches", found, luminance * relative[:-1], error, freedom)
        # Their errors are of single precision where a patch is grey; those are left out of the histogram.
        scores.append(((found - luminance * relative[:-1]) / error)[error > 1e-6 * found])
        shown.append((light, found / luminance, relative))
    for seed, options in enumerate([("--wavelengths", 1), ("--wavelengths", 8), ("--sampler", "independent")][: 1 if claim.quick else 3]):
        found, error, freedom = patch_values(measure("FL11", 50 + seed, options).stack("XYZ"), len(names), size)
        relative, luminance = expected("FL11")
        claim.agrees(f"{' '.join(map(str, options))[2:]}, FL11: XYZ of 24 patches", found, luminance * relative[:-1], error, freedom)
    for seed, observer in enumerate(("cie1964",) if claim.quick else ("cie1964", "cie2015-2", "cie2015-10")):
        found, error, freedom = patch_values(measure("D65", 60 + seed, ("--observer", observer)).stack("XYZ"), len(names), size)
        relative, luminance = expected("D65", observer)
        claim.agrees(f"observer {observer}, D65: XYZ of 24 patches", found, luminance * relative[:-1], error, freedom)

    space = colour.models.RGB_COLOURSPACE_sRGB.copy()
    space.use_derived_transformation_matrices(True)
    found, error, freedom = patch_values(measure("D65", 70, (), "rgb").stack("RGB"), len(names), size)
    relative, luminance = expected("D65")
    claim.agrees("film of linear BT.709, D65: RGB of 24 patches", found, luminance * relative[:-1] @ space.matrix_XYZ_to_RGB.T, error, freedom)

    nm, values, _ = measure("FL11", 80, ("--spectral", BINS)).spectrum()
    found, error, freedom = patch_values(values, len(names), size)
    bins = bin_means(witness, illuminant(*lights["FL11"][1:])[0])
    claim.bounded("centres of the spectral bins, nm", nm - (360 + 470 / BINS * (np.arange(BINS) + 0.5)), 1e-4)
    claim.agrees("spectral bins, FL11: 24 patches × 47", found, bins, error, freedom)
    # With --quick daylight alone, whose quadrature is fine enough with fewer samples.
    counts = 2 ** np.arange(8, 15 if claim.quick else 17, 2)
    series = {light: [regular(light, int(count)) for count in (counts[-1:] if claim.planted else counts)] for light in (("D65",) if claim.quick else LIGHTS)}
    claim.bounded(f"regular sampler, {counts[-1]} samples: relative error of XYZ", [of[-1][0] for of in series.values()], 1e-4)
    claim.bounded(f"regular sampler, {counts[-1]} samples: ΔE2000", [of[-1][1] for of in series.values()], 0.01)
    if claim.planted is None:
        converge(claim, counts, series)
        draw(claim, shown, np.concatenate(scores), freedom)


def bin_means(witness, light):
    """Mean of ρ S over each bin, by Simpson's rule on the finest grid: exact for products of two linear pieces. The light's table ends at ends of bins."""
    product = witness.rows[-1] * linear(light, grid(witness.steps[-1]), "hold").values
    per_bin = (product.shape[1] - 1) // BINS
    weights = np.ones(per_bin + 1)
    weights[1:-1:2], weights[2:-1:2] = 4, 2
    starts = per_bin * np.arange(BINS)
    centres = 360 + 470 / BINS * (np.arange(BINS) + 0.5)
    known = (centres > light.wavelengths[0]) & (centres < light.wavelengths[-1])
    return np.where(known, np.stack([product[:, start : start + per_bin + 1] @ weights for start in starts], 1) / weights.sum(), 0.0)


def draw(claim, shown, scores, freedom):
    figure, axes = plt.subplots(1, 3, figsize=(10, 3.1), width_ratios=(1, 1, 1.1))
    for panel, (light, found, relative) in zip(axes, (shown[0], shown[1] if claim.quick else shown[6])):
        white = relative[-1]
        ours, theirs = (np.clip(srgb(adapted(colours, white)), 0, 1) for colours in (found, relative[:-1]))
        for place, (outer, inner) in enumerate(zip(ours, theirs)):
            x, y = place % 6, -(place // 6)
            panel.add_patch(plt.Rectangle((x, y), 1, 1, color=outer, lw=0))
            panel.add_patch(plt.Rectangle((x + 0.25, y + 0.25), 0.5, 0.5, color=inner, lw=0))
        panel.set(xlim=(0, 6), ylim=(-3, 1), aspect="equal", xticks=[], yticks=[], title=light)
        panel.grid(False)
    edges = np.linspace(-4.5, 4.5, 37)
    axes[2].hist(scores, edges, density=True, color="#0072b2", alpha=0.6, label=f"{scores.size} values")
    axes[2].plot(edges, stats.t.pdf(edges, freedom), color="#d55e00", label="Student's distribution")
    axes[2].set(xlabel="(abbe − colour-science) / standard error")
    axes[2].legend(fontsize=7.5)
    claim.figure("chart", figure, "Rendered patches with colour-science's colour as a square in the middle of each, which cannot be seen where they are equal; adapted to daylight (Bradford) for the eye. Right: X, Y and Z of all patches and lights in units of their standard error.")


def converge(claim, counts, series):
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.1))
    for light, of in series.items():
        line = "o--" if light == LIGHTS[-1] else "o-"
        axes[0].loglog(counts, [np.abs(relative).max() for relative, _ in of], line)
        axes[1].loglog(counts, [differences.max() for _, differences in of], line, label=light)
    axes[0].set(xlabel="samples", ylabel="worst relative error of X, Y, Z")
    axes[1].set(xlabel="samples", ylabel="worst ΔE2000")
    axes[1].axhline(0.01, color="0.4", lw=0.8, ls="--")
    axes[1].legend(fontsize=7, ncols=2)
    claim.figure("convergence", figure, "Without randomness (regular sampler) the render comes to colour-science's absolute XYZ as it takes more wavelengths: what is left is the quadrature's error and no bias.")
