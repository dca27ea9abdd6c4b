"""Computes the colours that tests/fast/colour.rs holds this project against, with colour-science.

    ../.venv/bin/python make_reference.py      (validation/run makes the environment)

Writes ../../tests/data/{reflected_xyz,illuminant_xyz,blackbody_xy,delta_e_2000}.csv.

Everything spectral is done by colour-science with its own colour-matching functions. The published tables in data/ are
read, put on a grid by its linear interpolator (illuminants are zero outside their table, reflectances keep the end value)
and integrated by `sd_to_XYZ(method="Integration")`. The grid is 0.1 nm: at 1 nm the rectangle rule itself errs by
up to 0.16 units of colour difference where a lamp is all lines (low-pressure sodium), which would hide what is being tested.
"""

import csv
from pathlib import Path

import colour
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SHAPE = colour.SpectralShape(360, 830, 0.1)
OBSERVER = "CIE 1931 2 Degree Standard Observer"

# Correlated colour temperatures that name the CIE daylight illuminants, on the present scale: nominal times 1.4388/1.4380.
DAYLIGHT = {name: nominal * 1.4388 / 1.4380 for name, nominal in {"D50": 5000, "D55": 5500, "D65": 6500, "D75": 7500}.items()}


def read_table(path):
    """Column names and values of one of the tables in data/."""
    rows = [row for row in csv.reader(line for line in path.read_text().splitlines() if not line.startswith("#"))]
    return rows[0][1:], np.array(rows[1:], dtype=float)


def on_grid(nm, values, outside, shape=SHAPE):
    """The table on a grid: linear between its nodes, `outside` ('zero' or 'hold') beyond them."""
    ends = {"left": 0.0, "right": 0.0} if outside == "zero" else {"left": values[0], "right": values[-1]}
    sd = colour.SpectralDistribution(
        values,
        nm,
        interpolator=colour.LinearInterpolator,
        interpolator_kwargs={},
        extrapolator=colour.Extrapolator,
        extrapolator_kwargs={"method": "Constant", **ends},
    )
    return colour.SpectralDistribution(sd[shape.wavelengths], shape.wavelengths)


def daylight(name, nm, values):
    """A CIE daylight illuminant, continued beyond its table by the CIE formula (colour-science's own basis functions)."""
    xy = colour.temperature.CCT_to_xy_CIE_D(DAYLIGHT[name])
    formula = colour.sd_CIE_illuminant_D_series(xy, shape=colour.SpectralShape(300, 830, 5))
    beyond = np.array([(w, v) for w, v in zip(formula.wavelengths, formula.values) if w > nm[-1]])
    return np.append(nm, beyond[:, 0]), np.append(values, beyond[:, 1])


def spectra(folder, outside):
    """(file, column, spectral distribution) of every column of every table in a folder of data/."""
    for path in sorted((ROOT / "data" / folder).glob("*.csv")):
        if "daylight_basis" in path.name:
            continue
        columns, table = read_table(path)
        for i, column in enumerate(columns):
            nm, values = table[:, 0], table[:, 1 + i]
            if path.name == "cie_a_c_daylight_5nm.csv" and column in DAYLIGHT:
                nm, values = daylight(column, nm, values)
            yield path.stem, column, on_grid(nm, values, outside)


def tristimulus(sd, cmfs, illuminant=None):
    with np.errstate(all="ignore"):
        return colour.sd_to_XYZ(sd, cmfs, illuminant, k=None, method="Integration") / 100


def write(name, header, columns, rows):
    path = ROOT / "tests" / "data" / name
    with path.open("w", newline="\n") as file:
        file.writelines(f"# {line}\n" for line in header)
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(rows)
    print(path.relative_to(ROOT), "written")


