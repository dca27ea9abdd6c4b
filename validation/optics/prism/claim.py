"""A prism deviates light as Snell's law says, measured in pictures to 0.01°

A 60° prism of N-BK7, N-SF10, SF10 or fused silica bends light of 400, 486.1, 587.6, 656.3 and 700 nm by
δ = i − A + asin(sin A · √(n² − sin² i) − sin i · cos A)
(i: angle of incidence, A: apex angle), and the place of each line in a rendered picture tells that angle to better than 0.01°.
"""

import math

import mpmath
import numpy as np

from harness.claim import Planted
from harness.plots import plt
from optics_common import N_SF10, glass, sellmeier

METHOD = """The scene is a spectroscope. A slit, 0.02° wide and 10⁶ prism lengths away, shines on a closed mesh of a prism; a pinhole camera behind
it is the telescope, each of its 1200 pixels a direction. The lamp emits five lines of triangular shape, 1 nm wide at the foot. Spectral bins of 10
nm tell the lines apart; the place of a line is the centroid of its bin. The telescope is turned by another fraction of a degree in each render, so
that the size of the pixels enters the spread of the renders, from which the standard error comes. The expectation of the t-test is the centroid of
the slit's image over the line's shape; the bound of 0.01° is against δ at the nominal wavelength, in mpmath. The angle of incidence is that of
least deviation at 587.6 nm, and one 6° steeper."""
DATA = """Sellmeier coefficients by SCHOTT (N-BK7, SF10; N-SF10 given in the scene) and Malitson (fused silica, J. Opt. Soc. Am. 55, 1965),
evaluated here independently of abbe. The least deviations are cross-checked against a table that was computed before and apart from this code."""

LINES = np.array([400.0, 486.1, 587.6, 656.3, 700.0])  # nm
APEX = math.radians(60)
FAR = 1e6
SLIT = math.radians(0.02)
GLASSES = {
    "N-BK7": lambda nm: glass("BK7", nm),
    "N-SF10": lambda nm: sellmeier(*N_SF10, nm),
    "SF10": lambda nm: glass("SF10", nm),
    "fused silica": lambda nm: glass("fused_silica", nm),
}
# Angle of incidence and deviations at LINES, degrees, to four places.
KNOWN = {
    "N-BK7": (49.3233, (39.8957, 39.1393, 38.6466, 38.4292, 38.3192)),
    "SF10": (59.7827, (65.8328, 61.7080, 59.5654, 58.7326, 58.3388)),
    "fused silica": (46.8220, (34.6275, 34.0359, 33.6440, 33.4687, 33.3791)),
}
INDEX_OFF, ANGLE_OFF, NANOMETRE_OFF = "index off by 0.001", "slit turned by 0.02°", "index taken 1 nm off"
PLANTED = [
    Planted(INDEX_OFF, ("N-BK7: within 0.01°", "N-SF10: within 0.01°", "N-BK7: centroids")),
    Planted(ANGLE_OFF, ("N-BK7: within 0.01°", "N-BK7: centroids", "fused silica: centroids")),
    Planted(NANOMETRE_OFF, ("N-BK7: centroids", "SF10: centroids", "fused silica: centroids"), "optics_one_nanometre_off"),
]


def deviation(i, n):
    return i - APEX + np.arcsin(np.sin(APEX) * np.sqrt(n**2 - np.sin(i) ** 2) - np.sin(i) * np.cos(APEX))


def exact_deviation(i, n):
    with mpmath.workdps(50):
        i, n, a = mpmath.mpf(i), mpmath.mpf(n), mpmath.pi / 3
        return float(mpmath.degrees(i - a + mpmath.asin(mpmath.sin(a) * mpmath.sqrt(n**2 - mpmath.sin(i) ** 2) - mpmath.sin(i) * mpmath.cos(a))))


def material(name, wrong):
    """The glass in the words of the scene file."""
    if wrong:
        nm = np.arange(380, 721)
        values = ", ".join(f"{at}:{n:.12f}" for at, n in zip(nm, GLASSES[name](nm) + 0.001))
        index = f'<spectrum name="int_ior" value="{values}"/>'
    elif name == "N-SF10":
        index = f'<spectrum name="int_ior" type="sellmeier"><string name="b" value="{N_SF10[0]}"/><string name="c" value="{N_SF10[1]}"/></spectrum>'
    else:
        index = f'<spectrum name="int_ior" type="measured"><string name="name" value="{name.replace(" ", "-")}"/></spectrum>'
    return index + '<float name="ext_ior" value="1"/>'


