"""Black bodies: spectral radiance and chromaticity from 1000 to 10000 K

abbe's black body is Planck's law with the exact constants of the SI (2019), L = 2 h c² λ⁻⁵ / (exp(h c / λ k T) − 1), and its chromaticity is that of the CIE 1931 observer.
"""

import colour
import mpmath
import numpy as np
from harness.claim import Planted
from harness.plots import plt

from colour_common import ask, delta_e, grid, lab, observer

METHOD = """Radiance: against mpmath with 50 digits, and against colour-science's `planck_law`, which is given the same constants (its defaults are the rounded ones of ITS-90).
Chromaticity: colour-science sums its radiance with its observer every 0.1 and 0.05 nm, extrapolated to step 0; abbe integrates in pieces of 1 nm by Gauss's two-point rule,
which is exact for a cubic, so the fourth derivative of Planck's law bounds its error. ΔE2000 is that of the two whites, each with Y = 1, under D65."""
DATA = """h, c and k: SI Brochure, 9th edition (BIPM 2019). Observer: colour-science's `MSDS_CMFS`."""

H, C, K = 6.62607015e-34, 299792458.0, 1.380649e-23
OLD = "the second radiation constant of ITS-90 (1.6·10⁻⁵ larger)"
PLANTED = [
    Planted(OLD, caught_by=("radiance, mpmath", "radiance, colour-science"), mutant="colour_old_radiation_constant"),
    Planted("temperatures 10⁻⁵ too high", caught_by=("radiance, mpmath", "radiance, colour-science", "x and y")),
    Planted("colour-matching functions shifted by 0.1 nm", caught_by=("x and y", "ΔE2000"), mutant="colour_shifted_observer"),
]


def planck(nm, kelvin):
    """Spectral radiance with 50 digits, W·m⁻²·sr⁻¹·nm⁻¹."""
    with mpmath.workdps(50):
        h, c, k, wave = (mpmath.mpf(text) for text in ("6.62607015e-34", "299792458", "1.380649e-23", str(nm)))
        wave = wave * mpmath.mpf("1e-9")
        return float(2 * h * c**2 / wave**5 / mpmath.expm1(h * c / (wave * k * kelvin)) * mpmath.mpf("1e-9"))


def theirs(nm, kelvin):
    """colour-science's radiance with the SI's constants, in the same unit; temperatures × wavelengths. c1 = 2π h c² there is of exitance, its law divides by π."""
    radiance = colour.colorimetry.planck_law(np.asarray(nm) * 1e-9, np.asarray(kelvin, dtype=float), c1=2 * np.pi * H * C * C, c2=H * C / K)
    return np.atleast_2d(np.transpose(radiance)) * 1e-9


def run(claim):
    kelvin = np.arange(1000, 10001, 1000 if claim.quick else 250).astype(float)
    nm = np.arange(360.0, 831.0, 47.0 if claim.quick else 10.0)
    asked = kelvin * (1 + 1e-5) if claim.planted == PLANTED[1].what else kelvin
    answer = ask(claim.abbe, "blackbody", kelvin=asked, nm=nm)
    found = np.array(answer["radiance"])
    exact = np.array([[planck(w, int(t)) for w in nm] for t in kelvin])
    claim.bounded("radiance, mpmath: relative", found / exact - 1, 1e-12)
    claim.bounded("radiance, colour-science: relative", found / theirs(nm, kelvin) - 1, 1e-10)

    sums = []
    for step in (0.1, 0.05):
        # The ends of the range count half: colour-science's plain sum counts them whole, which at 10000 K would be 10⁻⁷ of Z.
        weight = np.ones(len(grid(step).wavelengths))
        weight[[0, -1]] = 0.5
        sums.append(step * (theirs(grid(step).wavelengths, kelvin) * weight) @ observer("cie1931", step).values)
    xyz = (4 * sums[1] - sums[0]) / 3
    xyz /= xyz[:, 1:2]
    xy, ours = colour.XYZ_to_xy(xyz), np.array(answer["xy"])
    claim.bounded("x and y", ours - xy, 1e-7)
    white = colour.xy_to_XYZ(colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"])
    difference = delta_e(lab(colour.xy_to_XYZ(ours), white), lab(xyz, white))
    claim.bounded("ΔE2000", difference, 0.01)
    claim.bounded("relative error of X and Z, Y = 1", colour.xy_to_XYZ(ours) / xyz - 1, 1e-5)
    if claim.planted is None:
        draw(claim, kelvin, xy, ours, nm, found, exact)


def draw(claim, kelvin, xy, ours, nm, found, exact):
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.9))
    spectral = colour.XYZ_to_xy(observer("cie1931", 5).values)
    left.plot(*np.vstack([spectral, spectral[:1]]).T, color="0.6", lw=0.8)
    left.plot(*xy.T, color="#d55e00", label="colour-science")
    left.plot(*ours.T, "o", mfc="none", color="#0072b2", ms=4, label="abbe")
    for t, (x, y) in zip(kelvin, ours):
        if t in (1000, 2000, 3000, 4000, 6000, 10000):
            left.annotate(f"{t:.0f} K", (x, y), (-4, -14), textcoords="offset points", fontsize=7, ha="right" if t > 3000 else "center")
    left.set(xlabel="x", ylabel="y", xlim=(0, 0.8), ylim=(0, 0.87), aspect="equal")
    left.legend(loc="upper right")
    right.semilogy(kelvin, np.abs(ours - xy).max(1) + 1e-18, "o-", label="x, y: abbe − colour-science")
    right.semilogy(kelvin, np.abs(found / exact - 1).max(1) + 1e-18, "s-", label="radiance: abbe / mpmath − 1")
    old = np.transpose(colour.colorimetry.planck_law(nm * 1e-9, kelvin, c1=2 * np.pi * H * C * C)) * 1e-9
    right.semilogy(kelvin, np.abs(old / exact - 1).max(1), "^-", label="radiance with c₂ of ITS-90 / mpmath − 1")
    right.set(xlabel="temperature, K", ylabel="largest difference", ylim=(1e-17, 1e-1))
    right.legend(fontsize=7.5)
    claim.figure("locus", figure, "Left: the Planckian locus in the chromaticity diagram. Right: the largest difference over the wavelengths at each temperature, and for scale what the older constant (0.014388 m K, colour-science's default) makes.")
