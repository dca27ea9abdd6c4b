"""The witness of the colour claims: colour-science with its own tables, put on fine grids by its own linear interpolator and summed by it.

abbe takes tables as piecewise linear, zero beyond the ends of an illuminant and held beyond those of a reflectance, and integrates the product of three such
functions exactly. colour-science sums over a grid. Where every node lies on the grid, its sum differs from the integral by a step that is linear in h, from the jumps where a table ends, and one that is
quadratic in h; for a product of three linear pieces there is nothing more. So (s(h) − 6 s(h/2) + 8 s(h/4)) / 3 is exact.
"""

import csv
from functools import cache

import colour
import numpy as np
from colour.quality import SDS_TCS
from colour.recovery import MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019

from make_reference import DAYLIGHT, ROOT, daylight, on_grid, read_table

OBSERVERS = {
    "cie1931": "CIE 1931 2 Degree Standard Observer",
    "cie1964": "CIE 1964 10 Degree Standard Observer",
    "cie2015-2": "CIE 2015 2 Degree Standard Observer",
    "cie2015-10": "CIE 2015 10 Degree Standard Observer",
}
# The lights of the detailed comparisons: incandescent, daylight, equal energy, a plain, a broad-band and a three-band fluorescent tube, an LED.
LIGHTS = ("A", "D50", "D65", "E", "FL2", "FL7", "FL11", "LED-B3")
STEP = 0.5  # nm; every node of every table lies on this grid


def grid(step):
    """Wavelengths (nm) over the range of the CIE 1931 observer."""
    return colour.SpectralShape(360, 830, step)


def linear(sd, shape, outside):
    """A spectral distribution of colour-science on a grid: linear between its nodes, beyond them 'zero' or 'hold'."""
    return on_grid(sd.wavelengths, sd.values, outside, shape)


@cache
def observer(name, step=STEP):
    """Colour-matching functions on the grid, linear between colour-science's values, zero outside them."""
    cmfs = colour.MSDS_CMFS[OBSERVERS[name]]
    parts = [linear(colour.SpectralDistribution(values, cmfs.wavelengths), grid(step), "zero").values for values in cmfs.values.T]
    return colour.MultiSpectralDistributions(np.transpose(parts), grid(step).wavelengths, labels=cmfs.labels)


LAMPS = {"60_A_W_Soft_White": "60 A/W (Soft White)", "C100S54_HPS": "C100S54 (HPS)"}


def illuminant(file, column):
    """colour-science's own distribution for a column of a table of abbe's data/, and where it is from."""
    if file.endswith("cie_a_formula_1nm"):
        return colour.colorimetry.sd_CIE_standard_illuminant_A(colour.SpectralShape(300, 830, 1)), "formula of illuminant A, every 1 nm"
    if file.endswith("light_sources_380_780_5nm"):
        return colour.SDS_LIGHT_SOURCES[LAMPS.get(column, column.replace("_", " "))], "SDS_LIGHT_SOURCES"
    sd = colour.SDS_ILLUMINANTS[column]
    if column not in DAYLIGHT:
        return sd, "SDS_ILLUMINANTS"
    nm, values = daylight(column, sd.wavelengths, sd.values)
    return colour.SpectralDistribution(values, nm), "SDS_ILLUMINANTS, from 785 nm sd_CIE_illuminant_D_series"


def reflectance(file, column):
    """The same for a reflectance; what colour-science has not is read from data/."""
    charts = {"colorchecker_babelcolor_average_10nm": "BabelColor Average", "colorchecker_ohta1997_5nm": "ColorChecker N Ohta"}
    name = file.split("/")[-1]
    if name in charts:
        return colour.SDS_COLOURCHECKERS[charts[name]][column.replace("_", " ")], "SDS_COLOURCHECKERS"
    if name == "cie13_3_tcs_5nm":
        return SDS_TCS["CIE 1995"][column], "SDS_TCS"
    if name == "mallett_yuksel_2019_srgb_5nm":
        basis = MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019
        return basis.signals[column].__class__(basis.signals[column].values, basis.wavelengths), "MSDS_BASIS_FUNCTIONS_sRGB_MALLETT2019"
    columns, table = read_table(ROOT / "data" / f"{file}.csv")
    return colour.SpectralDistribution(table[:, 1 + columns.index(column)], table[:, 0]), "data/"


def catalogue(abbe, kind):
    """(name, file, column) of every entry of a kind in abbe's catalogue, in its order."""
    return [tuple(entry) for entry in abbe.probe([{"colour": {"catalogue": {"kind": kind}}}])[0]]


def ask(abbe, question, **what):
    """The answer of the library to one question (probe/colour.rs). Arrays become lists."""
    plain = {name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in what.items()}
    return abbe.probe([{"colour": {question: plain}}])[0]


