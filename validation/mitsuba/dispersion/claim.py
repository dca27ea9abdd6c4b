"""Dispersive glass is the right glass at every wavelength

At each wavelength λ abbe's picture of a thing of dispersive glass is Mitsuba's picture of the same thing made of a glass of the one index n(λ). Mitsuba cannot render dispersion, so
it knows nothing of how abbe treats several wavelengths on a path that refraction parts.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

import compare
from compare import FULL, QUICK, Pair
from harness.claim import Planted
from harness.plots import plt

METHOD = """Two scenes, a prism before a slit and a ball above a floor that it throws a caustic on, lit by lamps that shine from λ − 0.25 nm to λ + 0.25 nm alone and seen by a spectral film of
the same band. abbe is given the glass by its name in the catalogue, Mitsuba the number n(λ), and both pictures are compared as in the claim on pairs: mean, tiles, pixels, uniformity, stated
errors. Each of abbe's paths carries four wavelengths within the band, which part at the glass.

The place of the slit's image, the centroid along the film, is compared between both programs; the figure also has it by Snell's law, traced through the two faces in the plane."""
DATA = """Indices from SCHOTT's Sellmeier formula, n² = 1 + Σ B λ²/(λ² − C), with the coefficients of N-SF11 and N-BK7 from its data sheets, written down here again and not read from
abbe's `data/`. Wavelengths are the spectral lines h, g, F, e, d, C, r of the glass catalogue. The witness is Mitsuba 3.9.1."""

LINES = (404.66, 435.83, 486.13, 546.07, 587.56, 656.27, 706.52)  # nm
HALF_BAND = 0.25  # nm
SELLMEIER = {
    "N-SF11": ((1.73759695, 0.313747346, 1.89878101), (0.013188707, 0.0623068142, 155.23629)),
    "N-BK7": ((1.03961212, 0.231792344, 1.01046945), (0.00600069867, 0.0200179144, 103.560653)),
}
OFF = "the prism's index 0.001 too high"
BESIDE = "the index of a wavelength 1 nm too long: 0.0004 too low at 405 nm, 0.00004 at 707 nm"
PLANTED = [Planted(OFF, ("prism: tile", "prism: place")), Planted(BESIDE, ("prism: place",))]

WIDTH, HEIGHT, FOV = 96, 24, 17.0
# Mitsuba starts a ray (1 + |p|)·9·10⁻⁵ beside the surface point p: in small units a refracted ray is visibly displaced (FACTS.md, 83), in large ones least.
UNIT = 1000.0
DISTANCE = 5.0 * UNIT  # from the prism to the camera, and to the slit
SIDE = 2.4 * UNIT  # of the prism's cross-section
DESIGN = 530.0  # nm: passes the prism symmetrically through its middle


def index(glass, nm):
    """Refractive index relative to air."""
    micrometres = (nm / 1000) ** 2
    return float(np.sqrt(1 + sum(b * micrometres / (micrometres - c) for b, c in zip(*SELLMEIER[glass]))))


def turned(vector, angle):
    """Counterclockwise in the plane, radians; a direction is a complex number, x + iy."""
    return vector * np.exp(1j * angle)


@dataclass
class Prism:
    """The prism's corners, the slit's middle and the direction towards it, in the plane. The camera is at −DISTANCE·i and looks along +i."""

    corners: tuple
    slit: complex
    onward: complex


def prism():
    deviation = 2 * np.arcsin(index("N-SF11", DESIGN) / 2) - np.pi / 3
    within = turned(1j, deviation / 2)
    apex = within / 1j
    height = SIDE * np.sqrt(0.75)
    corners = (apex * height * 0.6, -apex * height * 0.4 - within * SIDE / 2, -apex * height * 0.4 + within * SIDE / 2)
    # The chord through the origin is shorter than the side: where the ray leaves, and from there to the slit.
    chord = 0.6 * SIDE / 2
    onward = turned(1j, deviation)
    return Prism(corners, chord * within + DISTANCE * onward, onward)