# G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula: Implementation Notes, Supplementary Test Data, and
# Mathematical Observations", Color Research and Application 30 (2005), table 1: two colours and their difference.
SHARMA = """
50 2.6772 -79.7751 50 0 -82.7485 2.0425
50 3.1571 -77.2803 50 0 -82.7485 2.8615
50 2.8361 -74.0200 50 0 -82.7485 3.4412
50 -1.3802 -84.2814 50 0 -82.7485 1.0000
50 -1.1848 -84.8006 50 0 -82.7485 1.0000
50 -0.9009 -85.5211 50 0 -82.7485 1.0000
50 0 0 50 -1 2 2.3669
50 -1 2 50 0 0 2.3669
50 2.4900 -0.0010 50 -2.4900 0.0009 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0010 7.1792
50 2.4900 -0.0010 50 -2.4900 0.0011 7.2195
50 2.4900 -0.0010 50 -2.4900 0.0012 7.2195
50 -0.0010 2.4900 50 0.0009 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0010 -2.4900 4.8045
50 -0.0010 2.4900 50 0.0011 -2.4900 4.7461
50 2.5 0 50 0 -2.5 4.3065
50 2.5 0 73 25 -18 27.1492
50 2.5 0 61 -5 29 22.8977
50 2.5 0 56 -27 -3 31.9030
50 2.5 0 58 24 15 19.4535
50 2.5 0 50 3.1736 0.5854 1.0000
50 2.5 0 50 3.2972 0 1.0000
50 2.5 0 50 1.8634 0.5757 1.0000
50 2.5 0 50 3.2592 0.3350 1.0000
60.2574 -34.0099 36.2677 60.4626 -34.1751 39.4387 1.2644
63.0109 -31.0961 -5.8663 62.8187 -29.7946 -4.0864 1.2630
61.2901 3.7196 -5.3901 61.4292 2.2480 -4.9620 1.8731
35.0831 -44.1164 3.7933 35.0232 -40.0716 1.5901 1.8645
22.7233 20.0904 -46.6940 23.0331 14.9730 -42.5619 2.0373
36.4612 47.8580 18.3852 36.2715 50.5065 21.2231 1.4146
90.8027 -2.0831 1.4410 91.1528 -1.6435 0.0447 1.4441
90.9257 -0.5406 -0.9208 88.6381 -0.8985 -0.7239 1.5381
6.7747 -0.2908 -2.4247 5.8714 -0.0985 -2.2286 0.6377
2.0776 0.0795 -1.1350 0.9033 -0.0636 -0.5514 0.9082
"""


def main():
    made = f"computed by validation/colour/make_reference.py with colour-science {colour.__version__}"
    cmfs = colour.MSDS_CMFS[OBSERVER].copy().align(SHAPE, interpolator=colour.LinearInterpolator)
    lights = list(spectra("illuminants", "zero"))
    surfaces = [*spectra("reflectance", "hold"), *spectra("rgb_upsampling", "hold")]

    whites, colours = [], []
    white_reflector = colour.SpectralDistribution(np.ones(len(SHAPE.wavelengths)), SHAPE.wavelengths)
    stacked = colour.MultiSpectralDistributions(np.transpose([sd.values for _, _, sd in surfaces]), SHAPE.wavelengths)
    for file, column, light in lights:
        white = tristimulus(white_reflector, cmfs, light)
        whites.append([file, column, *(f"{v:.12g}" for v in white)])
        all_xyz = colour.msds_to_XYZ(stacked, cmfs, light, method="Integration") / 100
        # The many-at-once call is the same computation; the first of each is checked against the single one.
        assert np.allclose(all_xyz[0], tristimulus(surfaces[0][2], cmfs, light), rtol=1e-12)
        for (surface_file, surface_column, _), xyz in zip(surfaces, all_xyz, strict=True):
            colours.append([file, column, surface_file, surface_column, *(f"{v:.9g}" for v in xyz)])

    scale = "units: XYZ for the CIE 1931 2 degree observer, 360 to 830 nm; a perfect white reflector has Y = 1"
    write("illuminant_xyz.csv", [f"source: {made}", scale], ["illuminant_file", "illuminant", "X", "Y", "Z"], whites)
    write(
        "reflected_xyz.csv",
        [f"source: {made}", scale],
        ["illuminant_file", "illuminant", "reflectance_file", "reflectance", "X", "Y", "Z"],
        colours,
    )

    # Exact SI constants (colour-science's defaults are the older, rounded ones of ITS-90).
    h, c, k = 6.62607015e-34, 299792458.0, 1.380649e-23
    bodies = []
    for kelvin in range(1000, 10001, 250):
        radiance = colour.colorimetry.planck_law(SHAPE.wavelengths * 1e-9, kelvin, c1=2 * np.pi * h * c * c, c2=h * c / k)
        sd = colour.SpectralDistribution(np.ravel(radiance), SHAPE.wavelengths)
        bodies.append([kelvin, *(f"{v:.9f}" for v in colour.XYZ_to_xy(tristimulus(sd, cmfs)))])
    write("blackbody_xy.csv", [f"source: {made}", "units: temperature K; chromaticity, CIE 1931"], ["kelvin", "x", "y"], bodies)

    pairs = []
    for line in SHARMA.split("\n")[1:-1]:
        numbers = [float(number) for number in line.split()]
        difference = colour.delta_E(numbers[:3], numbers[3:6], method="CIE 2000")
        pairs.append([*numbers[:6], f"{difference:.12f}", numbers[6]])
    header = [
        f"source: test pairs of Sharma, Wu and Dalal 2005, table 1 (published); delta_e {made}",
        "units: CIELAB; CIEDE2000",
    ]
    write("delta_e_2000.csv", header, ["L1", "a1", "b1", "L2", "a2", "b2", "delta_e", "published"], pairs)


if __name__ == "__main__":
    main()