class Surfaces:
    """Reflectances as rows on the grids of the steps h, h/2 and h/4."""

    def __init__(self, sds, step=STEP):
        self.steps = (step, step / 2, step / 4)
        self.rows = [np.array([linear(sd, grid(h), "hold").values for sd in sds]) for h in self.steps]

    def colours(self, light, name="cie1931"):
        """XYZ of each under a light, and last that of a perfect white, whose Y is 1: extrapolated, and as summed on the finest grid."""
        sums = []
        for h, rows in zip(self.steps, self.rows):
            with_white = np.vstack([rows, np.ones(len(grid(h).wavelengths))])
            sums.append(colour.msds_to_XYZ(with_white, observer(name, h), linear(light, grid(h), "zero"), k=1, method="Integration", shape=grid(h)))
        exact = (sums[0] - 6 * sums[1] + 8 * sums[2]) / 3
        return exact / exact[-1, 1], sums[2] / sums[2][-1, 1]

    def luminance(self, light, name="cie1931"):
        """∫ S ȳ dλ, in the light's unit times nm."""
        sums = [h * linear(light, grid(h), "zero").values @ observer(name, h).values[:, 1] for h in self.steps]
        return (sums[0] - 6 * sums[1] + 8 * sums[2]) / 3


def white_xy(xyz):
    """Chromaticity of tristimulus values."""
    return colour.XYZ_to_xy(xyz)


def lab(xyz, white):
    """CIELAB by colour-science, relative to the tristimulus values of white."""
    return colour.XYZ_to_Lab(xyz, white_xy(white))


def delta_e(a, b):
    """CIEDE2000 by colour-science."""
    return colour.delta_E(a, b, method="CIE 2000")


def srgb(xyz):
    """What a screen shows, clipped: for swatches. White is Y = 1 of D65."""
    linear_rgb = colour.XYZ_to_RGB(xyz, "sRGB", apply_cctf_encoding=False)
    return np.clip(colour.cctf_encoding(np.clip(linear_rgb, 0, 1), "sRGB"), 0, 1)


def adapted(xyz, white):
    """The colour in daylight that looks like this one under `white` (Bradford), so that swatches of all lights can stand side by side."""
    d65 = colour.xy_to_XYZ(colour.CCS_ILLUMINANTS[OBSERVERS["cie1931"]]["D65"])
    return colour.chromatic_adaptation(xyz, white, d65, method="Von Kries", transform="Bradford")


COLUMNS = 6


def chart(path, surfaces, light, size=16, scale=1.0, pixel_format="xyz"):
    """A scene of diffuse patches in rows of six, each `size` × `size` pixels seen from straight above, under light that falls straight down: its irradiance is π times the
    illuminant's table, so that a patch has the radiance ρ(λ) S(λ). Nothing is random in it but wavelengths.

    `surfaces` are names of abbe's catalogue, or (nm, values): those keep their end values, which scene files say by further nodes (such a spectrum is zero outside).
    """
    rows = -(-len(surfaces) // COLUMNS)
    parts = []
    for place, surface in enumerate(surfaces):
        if isinstance(surface, str):
            spectrum = f'<spectrum name="reflectance" type="measured"><string name="name" value="{surface}"/></spectrum>'
        else:
            nm, reflected = surface
            nodes = zip([300.0, *nm, 900.0], [reflected[0], *reflected, reflected[-1]])
            values = ", ".join(f"{node:.6g}:{float(value)!r}" for node, value in nodes)
            spectrum = f'<spectrum name="reflectance" value="{values}"/>'
        x, y = (2 * (place % COLUMNS) + 1) / COLUMNS - 1, (rows - 1 - 2 * (place // COLUMNS)) / COLUMNS
        parts.append(
            f'<shape type="rectangle"><transform name="to_world"><scale value="{1 / COLUMNS!r}"/><translate x="{x!r}" y="{y!r}"/></transform><bsdf type="diffuse">{spectrum}</bsdf></shape>'
        )
    path.write_text(
        f"""<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="2"/></integrator>
<sensor type="orthographic"><transform name="to_world"><lookat origin="0, 0, 1" target="0, 0, 0" up="0, 1, 0"/></transform>
<film type="hdrfilm"><integer name="width" value="{COLUMNS * size}"/><integer name="height" value="{rows * size}"/><string name="pixel_format" value="{pixel_format}"/><rfilter type="box"/></film></sensor>
<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/>
<spectrum name="irradiance" type="measured"><string name="name" value="{light}"/><float name="scale" value="{np.pi * scale!r}"/></spectrum></emitter>
{chr(10).join(parts)}
</scene>"""
    )
    return path


def patch_values(picture_values, count, size=16):
    """Mean of each patch of a chart, its standard error, and the degrees of freedom of that: pixels are independent of one another."""
    height, width, channels = picture_values.shape
    blocks = picture_values.reshape(height // size, size, width // size, size, channels).transpose(0, 2, 1, 3, 4).reshape(-1, size * size, channels)[:count]
    return blocks.mean(1), blocks.std(1, ddof=1) / size, size * size - 1
