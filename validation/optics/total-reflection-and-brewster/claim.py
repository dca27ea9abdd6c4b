"""The edge of total reflection and Brewster's angle stand where they belong in a picture

sin θ_c = 1/n, measured wavelength by wavelength as with Abbe's refractometer; and the unpolarised reflectance of a glass floor follows Fresnel from
0 to 90°, ½((n² − 1)/(n² + 1))² at Brewster's angle, tan θ_B = n."""

import math

import numpy as np

from harness.claim import Planted
from harness.plots import plt
from harness.quadrature import over_band
from optics_common import FLOOR, floor_picture, fresnel, glass, measured, moderated, repeat, write

METHOD = """**Refractometer.** A camera looks through the face of a 45° prism at its base, under which a lamp lies; beyond the critical angle the
base is dark. A direction e outside is θ = 45° + asin(sin e / n) at the base. The light that gets through, summed over the picture, rises with 1/n:
that sum is turned into the n that gives it, with the closed form (1 − F₁)(1 − F₂), and so into θ_c = asin(1/n), for bands of 4 nm. So no edge has
to be found by eye. **Floor.** A camera above a glass floor under a white sky sees each angle of incidence in another row; a second, narrow one
looks at Brewster's angle alone. **What is not claimed**: abbe follows no polarisation. That r_p vanishes at Brewster's angle shows only in F = ½
r_s² there; light reflected twice keeps no memory of it (see the slabs)."""
DATA = "SCHOTT's Sellmeier coefficients of N-BK7, N-SF11; Malitson's of fused silica; evaluated here independently of abbe."

INDEX, ANGLE = "index off by 0.001", "camera turned by 0.02°"
PLANTED = [
    Planted(INDEX, ("N-BK7: critical angle", "N-SF11: critical angle")),
    Planted(ANGLE, ("N-BK7: critical angle", "N-SF11: critical angle")),
    Planted("s-polarised light only", ("floor: every row", "Brewster's angle"), "optics_s_only"),
    Planted("index taken 1 nm off (0.0001 in violet flint)", ("N-SF11: critical angle",), "optics_one_nanometre_off"),
]
GLASSES = {"N-BK7": "BK7", "N-SF11": "N-SF11", "fused silica": "fused_silica"}
BANDS = np.array([404.7, 435.8, 486.1, 546.1, 587.6, 656.3, 706.5])  # nm
TILT = math.radians(45)
FOV = math.radians(8)

REFRACTOMETER = """<!-- Abbe's refractometer: a prism face at 45°, its base, and a lamp under the base; all in the plane z = 0 -->
<scene version="3.0.0">
    <default name="eye" value="0, 2, 0"/><default name="look" value="0, 0, 0"/><default name="width" value="400"/>
    <integrator type="path"><integer name="max_depth" value="3"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="8"/><transform name="to_world"><lookat origin="$eye" target="$look" up="0, 0, 1"/></transform>
        <film type="hdrfilm"><integer name="width" value="$width"/><integer name="height" value="1"/><rfilter type="box"/></film>
    </sensor>
    <bsdf type="dielectric" id="glass">GLASS</bsdf>
    <shape type="rectangle">
        <transform name="to_world"><scale x="0.5" y="0.5" z="1"/><rotate x="1" angle="-90"/><rotate z="1" angle="45"/><translate y="1"/></transform>
        <ref id="glass"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale x="16" y="16" z="1"/><rotate x="1" angle="90"/></transform>
        <ref id="glass"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale x="256" y="256" z="1"/><rotate x="1" angle="-90"/><translate y="-0.0001"/></transform>
        <emitter type="area"><spectrum name="radiance" value="1"/></emitter>
    </shape>
</scene>
"""


def index_of(name, wrong):
    """The glass in the scene's words."""
    if not wrong:
        return measured(name.replace(" ", "-"))
    nm = np.arange(390, 721)
    values = ", ".join(f"{at}:{n + 0.001:.12f}" for at, n in zip(nm, glass(GLASSES[name], nm)))
    return f'<spectrum name="int_ior" value="{values}"/><float name="ext_ior" value="1"/>'


def edge(n):
    """Direction outside (from the face's normal, radians) in which total reflection begins."""
    return np.arcsin(n * np.sin(np.arcsin(1 / n) - TILT))