def refracted(direction, normal, ratio):
    """Snell's law in the plane; `normal` faces against the direction, `ratio` is the index before over the one behind."""
    cosine = -(direction * normal.conjugate()).real
    return ratio * direction + (ratio * cosine - np.sqrt(1 - ratio**2 * (1 - cosine**2))) * normal


def slit_place(nm):
    """Film coordinate, in pixels, at which the middle of the slit is seen through the prism: by Snell's law."""
    shape, n = prism(), index("N-SF11", nm)
    top, entry, leave = shape.corners
    camera = -DISTANCE * 1j - 0.6 * SIDE / 2 * 1j

    def onto(origin, direction, a, b):
        """Where the ray meets the line through a and b."""
        side = b - a
        return origin + direction * ((a - origin) * side.conjugate()).imag / (direction * side.conjugate()).imag

    def outward(a, b):
        normal = (b - a) * 1j / abs(b - a)
        middle = sum(shape.corners) / 3
        return normal if ((a - middle) * normal.conjugate()).real > 0 else -normal

    def miss(x):
        direction = turned(1j, -np.arctan(x))
        first = onto(camera, direction, top, entry)
        inside = refracted(direction, outward(top, entry), 1 / n)
        second = onto(first, inside, top, leave)
        out = refracted(inside, -outward(top, leave), n)
        return ((shape.slit - second) * out.conjugate()).imag

    edge = np.tan(np.radians(FOV / 2))
    # Towards one edge rays miss the second face or are reflected at it.
    with np.errstate(invalid="ignore"):
        tried = np.linspace(-edge, edge, 400)
        missed = np.array([miss(x) for x in tried])
    found = int(np.flatnonzero(missed[1:] * missed[:-1] < 0)[0])
    return WIDTH / 2 * (1 + brentq(miss, tried[found], tried[found + 1]) / edge)


def lamp(radiance, nm, slope=0.2):
    """A spectrum of the band, rising over it by twice the slope: a pixel that sees it has some variance in Mitsuba, whose rounding would otherwise be all that is compared."""
    values = ", ".join(f"{radiance * (1 + slope * x):.6g}" for x in (-1, -0.5, 0, 0.5, 1))
    band = f'<float name="wavelength_min" value="{nm - HALF_BAND}"/><float name="wavelength_max" value="{nm + HALF_BAND}"/>'
    return f'<spectrum name="radiance" type="regular">{band}<string name="values" value="{values}"/></spectrum>'


def document(nm, camera, width, height, bodies, depth):
    """A scene under a dim sky; Mitsuba's words alone, but for the glass among the bodies."""
    response = lamp(1, nm, slope=0).replace('"radiance"', '"band"')
    return f"""<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>
<sensor type="perspective">{camera}
<film type="specfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/><string name="component_format" value="float32"/>{response}<rfilter type="box"/></film>
<sampler type="independent"/></sensor>
<emitter type="constant">{lamp(0.4, nm)}</emitter>
{bodies}
</scene>"""