def write_scene(claim, name, lamp, wrong=False):
    folder = claim.work / f"{name.replace(' ', '-')}-{lamp}"
    folder.mkdir(exist_ok=True)
    here = __file__.rsplit("/", 1)[0]
    lines = ", ".join(f"{at - 0.5}:0, {at}:1, {at + 0.5}:0" for at in LINES)
    radiance = f'<spectrum name="radiance" value="{lines}"/>' if lamp == "lines" else '<spectrum name="radiance" type="d65"/>'
    text = open(f"{here}/scene.xml").read().replace("GLASS", material(name, wrong)).replace("LAMP", radiance)
    (folder / "prism.obj").write_text(open(f"{here}/prism.obj").read())
    (folder / "scene.xml").write_text(text)
    return folder / "scene.xml"


def setting(incidence, aim, fov, off=0.0):
    """Parameters of the scene: the slit at this angle of incidence, turned by `off`, the telescope turned to the deviation `aim` (radians)."""
    into, out = incidence + off - APEX / 2, incidence - APEX / 2 - aim
    # The beam of the aimed wavelength leaves near the middle of the right face.
    point = np.array([0.5, 0.0])
    eye = point + 0.3 * np.array([math.cos(out), math.sin(out)])
    slit = FAR * np.array([math.cos(into), math.sin(into)])
    words = lambda v: f"{v[0]:.15g}, {v[1]:.15g}, 0"
    return {
        "slit": words(np.array([-0.5, 0.0]) - slit),
        "opposite": words(slit),
        "eye": words(eye),
        "look": words(eye - np.array([math.cos(out), math.sin(out)])),
        "fov": fov,
        "half_width": FAR * math.tan(SLIT / 2),
    }


def expected_centroids(name, incidence, aim, fov):
    """Centroids of the slit's images, averaged over the lines' shapes, in film coordinates −1 to 1."""
    # Light from beside the middle of the slit, at i, leaves in the direction that is read as a deviation of:
    read = lambda i, nm: deviation(i, GLASSES[name](nm)) + incidence - i
    place = lambda i, nm: np.tan(read(i, nm) - aim) / math.tan(math.radians(fov) / 2)
    x, w = np.polynomial.legendre.leggauss(8)
    offsets, weights = np.concatenate([0.25 * x - 0.25, 0.25 * x + 0.25]), np.concatenate([w * (1 + x), w * (1 - x)])
    found = []
    for line in LINES:
        first, last = place(incidence - SLIT / 2, line + offsets), place(incidence + SLIT / 2, line + offsets)
        found.append(np.sum(weights * (last**2 - first**2) / 2) / np.sum(weights * (last - first)))
    return np.array(found)


def measure(claim, name, incidence, spp, seeds, scene, off=0.0):
    """Measured and expected deviations (degrees) of the lines with the standard error of the former; the last picture's bins."""
    n = GLASSES[name]
    ends = np.degrees(deviation(incidence, n(np.array([395.0, 705.0]))))
    fov = (ends[0] - ends[1]) * 1.15
    found, expected = [], []
    dither = np.random.default_rng(7)
    for seed in range(1, seeds + 1):
        aim = math.radians(ends.mean() + 0.03 * fov * dither.uniform(-1, 1))
        picture = claim.abbe.render(scene, spp, seed, ("--range", "395:705", "--spectral", "31"), setting(incidence, aim, fov, off))
        nm, radiance, _ = picture.spectrum()
        width = radiance.shape[1]
        x = (2 * np.arange(width) + 1) / width - 1
        bins = [int(np.argmin(np.abs(nm - line - 1e-6))) for line in LINES]
        rows = radiance[0][:, bins]
        angle = lambda s: np.degrees(aim + np.arctan(s * math.tan(math.radians(fov) / 2)))
        found.append(angle((x[:, None] * rows).sum(0) / rows.sum(0)))
        expected.append(angle(expected_centroids(name, incidence, aim, fov)))
    found, expected = np.array(found), np.array(expected)
    return found.mean(0), expected.mean(0), (found - expected).std(0, ddof=1) / math.sqrt(seeds), (angle(x), rows)


