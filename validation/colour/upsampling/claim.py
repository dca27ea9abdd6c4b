"""Upsampling: colours to reflectances and back

The reflectance that abbe makes for a colour (Jakob and Hanika 2019: S(a λ² + b λ + c), S(x) = ½ + x / 2√(1 + x²)) lies between 0 and 1, is smooth, has the colour that it was made for, and is the spectrum
that Mitsuba 3 takes for it.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt
from matplotlib.colors import LogNorm

from colour_common import OBSERVERS, ask, delta_e, grid, illuminant, lab, linear, observer

METHOD = """Grids and random colours of the cube of linear BT.709, its faces and corners included, and all display values near white. The coefficients are turned into a spectrum here, by the paper's formula,
and this into a colour by colour-science with its D65 and its observer. There are two round trips. *As made*: with Mitsuba's matrix, its white and its observer every 5 nm, for which the model was
made so that both programs see the same spectra; what is left is the interpolation in a table of 64³ coefficients for each largest component. *As seen*: with the observer of every 1 nm
and the matrix of BT.709, which is what a render of abbe does; the two conventions differ by some 0.02.

The bound of 0.01 that holds for everything else in this group can be held by no table of this kind: the paper's own, which Mitsuba ships, does not (first table). What is asked is that the median
over the cube is below 0.01 as made, that no colour is off by 1, that which can just be seen, and that abbe is as good as Mitsuba's table. Towards black and towards white coefficients grow without end; where a
search for them stops is its own business there, and the spectra of the two programs differ where it cannot be seen."""
DATA = """W. Jakob, J. Hanika, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", Computer Graphics Forum 38 (2019). Mitsuba 3.9.1: `srgb_model_fetch` (single precision).
colour-science 0.4.7: D65, observer, and its own search for the coefficients of a single colour, `recovery.XYZ_to_sd_Jakob2019`."""

# From XYZ to linear BT.709 as Mitsuba has it (C. Poynton, "Frequently Asked Questions about Color"), whose white is not quite D65.
MITSUBA = np.array([[3.240479, -1.537150, -0.498535], [-0.969256, 1.875991, 0.041556], [0.055648, -0.204043, 1.057311]])
STEP = 1.0  # nm, of the sums over these smooth spectra
PLANTED = [
    Planted("colours upsampled 0.1 % too dark", caught_by=("as made: ΔE2000, median", "Mitsuba's spectra"), mutant="colour_dark_upsampling"),
    Planted("spectra shifted by 0.1 nm", caught_by=("as made: ΔE2000, median", "Mitsuba's spectra")),
]


def spectra(coefficients):
    """Colours × wavelengths. Black and white have infinite coefficients, told as null."""
    nm = grid(STEP).wavelengths
    a, b, c = (np.array([[np.nan if value is None else value for value in triple] for triple in coefficients], dtype=float).T)[..., None]
    x = (a * nm + b) * nm + c
    return 0.5 + 0.5 * x / np.sqrt(1 + x * x)


def colours(cube):
    """A grid over the cube, what displays show near white, dark and saturated colours, and last `cube` uniformly random ones."""
    random = np.random.default_rng(1)
    axis = np.linspace(0, 1, 9 if cube < 5000 else 17)
    regular = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    levels = colour.models.eotf_sRGB(np.array([230, 240, 245, 250, 252, 253, 254, 255]) / 255)
    bright = np.stack(np.meshgrid(levels, levels, levels, indexing="ij"), -1).reshape(-1, 3)
    rgb = np.vstack([regular, bright, random.random((cube // 4, 3)) ** 4, random.random((cube, 3))])
    return rgb[(rgb.max(1) > 0) & (rgb.min(1) < 1)]  # black and white are exact, and tested beside


def run(claim):
    import mitsuba as mi

    mi.set_variant("scalar_spectral")
    count = 1_000 if claim.quick else 4_000
    rgb = colours(count)
    nm = grid(STEP).wavelengths
    shown = np.array([400.0, 500.0, 555.0, 700.0])
    told = ask(claim.abbe, "upsampled", rgb=rgb, nm=shown)
    coefficients = np.array(told["coefficients"])
    if claim.planted == PLANTED[1].what:
        a, b, c = coefficients.T
        coefficients = np.stack([a, b + 0.2 * a, c + 0.1 * b + 0.01 * a], -1)
    ours = spectra(coefficients)
    theirs = spectra(np.array([np.ravel(mi.srgb_model_fetch(mi.Color3f(*(float(v) for v in colour)))) for colour in rgb]))
    at = np.searchsorted(nm, shown)
    claim.bounded("values by the paper's formula are abbe's", ours[:, at] - np.array(told["values"]), 1e-9)
    ends = np.array(ask(claim.abbe, "upsampled", rgb=[[0, 0, 0], [1, 1, 1], [0.25, 0.25, 0.25]], nm=nm)["values"])
    claim.bounded("black, white and grey are flat and exact", ends - [[0], [1], [0.25]], 1e-15)
    claim.holds("all values lie between 0 and 1", bool((ours >= 0).all() and (ours <= 1).all()), f"{ours.min():.2g} to {ours.max():.7g}", "0 to 1", "any value outside")
    turns = (np.diff(np.sign(np.diff(ours, axis=1)), axis=1) != 0).sum(1)
    claim.bounded("turns of a spectrum (a quadratic has one)", turns * (np.ptp(ours, axis=1) > 1e-12), 1)

    light = linear(illuminant("", "D65")[0], grid(STEP), "zero")
    seen = colour.models.RGB_COLOURSPACE_sRGB.copy()
    seen.use_derived_transformation_matrices(True)
    coarse = colour.MSDS_CMFS[OBSERVERS["cie1931"]].copy().align(grid(5))
    coarse = colour.MultiSpectralDistributions(np.stack([np.interp(nm, coarse.wavelengths, column) for column in coarse.values.T], 1), nm)

    def trip(values, cmfs, to_xyz, white=None):
        """ΔE2000 between the wanted colours and those of spectra."""
        xyz = colour.msds_to_XYZ(np.vstack([values, np.ones(len(nm))]), cmfs, light, method="Integration", shape=grid(STEP)) / 100
        target = to_xyz.sum(1)
        return delta_e(lab(xyz[:-1], xyz[-1] if white is None else white), lab(rgb @ to_xyz.T, target))

    poynton = np.linalg.inv(MITSUBA)
    results = {
        ("abbe", "as made"): trip(ours, coarse, poynton, poynton.sum(1)),
        ("Mitsuba", "as made"): trip(theirs, coarse, poynton, poynton.sum(1)),
        ("abbe", "as seen"): trip(ours, observer("cie1931", STEP), seen.matrix_RGB_to_XYZ),
        ("Mitsuba", "as seen"): trip(theirs, observer("cie1931", STEP), seen.matrix_RGB_to_XYZ),
    }
    places = (50, 90, 99, 100)
    quantiles = {key: np.percentile(values, places) for key, values in results.items()}
    claim.table(
        ("round trip", "", "median", "90 %", "99 %", "worst", "colour of the worst", "share below 0.01"),
        [(key[1], key[0], *(f"{q:.4f}" for q in quantiles[key]), np.array2string(rgb[values.argmax()], precision=3), f"{100 * (values < 0.01).mean():.0f} %") for key, values in results.items()],
        f"ΔE2000 of {len(rgb)} colours that went to a spectrum and back. What abbe leaves is what the paper's table leaves.",
    )
    claim.bounded("as made: ΔE2000, median of uniformly random colours", np.median(results["abbe", "as made"][-count:]), 0.01)
    claim.bounded("as made: ΔE2000, worst", quantiles["abbe", "as made"][-1], 1)
    claim.bounded("as seen: ΔE2000, worst", quantiles["abbe", "as seen"][-1], 1)
    of_random = [np.percentile(results[who, "as made"][-count:], places[:3]) for who in ("abbe", "Mitsuba")]
    claim.bounded("as made: median, 90 % and 99 % of uniformly random colours, over Mitsuba's", of_random[0] / of_random[1], 1.02)
    difference = np.abs(ours - theirs).max(1)
    plain = (rgb.max(1) > 0.03) & (rgb.max(1) < 0.97)
    claim.bounded("Mitsuba's spectra, largest component 0.03 to 0.97: values", difference[plain], 2e-4)
    pair = [lab(colour.msds_to_XYZ(values, observer("cie1931", STEP), light, method="Integration", shape=grid(STEP)) / 100, seen.matrix_RGB_to_XYZ.sum(1)) for values in (ours, theirs)]
    between = delta_e(*pair)
    claim.bounded("Mitsuba's spectra, largest component 0.03 to 0.97: ΔE2000", between[plain], 0.01)
    claim.bounded("Mitsuba's spectra, all: ΔE2000", between, 0.2)
    if claim.planted is None:
        faces(claim, mi, light, seen)
        examples(claim, mi)


def faces(claim, mi, light, seen):
    """ΔE over the three faces of the cube on which a component is 1, and over those where one is 0."""
    side = 33 if claim.quick else 49
    axis = np.linspace(0, 1, side)
    figure, axes = plt.subplots(2, 3, figsize=(9, 5.6))
    for row, fixed in enumerate((1.0, 0.0)):
        for k, name in enumerate("RGB"):
            rgb = np.full((side, side, 3), fixed)
            rgb[..., (k + 1) % 3], rgb[..., (k + 2) % 3] = axis[None, :], axis[:, None]
            flat = np.clip(rgb.reshape(-1, 3), 0, 1)
            pure = (flat.max(1) == 0) | (flat.min(1) == 1)
            flat[pure] = 0.5
            values = spectra(ask(claim.abbe, "upsampled", rgb=flat, nm=[])["coefficients"])
            xyz = colour.msds_to_XYZ(np.vstack([values, np.ones(values.shape[1])]), observer("cie1931", STEP), light, method="Integration", shape=grid(STEP)) / 100
            to_xyz = seen.matrix_RGB_to_XYZ
            difference = delta_e(lab(xyz[:-1], xyz[-1]), lab(flat @ to_xyz.T, to_xyz.sum(1)))
            difference[pure] = np.nan
            image = axes[row, k].imshow(difference.reshape(side, side), origin="lower", extent=(0, 1, 0, 1), norm=LogNorm(1e-3, 0.3), cmap="viridis")
            axes[row, k].set(title=f"{name} = {fixed:.0f}", xlabel="RGB"[(k + 1) % 3], ylabel="RGB"[(k + 2) % 3])
            axes[row, k].grid(False)
    figure.colorbar(image, ax=axes, label="ΔE2000, as seen")
    claim.figure("faces", figure, "Round trip over the six faces of the cube of linear BT.709. The pattern is that of the table's cells: between its nodes coefficients are interpolated, and dark colours lie furthest from nodes.")


def examples(claim, mi):
    names = {"red": (1, 0, 0), "orange": (0.8, 0.3, 0.05), "green": (0.1, 0.5, 0.15), "sky": (0.2, 0.4, 0.8), "rose": (1, 0.9375, 1)}
    figure, axes = plt.subplots(figsize=(8, 3.3))
    nm = grid(STEP).wavelengths
    to_xyz = colour.models.RGB_COLOURSPACE_sRGB.matrix_RGB_to_XYZ
    for name, rgb in names.items():
        ink = np.clip(colour.cctf_encoding(np.array(rgb), "sRGB"), 0, 0.9)
        axes.plot(nm, spectra(ask(claim.abbe, "upsampled", rgb=[rgb], nm=[])["coefficients"])[0], color=ink, lw=4, alpha=0.45)
        axes.plot(nm, spectra([np.ravel(mi.srgb_model_fetch(mi.Color3f(*map(float, rgb))))])[0], color="k", lw=0.7)
        if not claim.quick and name != "rose":
            sd = colour.recovery.XYZ_to_sd_Jakob2019(np.array(rgb) @ to_xyz.T)
            axes.plot(sd.wavelengths[::2], sd.values[::2], "o", color=ink, mec="k", mew=0.4, ms=3)
    axes.set(xlabel="wavelength, nm", ylabel="reflectance", ylim=(-0.02, 1.02))
    claim.figure("spectra", figure, "Reflectances made for five colours: abbe (broad), Mitsuba (thin black), and colour-science's own search (dots; from 360 to 780 nm with its own weights of colour, so it ends in another spectrum where a colour has several of nearly equal colour). The rose is (1, 0.9375, 1), near white.")
