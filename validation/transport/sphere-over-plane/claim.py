"""Lights of every form bring the irradiance of their closed forms to a diffuse plane

A diffuse plane of reflectance ρ under a light sends out ρE/π, where E is known: πL r²h/D³ under a sphere of radius r at height h and distance D while
all of it is above the horizon, an integral over its part above the horizon otherwise, πL times the configuration factor under a disk or a rectangle,
I cos θ/D² under a point.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from scipy.integrate import quad
from transport_common import FLOOR, REFLECTANCE, area, floor_camera, floor_pixels, gray, integrator, lamp_facing_down, diffuse, over, profile, scene

METHOD = """A slanted orthographic view of the floor from below the lamp to some three lamp heights away, with `path` of depth 2 and with `direct`
(light samples and scattering in their own weights), in each of 1024 pixels set against E integrated over the pixel. Measured over expected has
expectation 1 everywhere, so the spread of the pixels is the error of the mean over some of them. The spheres: far, nearly touching the floor, and
half sunk in it, so that the horizon cuts it."""
DATA = """Closed forms: the sphere's from the projected solid angle of a cone (Howell, Catalog of Radiation Heat Transfer Configuration Factors, B-38
to B-40); B-13 (disk) and B-4 (rectangle) from there; the cut sphere by quadrature of ∫ 2φ(θ) cos θ sin θ dθ over the polar angle from the normal."""

BRIGHTER = "lamps 1 % brighter"
CENTRE, HALF, WIDTH, HEIGHT = 1.5, 1.5, 64, 16
PLANTED = [
    Planted(BRIGHTER, ("mean of each lamp",)),
    Planted("Lambert without its cosine", ("each part",), "dropped_cosine"),
    Planted("density of area lights without the light's cosine", ("each part of the floor under: disk",), "transport_area_density_without_cosine"),
    Planted("light samples by the balance, scattering by the power heuristic", ("mean of each lamp",), "transport_mixed_heuristics"),
]


def under_sphere(radius, height):
    """E / L of the squared distance on the floor."""

    def whole(squared):
        return np.pi * radius**2 * height / (squared + height**2) ** 1.5

    def cut(squared):
        far = np.sqrt(squared + height**2)
        cos, sin, reach = height / far, np.sqrt(squared) / far, np.arcsin(radius / far)
        centre = np.arccos(cos)

        def ring(theta):
            half = np.clip((np.cos(reach) - cos * np.cos(theta)) / (sin * np.sin(theta)), -1, 1)
            return 2 * np.arccos(half) * np.cos(theta) * np.sin(theta)

        return quad(ring, centre - reach, np.pi / 2, limit=200, epsabs=1e-12, epsrel=1e-10)[0]

    if height >= radius:
        return whole
    # A smooth function of the distance alone: by Chebyshev's interpolation.
    low, high = 1.02 * (radius**2 - height**2), 40.0
    table = np.polynomial.Chebyshev.interpolate(np.vectorize(lambda t: np.log(cut(np.exp(t)))), 40, [np.log(low), np.log(high)])
    return lambda squared: np.exp(table(np.log(squared)))


def under_disk(radius, height):
    def irradiance(squared):
        z = squared + height**2 + radius**2
        return np.pi / 2 * (1 - (z - 2 * radius**2) / np.sqrt(z**2 - 4 * radius**2 * squared))

    return irradiance


def under_rectangle(x, y, half, height):
    def corner(a, b):
        a, b = a / height, b / height
        p, q = np.sqrt(1 + a * a), np.sqrt(1 + b * b)
        return (a / p * np.arctan(b / p) + b / q * np.arctan(a / q)) / 2

    return corner(x + half[0], y + half[1]) - corner(x - half[0], y + half[1]) - corner(x + half[0], y - half[1]) + corner(x - half[0], y - half[1])


def spot(squared):
    """Of intensity 1 up to 20° and then linearly to none at 50°, at height 2, looking down."""
    angle = np.degrees(np.arctan(np.sqrt(squared) / 2))
    return np.clip((50 - angle) / 30, 0, 1) * 2 / (squared + 4) ** 1.5


def lamps(brightness):
    """name -> (centre of the view, elements, E(x, y))."""

    def ball(radius, height):
        place = f'<point name="center" value="0 0 {height}"/><float name="radius" value="{radius}"/>'
        return f'<shape type="sphere">{place}{area(brightness)}{diffuse(0)}</shape>'

    def round_about(function):
        return lambda x, y: function(x * x + y * y)

    intensity = f'<spectrum name="intensity" value="{brightness}"/>'
    down = '<lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/>'
    beam = '<float name="cutoff_angle" value="50"/><float name="beam_width" value="20"/>'
    slanted = '<vector name="direction" value="1 0 -2"/>'
    return {
        "sphere, far": (CENTRE, ball(0.3, 2), round_about(under_sphere(0.3, 2))),
        "sphere, near": (CENTRE + 0.3, ball(0.6, 0.603), round_about(under_sphere(0.6, 0.603))),
        "sphere, half sunk": (CENTRE + 1, ball(0.8, 0.2), round_about(under_sphere(0.8, 0.2))),
        "disk": (CENTRE, lamp_facing_down("disk", 'value="0.8"', 1, brightness), round_about(under_disk(0.8, 1))),
        "rectangle": (CENTRE, lamp_facing_down("rectangle", 'x="0.7" y="0.4"', 1, brightness), lambda x, y: under_rectangle(x, y, (0.7, 0.4), 1)),
        "point": (
            CENTRE, f'<emitter type="point"><point name="position" value="0 0 1"/>{intensity}</emitter>', lambda x, y: (x * x + y * y + 1) ** -1.5
        ),
        "spot": (
            CENTRE - 0.7,
            f'<emitter type="spot"><transform name="to_world">{down}</transform>{beam}{intensity}</emitter>',
            round_about(spot),
        ),
        "directional": (
            CENTRE,
            f'<emitter type="directional">{slanted}<spectrum name="irradiance" value="{brightness}"/></emitter>',
            lambda x, y: 2 / np.sqrt(5) + 0 * x,
        ),
    }


def run(claim):
    brightness = 1.01 if claim.planted == BRIGHTER else 1
    spp = 64 if claim.quick else 1024
    everything, rows, shown = [], [], []
    for number, (name, (centre, lamp, irradiance)) in enumerate(lamps(brightness).items()):
        x, y, weights = floor_pixels(centre, HALF, WIDTH, HEIGHT)
        expected = REFLECTANCE / np.pi * irradiance(x, y) @ weights
        for kind in ("path", "direct"):
            limit = 2 if kind == "path" else None
            file = scene(claim.work / f"lamp{number}-{kind}.xml", integrator(kind, limit), floor_camera(centre, HALF, WIDTH, HEIGHT), FLOOR, lamp)
            measured = gray(claim, file, spp, 10 * number + (kind == "direct") + 1)
            mean, error, freedom = profile(measured, expected, 4)
            claim.agrees(f"each part of the floor under: {name}, {kind}", mean, 1, error, freedom)
            whole = over((measured / expected).ravel())
            everything.append(whole)
            rows.append((name, kind, f"{expected.min():.3g} to {expected.max():.3g}", f"{whole[0]:.6f}", f"{whole[1]:.1e}"))
            if kind == "path":
                shown.append((name, x.mean(-1)[0], measured.mean(0), expected.mean(0), profile(measured, expected, 1)))
    mean, error, freedom = zip(*everything)
    claim.agrees("mean of each lamp, by each integrator: measured over expected", mean, 1, error, freedom)
    header = ("lamp", "integrator", "radiance expected", "measured / expected", "standard error")
    claim.table(header, rows, "The floor as a whole, for a lamp of radiance, intensity or irradiance 1.")
    figure, above, below = curves_and_residuals("distance from below the lamp", "radiance of the floor", height=5.4, ratios=(3, 2))
    for i, (name, x, measured, expected, (mean, error, _)) in enumerate(shown):
        line = above.semilogy(x, expected, lw=1, color="#999999" if name == "directional" else f"C{i}")[0]
        above.plot(x, measured, ".", color=line.get_color(), label=name)
        varies = error > 1e-9
        below.plot(x[varies], ((mean - 1) / np.where(varies, error, 1))[varies], ".", color=line.get_color())
    above.legend(ncols=2, fontsize=7.5)
    above.set(ylim=(1e-3, None))
    claim.figure("profiles", figure, "Lines are the closed forms, dots columns of 16 pixels; below, what is left over (15 degrees of freedom).")
