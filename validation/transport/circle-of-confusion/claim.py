"""A thin lens blurs a point to the circle of confusion of its closed form

A lens of focal length F and diameter F/n, focused at P, spreads a point at the distance D evenly over a disk of diameter C = |V_D − V_P| F/(n V_D) on
the film, V_x = Fx/(x − F). At F = 50 mm, f/2, P = 2 m: 0.3205 mm for D = 4 m, 0.6410 mm for D = 1 m and for infinity.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import film, gray, integrator, over, scene, shape

METHOD = """A small disk of radiance 1 and of radius 4 pixels is seen through a `thinlens` camera. From each place of the film the lens sees it
through the overlap of two circles, so that each pixel has a closed form (the area of a lens of two arcs, integrated over the pixel). Compared are all
pixels, grouped by their distance from the centre; the light in all; and the diameter of the blur, by regression of the picture on its derivative
after the diameter. Nothing may lie beyond the rim. Before, at and behind the focal plane, on the axis and 600 pixels off it."""
DATA = """C by Potmesil and Chakravarty (1982), equation in Cook, Stochastic sampling and distributed ray tracing, in Glassner, An Introduction to Ray
Tracing (1989), ch. 5."""

FOCAL, STOP, FOCUS = 0.05, 2.0, 2.0
WHOLE = np.array([1536, 1152])
PART = 36
SOURCE = 4.0  # radius of the disk's sharp picture, pixels
# At unit distance; the camera's field of view is that of 36 mm × 24 mm across the diagonal.
PIXEL = 1e-3 * np.hypot(36, 24) / np.hypot(*WHOLE) / FOCAL
WIDER = "aperture 1 % wider"
NEARER = "focused 2 % too near"
PLANTED = [Planted(WIDER, ("diameter of the blur",)), Planted(NEARER, ("diameter of the blur",))]


def diameter(depth):
    """C in metres on the film."""
    image = FOCAL * depth / (depth - FOCAL)
    focus = FOCAL * FOCUS / (FOCUS - FOCAL)
    return abs(image - focus) * FOCAL / (STOP * image)


def overlap(distance, a, b):
    """Area common to two circles of radii a and b."""
    d = np.maximum(distance, 1e-12)
    one = np.clip((d * d + a * a - b * b) / (2 * d * a), -1, 1)
    two = np.clip((d * d + b * b - a * a) / (2 * d * b), -1, 1)
    kite = np.maximum((a + b - d) * (d + a - b) * (d - a + b) * (d + a + b), 0)
    lens = a * a * np.arccos(one) + b * b * np.arccos(two) - 0.5 * np.sqrt(kite)
    return np.where(d >= a + b, 0, np.where(d <= abs(a - b), np.pi * min(a, b) ** 2, lens))


def coverage(distance, radius):
    """The share of the lens that sees the disk, from a place of the film so far from the centre; `radius` is the blur's, pixels."""
    if radius < 1e-6:
        return (distance < SOURCE) * 1.0
    return overlap(distance, radius, SOURCE) / (np.pi * radius**2)