def radiance(e, n):
    """Seen in the direction e: the lamp through both faces."""
    at_base = np.cos(TILT + np.arcsin(np.sin(e) / n))
    first, second = fresnel(np.cos(e), n), fresnel(at_base, 1 / n)
    return (1 - (first[0] + first[1]) / 2) * (1 - (second[0] + second[1]) / 2)


def summed(n, aim, turned=0.0):
    """Mean radiance of the picture (over film area), by quadrature; the square root at the edge is taken out by substitution."""
    half = math.tan(FOV / 2)
    stop = min(max(math.tan(float(edge(n)) - aim) / half, -1), 1)
    x, w = np.polynomial.legendre.leggauss(60)
    u, weights = (x + 1) / 2, w / 2
    s = stop - (stop + 1) * u**2
    return float(np.sum(weights * (stop + 1) * 2 * u * radiance(aim + np.arctan(s * half), n)) / 2)


def view(aim):
    """Parameters of the camera, which looks along the face's inward normal turned by aim towards the horizontal. To the right of the picture the
    angle falls."""
    direction = np.array([math.sin(TILT + aim), -math.cos(TILT + aim)])
    eye = np.array([0.0, 1.0]) - 0.5 * direction
    words = lambda v: f"{v[0]:.15g}, {v[1]:.15g}, 0"
    return {"eye": words(eye), "look": words(eye + direction)}


def refractometer(claim, spp, seeds):
    kept, bands = {}, BANDS[::3] if claim.quick else BANDS
    for name, column in GLASSES.items():
        scene = write(claim, name.replace(" ", "-"), REFRACTOMETER.replace("GLASS", index_of(name, claim.planted == INDEX)))
        found, predicted, errors, rows = [], [], [], []
        for nm in bands:
            n = float(glass(column, nm))
            aim = float(edge(n)) - math.radians(2)
            turned = aim + (math.radians(0.02) if claim.planted == ANGLE else 0)
            options = ("--range", f"{nm - 2}:{nm + 2}", "--spectral", "1")
            read = lambda p: p.spectrum()[1][0, :, 0]
            mean, _ = value = repeat(claim, scene, spp, seeds, lambda p: np.append(read(p), read(p).mean()), options, view(turned))
            # n from the sum: it falls as n grows.
            candidates = n + np.linspace(-0.004, 0.004, 81)
            sums = np.array([summed(c, aim) for c in candidates])
            angle = lambda total: np.degrees(np.arcsin(1 / np.interp(-total, -sums, candidates)))
            slope = (sums[41] - sums[39]) / (candidates[41] - candidates[39])
            found.append(angle(mean[-1]))
            # The sums' mean over the band is not the sum for its mean index: 9·10⁻⁶ ° in violet flint.
            predicted.append(angle(over_band(nm, 4, lambda at: summed(float(glass(column, at)), aim), 6)))
            errors.append(abs(np.degrees(value[1][-1] / slope / (n * math.sqrt(n * n - 1)))))
            rows.append(mean[:-1])
        expected = np.degrees(np.arcsin(1 / glass(column, bands)))
        found, differences = np.array(found), np.array(found) - predicted
        # Only the pixel with the edge in it varies, and a few renders may agree by chance to the last sample: the bands share one variance.
        errors = np.full(len(bands), math.sqrt(np.mean(np.square(errors))))
        freedom = (seeds - 1) * len(bands) / 2
        claim.agrees(f"{name}: critical angle, difference at each wavelength", differences, 0.0, errors, freedom, "°")
        together = differences.mean(), errors[0] / math.sqrt(len(bands))
        claim.agrees(f"{name}: critical angle, difference at all wavelengths together", together[0], 0.0, together[1], freedom, "°")
        claim.bounded(f"{name}: critical angle within 0.01°", found - expected, 0.01, "°")
        kept[name] = (bands, expected, found, errors, rows)
    return kept


