"""Colour spaces: CIELAB both ways, linear BT.709 both ways, the transfer function of sRGB, display values

abbe's conversions are those of CIE 15:2018 (CIELAB), ITU-R BT.709-6 (primaries, white) and IEC 61966-2-1 (transfer function), in double precision.
"""

import colour
import numpy as np
from colour.models import RGB_COLOURSPACE_sRGB
from harness.claim import Planted
from harness.plots import plt

from colour_common import ask

METHOD = """Random colours and a grid of them, in and out of gamut, among them the dark ones about the linear part of CIELAB and of sRGB. abbe's matrix follows from the primaries and
the white of the standard with full precision, so colour-science uses its derived matrix (`use_derived_matrix_XYZ_to_RGB`); its default is the matrix that IEC 61966-2-1 prints with four decimals, and
the table says what that rounding makes. Display values are compared as `#rrggbb`: colour-science rounds down where abbe rounds to the nearest, so its 8 bits are rounded here."""
DATA = """colour-science 0.4.7: `XYZ_to_Lab`, `Lab_to_XYZ`, `RGB_COLOURSPACE_sRGB`, `eotf_inverse_sRGB`, `eotf_sRGB`, `CCS_ILLUMINANTS`. The whites tried are those of D65, A and FL11."""

PLANTED = [
    Planted("white off by 10⁻⁴ in x (0.3128 for 0.3127)", caught_by=("linear BT.709 of XYZ",)),
    Planted("knee of sRGB's curve at 0.0035 instead of 0.0031308", caught_by=("sRGB encoding",), mutant="colour_srgb_knee"),
    Planted("the linear part of CIELAB ends at 0.0080 instead of 0.008856", caught_by=("CIELAB of XYZ",), mutant="colour_lab_knee"),
]


def run(claim):
    random = np.random.default_rng(1)
    count = 2_000 if claim.quick else 10_000
    xyz = np.vstack([random.random((count, 3)) * [1.0, 1.0, 1.1], random.random((count, 3)) * 0.02, np.geomspace(1e-6, 10, 200)[:, None] * [0.95, 1, 1.09]])
    for name in ("D65", "A", "FL11"):
        xy = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][name]
        white = colour.xy_to_XYZ(xy)
        told = ask(claim.abbe, "from_xyz", xyz=xyz, white=white)
        expected = colour.XYZ_to_Lab(xyz, xy)
        claim.bounded(f"CIELAB of XYZ, white {name}", np.array(told["lab"]) - expected, 1e-9)
        back = np.array(ask(claim.abbe, "from_lab", lab=expected, white=white))
        claim.bounded(f"XYZ of CIELAB, white {name}, by colour-science", back - colour.Lab_to_XYZ(expected, xy), 1e-12)
        claim.bounded(f"XYZ of CIELAB, white {name}, there and back", back - xyz, 1e-12)
    claim.bounded("x and y of XYZ", np.array(told["xy"]) - colour.XYZ_to_xy(xyz), 1e-12)

    space = RGB_COLOURSPACE_sRGB.copy()
    space.use_derived_transformation_matrices(True)
    if claim.planted == PLANTED[0].what:
        space.whitepoint = np.array([0.3128, 0.3290])
    expected = xyz @ space.matrix_XYZ_to_RGB.T
    found = np.array(told["rec709"])
    claim.bounded("linear BT.709 of XYZ", found - expected, 1e-12)
    rgb = np.vstack([random.uniform(-0.5, 2, (count, 3)), np.eye(3), np.ones((1, 3))])
    claim.bounded("XYZ of linear BT.709", np.array(ask(claim.abbe, "from_rec709", rgb=rgb)) - rgb @ space.matrix_RGB_to_XYZ.T, 1e-12)
    rounded = xyz @ RGB_COLOURSPACE_sRGB.matrix_XYZ_to_RGB.T

    # Beside the knees, too. Decoding's is 0.04045 in the standard and in abbe, 12.92 · 0.0031308 = 0.040449936 in colour-science: what lies between differs by the
    # 2·10⁻⁹ by which the standard's two rounded knees miss each other, and is left out.
    values = np.concatenate([np.linspace(0, 1, count), np.geomspace(1e-9, 1, 1000), 0.0031308 + np.array([-1e-6, -1e-12, 1e-12, 1e-6]), 0.04045 + np.array([-1e-6, -1e-7, 1e-12, 1e-6])])
    told_transfer = ask(claim.abbe, "transfer", values=values)
    encoded = colour.models.eotf_inverse_sRGB(values)
    claim.bounded("sRGB encoding", np.array(told_transfer["encoded"]) - encoded, 1e-12)
    claim.bounded("sRGB decoding", np.array(told_transfer["decoded"]) - colour.models.eotf_sRGB(values), 1e-9)
    negative = ask(claim.abbe, "transfer", values=-values)
    claim.bounded("sRGB of negative values is odd", np.array(negative["encoded"]) + np.array(told_transfer["encoded"]), 1e-15)

    display = np.round(255 * colour.models.eotf_inverse_sRGB(np.clip(expected, 0, 1))).astype(int)
    wrong = sum(told_hex != "#%02x%02x%02x" % tuple(value) for told_hex, value in zip(told["hex"], display))
    claim.bounded(f"display values that differ, of {len(xyz)}", wrong, 0.5)
    if claim.planted is None:
        bits = np.round(255 * colour.models.eotf_inverse_sRGB(np.clip(rounded, 0, 1))).astype(int)
        moved = (bits != display).any(1).mean()
        claim.table(
            ("", "largest difference of linear values in 0…1", "display values that change"),
            [("matrix of IEC 61966-2-1, four decimals, for abbe's", f"{np.abs(rounded - expected)[(xyz.max(1) <= 1)].max():.1e}", f"{100 * moved:.2f} % by 1 of 255")],
            "What the rounded matrix that is printed in the standard would change.",
        )
        draw(claim, values, np.array(told_transfer["encoded"]), encoded, xyz, found, expected, rounded)


def draw(claim, values, ours, encoded, xyz, found, expected, rounded):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.3))
    order = np.argsort(values)
    left.loglog(values[order], encoded[order], color="#d55e00", lw=3, alpha=0.5, label="colour-science")
    left.loglog(values[order], ours[order], color="#0072b2", lw=0.8, label="abbe")
    left.axvline(0.0031308, color="0.6", lw=0.8, ls=":")
    left.set(xlabel="linear", ylabel="encoded, sRGB")
    left.legend()
    bins = np.geomspace(1e-18, 1e-2, 49)
    right.hist(np.abs(rounded - expected).ravel() + 1e-18, bins, alpha=0.6, color="0.5", label="rounded matrix of the standard")
    right.hist(np.abs(found - expected).ravel() + 1e-18, bins, alpha=0.7, color="#0072b2", label="abbe")
    right.set(xscale="log", xlabel="difference of linear values from colour-science", ylabel="values")
    right.legend(fontsize=7.5)
    claim.figure("transfer", figure, "Left: the transfer function of sRGB; dotted the knee. Right: linear values of random colours against colour-science: abbe differs by rounding in double precision alone.")