def run(claim):
    seeds, spp = (8, 64) if claim.quick else (16, 512)
    wrong, off = claim.planted == INDEX_OFF, math.radians(0.02) if claim.planted == ANGLE_OFF else 0.0
    rows, kept = [], {}
    f, d, c = sellmeier(*N_SF10, np.array([486.1327, 587.5618, 656.2725]))
    claim.bounded("N-SF10: nd and V_d of its data sheet, over half of the last digit", [(d - 1.72828) / 5e-6, ((d - 1) / (f - c) - 28.53) / 5e-3], 1)
    for name, n in GLASSES.items():
        scene = write_scene(claim, name, "lines", wrong)
        least = math.asin(float(n(587.6)) / 2)
        for how, incidence in (("least deviation", least), ("steeper", least + math.radians(6)))[: 1 if claim.quick else 2]:
            nominal = np.array([exact_deviation(incidence, value) for value in n(LINES)])
            found, expected, error, picture = measure(claim, name, incidence, spp, seeds, scene, off)
            claim.bounded(f"{name}: within 0.01° of Snell, {how}", found - nominal, 0.01, "°")
            # Differences: the errors are below single precision of the angles themselves.
            claim.agrees(f"{name}: centroids of the lines, difference, {how}", found - expected, 0.0, error, seeds - 1, "°")
            if how == "least deviation":
                kept[name] = (incidence, found, error, nominal, picture)
                rows += [
                    (name, f"{nm:g}", f"{float(n(nm)):.6f}", f"{a:.5f}", f"{b:.5f} ± {e:.5f}", f"{b - a:+.5f}")
                    for nm, a, b, e in zip(LINES, nominal, found, error)
                ]
        if name in KNOWN:
            incidence, known = KNOWN[name]
            again = [exact_deviation(math.radians(incidence), value) for value in n(LINES)]
            claim.bounded(f"{name}: the closed form gives the table's deviations", np.subtract(again, known), 1e-4, "°")
    if claim.planted:
        return
    claim.table(
        ("glass", "nm", "n", "δ by Snell, °", "δ in the picture, °", "difference"),
        rows,
        "Deviations at the incidence of least deviation of 587.6 nm.",
    )
    show(claim, kept, 64 if claim.quick else 512)


def show(claim, kept, spp):
    """The picture of the spectroscope, and the deviations over wavelength."""
    name = "N-SF10"
    incidence, _, _, nominal, (angles, lines) = kept[name]
    aim, fov = math.radians(nominal.mean() + 0.6), 12.0
    options = setting(incidence, aim, fov)
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7.2, 2.6), sharex=True)
    for axes, lamp in ((top, "white"), (bottom, "lines")):
        # A wider slit for white light, which has many colours to share its samples.
        wide = {**options, "half_width": options["half_width"] * (5 if lamp == "white" else 1)}
        picture = claim.abbe.render(write_scene(claim, name, lamp), spp * 16, 1, (), wide)
        rgb = picture.stack("RGB")[0]
        width = len(rgb)
        x = np.degrees(aim + np.arctan(((2 * np.arange(width + 1)) / width - 1) * math.tan(math.radians(fov) / 2)))
        # The line lamp is dim at its ends: each line is shown at its own brightness, as a long exposure would.
        scale = rgb.max() if lamp == "white" else np.maximum(np.convolve(rgb.max(1), np.ones(25), "same") / 8, 1e-9)[:, None]
        seen = np.clip(np.clip(rgb, 0, None) / scale, 0, 1)
        seen = np.where(seen <= 0.0031308, 12.92 * seen, 1.055 * seen ** (1 / 2.4) - 0.055)
        axes.pcolorfast(x, [0, 1], seen[None])
        axes.set(yticks=[], ylabel="daylight" if lamp == "white" else "five lines")
        axes.grid(False)
        axes.spines[:].set_visible(False)
        for line, at in zip(LINES, nominal):
            axes.plot([at, at], [1.02, 1.18], color="black", clip_on=False, lw=1)
            if lamp == "white":
                axes.text(at, 1.25, f"{line:g}", ha={700.0: "right", 656.3: "center", 587.6: "left"}.get(line, "center"), fontsize=8)
    bottom.set_xlabel("deviation, ° (marks: Snell's law at these wavelengths, nm)")
    claim.figure(
        "spectroscope",
        figure,
        "What the telescope sees behind a 60° prism of N-SF10: D65 through a slit of 0.1°, and the five lines through one of 0.02° (each exposed for"
        " itself). The marks are computed, not fitted.",
    )
    figure, (left, right) = plt.subplots(1, 2)
    nm = np.linspace(390, 710, 200)
    for name, (incidence, found, error, nominal, _) in kept.items():
        (drawn,) = left.plot(nm, np.degrees(deviation(incidence, GLASSES[name](nm))), lw=1)
        left.plot(LINES, found, "o", color=drawn.get_color(), label=name)
        right.errorbar(LINES, (found - nominal) * 1000, 2 * error * 1000, fmt="o", color=drawn.get_color(), capsize=2, label=name)
    left.set(xlabel="wavelength, nm", ylabel="deviation, °")
    right.set(xlabel="wavelength, nm", ylabel="measured − Snell, 0.001°")
    right.axhline(0, color="black", lw=0.6)
    left.legend()
    claim.figure(
        "deviation",
        figure,
        "Left: deviation by Snell's law (lines) and measured in the pictures (points). Right: the difference, ± 2 standard errors; the bound"
        " is at ± 10.",
    )