def prism_scene(nm, glass, folder):
    """The slit before a wall that shines weakly, seen through the prism. z is up."""
    shape = prism()
    points = [(p.real, p.imag, z) for z in (-UNIT, UNIT) for p in shape.corners]
    mesh = folder / "prism.obj"
    faces = [(1, 2, 3), (4, 6, 5), (1, 4, 5), (1, 5, 2), (2, 5, 6), (2, 6, 3), (3, 6, 4), (3, 4, 1)]
    # Outward, whichever way the corners go round.
    middle = np.mean(points, 0)
    corner = np.array(points)
    out = []
    for a, b, c in faces:
        normal = np.cross(corner[b - 1] - corner[a - 1], corner[c - 1] - corner[a - 1])
        out.append((a, b, c) if normal @ (corner[a - 1] - middle) > 0 else (a, c, b))
    mesh.write_text("".join("v {:.12g} {:.12g} {:.12g}\n".format(*p) for p in points) + "".join("f {} {} {}\n".format(*f) for f in out))
    start = -DISTANCE - 0.6 * SIDE / 2
    camera = f'<float name="fov" value="{FOV}"/><transform name="to_world"><lookat origin="0, {start}, 0" target="0, 0, 0" up="0, 0, 1"/></transform>'

    def panel(width, height, place, radiance):
        target = place - shape.onward
        look = f'<lookat origin="{place.real}, {place.imag}, 0" target="{target.real}, {target.imag}, 0" up="0, 0, 1"/>'
        turn = f'<transform name="to_world"><scale x="{width / 2}" y="{height / 2}"/>{look}</transform>'
        return f'<shape type="rectangle">{turn}<emitter type="area">{lamp(radiance, nm)}</emitter></shape>'

    bodies = f'<shape type="obj"><string name="filename" value="{mesh}"/><boolean name="face_normals" value="true"/><bsdf type="dielectric"><float name="ext_ior" value="1"/>{glass}</bsdf></shape>'
    bodies += panel(0.25 * UNIT, 3 * UNIT, shape.slit, 4) + panel(8 * UNIT, 8 * UNIT, shape.slit + 0.5 * UNIT * shape.onward, 0.5)
    # In through one face and out through another: what is reflected inside and then meets the slit is so rare and so bright that few renders of Mitsuba would
    # tell how much its pixels vary.
    return document(nm, camera, WIDTH, HEIGHT, bodies, 3)


def ball_scene(nm, glass, folder):
    """A glass ball over a diffuse floor under a wide lamp: refraction, total reflection in a wall's image, a caustic."""
    camera = '<float name="fov" value="38"/><transform name="to_world"><lookat origin="0, -6, 3.4" target="0, 0, 0.7" up="0, 0, 1"/></transform>'
    stripes = "".join(
        f'<shape type="rectangle"><transform name="to_world"><scale x="0.25" y="1.5"/><rotate x="1" angle="90"/><translate x="{x}" y="3" z="1.5"/></transform>'
        f'<emitter type="area">{lamp(2, nm)}</emitter></shape>'
        for x in (-2.25, -0.75, 0.75, 2.25)
    )
    bodies = f"""{stripes}
<shape type="rectangle"><transform name="to_world"><scale value="1.5"/><rotate x="1" angle="180"/><translate x="1" y="-0.5" z="4"/></transform><emitter type="area">{lamp(3, nm)}</emitter></shape>
<shape type="rectangle"><transform name="to_world"><scale value="4"/></transform><bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf></shape>
<shape type="sphere"><point name="center" x="0" y="0" z="1.05"/><float name="radius" value="1"/><bsdf type="dielectric"><float name="ext_ior" value="1"/>{glass}</bsdf></shape>"""
    return document(nm, camera, 48, 36, bodies, 8)


# Samples per pixel at full power.
SCENES = {"prism": (prism_scene, "N-SF11", 256), "ball": (ball_scene, "N-BK7", 256)}


def catalogue_glass(glass, nm, planted):
    """What abbe is given: the glass by name, or with a planted error as a table."""
    if planted is None:
        return f'<spectrum name="int_ior" type="measured"><string name="name" value="{glass}"/></spectrum>'
    wrong = lambda at: index(glass, at) + 0.001 if planted == OFF else index(glass, at + 1)
    return '<spectrum name="int_ior" value="{}"/>'.format(" ".join(f"{at}:{wrong(at):.9f}" for at in (nm - 1, nm, nm + 1)))


def places(stack):
    """Centroid of the slit's image along the film in each picture, pixels: of what is brighter than half of the brightest column."""
    columns = stack.mean((1, 3))
    level = columns.mean(0)
    inside = np.flatnonzero(level > 0.5 * (level.max() + np.median(level)))
    inside = np.arange(max(inside[0] - 3, 0), min(inside[-1] + 4, WIDTH))
    weights = columns[:, inside] - np.median(level)
    return (weights * (inside + 0.5)).sum(1) / weights.sum(1)