def floor(claim, spp, seeds):
    count = 60 if claim.quick else 180
    kept = {}
    for name in ("N-BK7", "N-SF11"):
        scene = write(claim, f"floor-{name}", FLOOR.replace("BSDF", f'<bsdf type="dielectric">{index_of(name, claim.planted == INDEX)}</bsdf>'))
        f = lambda c, nm: sum(fresnel(c, glass(GLASSES[name], nm))) / 2
        for nm in (450.0, 650.0)[: 1 if claim.quick else 2]:
            mean, error = repeat(
                claim, scene, spp, seeds, lambda p: p.spectrum()[1][:, 0, 0], ("--range", f"{nm - 2}:{nm + 2}", "--spectral", "1"), {"rows": count}
            )
            kept[name, nm] = (mean, *moderated(error, seeds), floor_picture(f, np.array([nm, nm + 4]), count)[:, 0])
    mean, error, freedom, expected = (np.array([v[i] for v in kept.values()]) for i in range(4))
    claim.agrees("floor: every row", mean, expected, error, freedom)
    claim.agrees(
        "floor: all rows together, over Fresnel",
        mean.mean() / expected.mean(),
        1.0,
        np.sqrt(np.sum(error**2)) / expected.sum(),
        (seeds - 1) * expected.size / 4,
    )
    ratios = []
    for name in GLASSES:
        n = float(glass(GLASSES[name], 587.6))
        scene = write(
            claim,
            f"floor-{name.replace(' ', '-')}",
            FLOOR.replace("BSDF", f'<bsdf type="dielectric">{index_of(name, claim.planted == INDEX)}</bsdf>'),
        )
        defines = {"rows": 8, "fov": 0.02, "target": f"{n:.15g}, 0, 0"}
        mean, error = repeat(claim, scene, 4 * spp, seeds, lambda p: p.spectrum()[1].mean(), ("--range", "586.6:588.6", "--spectral", "1"), defines)
        half_rs2 = 0.5 * ((n * n - 1) / (n * n + 1)) ** 2
        ratios.append((mean / half_rs2, error / half_rs2))
    claim.agrees("Brewster's angle: F over ½ r_s², three glasses", [r for r, _ in ratios], 1.0, [e for _, e in ratios], seeds - 1)
    return kept, count


def run(claim):
    seeds, spp = (5, 256) if claim.quick else (10, 2048)
    edges = refractometer(claim, spp, seeds)
    rows, count = floor(claim, 2 * spp, 2 * seeds)
    if not claim.planted:
        show(claim, edges, rows, count)


def show(claim, edges, rows, count):
    figure, (left, right) = plt.subplots(1, 2)
    bands, _, _, _, pictures = edges["N-SF11"]
    for nm, picture, color in zip(bands, pictures, plt.cm.turbo(np.linspace(0.05, 0.95, len(bands)))):
        n = float(glass("N-SF11", nm))
        aim = float(edge(n)) - math.radians(2)
        s = 1 - (2 * np.arange(len(picture)) + 1) / len(picture)
        e = aim + np.arctan(s * math.tan(FOV / 2))
        theta = np.degrees(TILT + np.arcsin(np.sin(e) / n))
        left.plot(theta, picture, color=color, lw=0.8)
        left.axvline(math.degrees(math.asin(1 / n)), color=color, ls=":", lw=0.8)
    left.set(xlabel="angle at the base inside N-SF11, °", ylabel="radiance of the lamp through the prism", xlim=(31.5, 35.5))
    for name, (bands, expected, found, errors, _) in edges.items():
        right.errorbar(bands, (found - expected) * 1000, 2 * errors * 1000, fmt="o", capsize=2, label=name)
    right.axhline(0, color="black", lw=0.6)
    right.set(xlabel="wavelength, nm", ylabel="measured − asin(1/n), 0.001°")
    right.legend()
    claim.figure(
        "critical",
        figure,
        "Left: rows of the pictures at seven wavelengths; dotted: asin(1/n), from violet (left) to red. Right: the critical angle from the pictures,"
        " ± 2 standard errors.",
    )
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(7.2, 4.4), sharex=True, height_ratios=(2, 1))
    s = 1 - (2 * np.arange(count) + 1) / count
    angles = 45 + np.degrees(np.arctan(s))
    for (name, nm), (mean, error, _, expected) in rows.items():
        (drawn,) = top.plot(angles, expected, lw=1, label=f"{name}, {nm:g} nm")
        top.plot(angles, mean, ".", ms=3, color=drawn.get_color())
        bottom.plot(angles, (mean - expected) / error, ".", ms=3, color=drawn.get_color())
        brewster = math.degrees(math.atan(float(glass(GLASSES[name], nm))))
        top.axvline(brewster, color=drawn.get_color(), ls=":", lw=0.8)
    top.set(ylabel="reflectance", yscale="log")
    top.legend()
    bottom.set(xlabel="angle of incidence, ° (dotted: Brewster's angle)", ylabel="difference, standard errors")
    claim.figure("floor", figure, "Unpolarised reflectance of a glass floor: Fresnel (lines) and the rows of the pictures (points).")