def run(claim):
    figure, above, below = curves_and_residuals("distance from the centre (pixels)", "share of the lens")
    steps = 16
    inside = (np.arange(PART * steps) + 0.5) / steps - PART / 2
    places = np.hypot(inside[:, None], inside[None, :])

    def picture(radius):
        return coverage(places, radius).reshape(PART, steps, PART, steps).mean((1, 3))

    centre = np.hypot(*np.meshgrid(*[np.arange(PART) + 0.5 - PART / 2] * 2))
    group = np.digitize(centre, np.arange(0.75, 20, 0.75))
    rows, names, sizes = [], [], []
    pixel = PIXEL * FOCAL * FOCUS / (FOCUS - FOCAL)  # on the film, metres
    for number, (depth, off) in enumerate(((1, 0), (1, 600), (1.5, 0), (4, 0), (4, 600), (1e6, 0))):
        stop = STOP / 1.01 if claim.planted == WIDER else STOP
        focus = FOCUS * 0.98 if claim.planted == NEARER else FOCUS
        corner = (WHOLE - PART) / 2 + (off, 0)
        more = f"""<integer name="crop_width" value="{PART}"/><integer name="crop_height" value="{PART}"/>
            <integer name="crop_offset_x" value="{corner[0]:.0f}"/><integer name="crop_offset_y" value="{corner[1]:.0f}"/>"""
        camera = f"""<sensor type="thinlens"><string name="focal_length" value="50mm"/><float name="f_stop" value="{stop}"/>
            <float name="focus_distance" value="{focus}"/><float name="far_clip" value="1e7"/>
            <transform name="to_world"><lookat origin="0, 0, 0" target="0, 0, -1" up="0, 1, 0"/></transform>{film(*WHOLE, more)}</sensor>"""
        light = '<emitter type="area"><spectrum name="radiance" value="1"/></emitter>'
        place = f'<scale value="{SOURCE * PIXEL * depth}"/><translate x="{off * PIXEL * depth}" z="{-depth}"/>'
        file = scene(claim.work / f"blur{number}.xml", integrator("path", 1), camera, shape("disk", place, light))
        measured = gray(claim, file, 2048 if claim.quick else 32768, number + 1)
        radius = diameter(depth) / pixel / 2
        expected = picture(radius)
        slope = (picture(radius * 1.002) - picture(radius / 1.002)) / (radius * (1.002 - 1 / 1.002))
        name = f"{'infinity' if depth == 1e6 else f'{depth} m'}, {off} pixels off"
        rim = radius + SOURCE + np.sqrt(0.5)
        beyond = measured[centre > rim]
        claim.holds(f"nothing beyond the rim: {name}", np.all(beyond == 0), f"{beyond.size} pixels", "exactly 0", "one path in a hundred thousand")
        difference = (measured - expected).ravel()
        # Groups of pixels at one distance; each has another expectation, which is subtracted.
        rings = [group.ravel() == i for i in range(group.max()) if np.sum(group == i) >= 12]
        found = [(expected.ravel()[ring].mean(), *over(difference[ring])) for ring in rings]
        truth, mean, error, freedom = (np.array(part) for part in zip(*[f for f in found if f[0] > 0.02 * expected.max()]))
        claim.agrees(f"radial profile: {name}", truth + mean, truth, error, freedom)
        seen = slope.ravel() != 0
        each = difference[seen] * slope.ravel()[seen] / np.mean(slope.ravel()[seen] ** 2)
        change, doubt, degrees = over(each)
        names.append(name)
        sizes.append((2 * (radius + change) * pixel * 1e3, diameter(depth) * 1e3, 2 * doubt * pixel * 1e3, degrees))
        total = measured.sum() / (np.pi * SOURCE**2)
        rows.append((name, f"{sizes[-1][1]:.6f}", f"{sizes[-1][0]:.6f}", f"{sizes[-1][2]:.1e}", f"{total:.5f}"))
        if off == 0:
            at = np.linspace(0, 18, 400)
            line = above.plot(at, coverage(at, radius), lw=1, label=name.split(",")[0])[0]
            above.plot(centre.ravel()[::3], measured.ravel()[::3], ".", ms=2, color=line.get_color())
            below.plot([centre.ravel()[ring].mean() for ring in rings][: len(mean)], mean / error, ".", color=line.get_color())
    found, truth, error, freedom = zip(*sizes)
    claim.agrees("diameter of the blur, by regression", found, truth, error, freedom, "mm")
    header = ("disk at", "C expected (mm)", "C measured (mm)", "standard error", "light over the sharp picture's")
    claim.table(header, rows, "Diameters of the circle of confusion on the film.")
    above.legend(fontsize=7.5)
    above.set(ylim=(0, None))
    below.set(xlim=(0, 20))
    caption = """Radial profiles of the blurred disk: lines are the closed form at points, dots single pixels (averages over their
        squares, so they smooth the rim), below residuals of rings against the closed form averaged over pixels. At 1 m and at infinity the
        blur is the same."""
    claim.figure("profile", figure, caption)