class Recording:
    """Remembers the last stack of a program."""

    def __init__(self, inner):
        self.inner, self.last = inner, None

    def stack(self, *words):
        self.last = self.inner.stack(*words)
        return self.last


def run(claim):
    power = QUICK if claim.quick else FULL
    reference, ours = Recording(compare.Mitsuba()), Recording(compare.Abbe(claim.abbe))
    rows, seen = [], []
    # The planted errors are in the prism, and larger at short wavelengths.
    lines = LINES[:3] if claim.planted else LINES
    for name, (scene, glass, spp) in list(SCENES.items())[: 1 if claim.planted else 2]:
        results, measured = [], []
        for nm in lines:
            files = []
            for program, matter in (("mitsuba", f'<float name="int_ior" value="{index(glass, nm):.9f}"/>'), ("abbe", catalogue_glass(glass, nm, claim.planted))):
                folder = compare.KEPT / "dispersion" if program == "mitsuba" else claim.work
                folder.mkdir(parents=True, exist_ok=True)
                files.append(folder / f"{name}-{nm:.0f}.xml")
                files[-1].write_text(scene(nm, matter, folder))
            results.append(compare.judge(Pair(f"{name} {nm:.2f} nm", files[1], files[0], spp), ours, reference, power))
            if claim.planted is None:
                print("    " + " | ".join(compare.row(results[-1])), flush=True)
            rows.append([f"{index(glass, nm):.6f}"] + compare.row(results[-1]))
            if name == "prism":
                measured.append([(p.mean(), p.std(ddof=1) / np.sqrt(len(p))) for p in (places(s.last.pictures) for s in (ours, reference))])
        before = len(claim.checks)
        compare.report(claim, results, power)
        for check in claim.checks[before:]:
            check.what = f"{name}: {check.what}"
        if name == "prism":
            (a, ea), (b, eb) = np.array(measured).transpose(1, 2, 0)
            claim.agrees("prism: place of the slit's image, all wavelengths", a, b, ea, power.replicates - 1, "pixels", eb)
            if claim.planted is None:
                positions(claim, a, ea, b, eb)
        seen += results
    if claim.planted is None:
        compare.sheets(claim, seen, per_page=14)
        claim.table(("n", *compare.HEADER), rows, "As in the claim on pairs; the film has one channel.")


def positions(claim, a, ea, b, eb):
    """The slit's place against wavelength, and what is left between the three."""
    fine = np.linspace(LINES[0], LINES[-1], 200)
    snell = np.array([slit_place(nm) for nm in LINES])
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2))
    left.plot(fine, [slit_place(nm) for nm in fine], color="#999999", label="Snell's law")
    left.plot(LINES, b, "s", color="C1", markersize=6, label="Mitsuba, one index a picture")
    left.plot(LINES, a, "o", color="C0", label="abbe, the glass by name")
    left.set(xlabel="wavelength, nm", ylabel="place of the slit's image, pixels")
    left.legend()
    right.axhline(0, color="#999999", linewidth=0.8)
    right.errorbar(LINES, 1000 * (a - b), 1000 * np.hypot(ea, eb), fmt="o", color="C0", label="abbe − Mitsuba")
    right.set(xlabel="wavelength, nm", ylabel="thousandths of a pixel")
    right.legend()
    claim.figure("places", figure, f"The prism of N-SF11. Left: where the slit is seen; abbe's centroids lie within {np.abs(a - snell).max():.2f} pixels of the slit's middle by Snell's law "
                 f"(the centroid of a slit of some width is not exactly its middle). Right: the difference with its standard error; 0.001 in the index is {abs(moved()):.2f} pixels at 546 nm.")


def moved():
    """Pixels by which the slit's image moves for 0.001 more index at 546 nm."""
    step = brentq(lambda nm: index("N-SF11", nm) - index("N-SF11", 546.07) - 0.001, 500, 546.07)
    return slit_place(step) - slit_place(546.07)
