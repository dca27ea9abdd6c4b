"""Behind an edge the light falls off as the part of the lamp that is seen

On a diffuse floor under a lamp of radiance L, half of which an opaque sheet with a straight edge covers, the radiance is ρL/π ∫ cos² θ/r² dA over the
part of the lamp that the place sees: from full light to none, and exactly none in the umbra.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import FLOOR, REFLECTANCE, floor_camera, floor_pixels, gray, integrator, lamp_facing_down, diffuse, over, scene, shape

METHOD = """A disk and a rectangle at height 4, an edge at height 1.5, seen by a slanted orthographic camera. The integral over the seen part by a
product rule of Gauss and Legendre in the angle of the disk, at 9 places of each pixel; columns of 32 pixels against it by their spread. The place of
the edge's shadow follows from a regression of all columns on the derivative of the expected profile after the place. The 1 % of full light nearest to
the umbra is left out of the columns' test (paths that see the lamp are too rare there for Student's distribution), and the umbra must be black."""
DATA = "None but the geometry."

LAMP, EDGE = 4.0, 1.5
HALF, WIDTH, HEIGHT = 1.5, 60, 32
SHIFTED = "edge off by 0.005, less than a hundredth of the penumbra of 1.2"
BRIGHTER = "lamps 1 % brighter"
PLANTED = [
    Planted(SHIFTED, ("place of the edge",)),
    Planted(BRIGHTER, ("lit part",)),
    Planted("density of area lights without the light's cosine", ("lit part of the floor: disk",), "transport_area_density_without_cosine"),
]


def radiance(x, y, across, along, edge=0.0, nodes=16):
    """What the floor sends out, for a lamp of radiance 1 that reaches `across` to each side of x = 0 and `along(q)` to each side of y = 0."""
    at, weight = np.polynomial.legendre.leggauss(nodes)
    # The line from x to a place q of the lamp passes the edge's height at x + (q − x) EDGE/LAMP.
    first = np.clip(x + (edge - x) * LAMP / EDGE, -across, across)
    # In the angle of a circle the integrand is smooth up to the rim.
    low = np.arcsin(first / across)[..., None]
    angle = low + (np.pi / 2 - low) * (at + 1) / 2
    q, step = across * np.sin(angle), across * np.cos(angle) * weight * (np.pi / 2 - low) / 2
    half = along(q)[..., None]
    s = half * at
    squared = (q[..., None] - x[..., None, None]) ** 2 + (s - y[..., None, None]) ** 2 + LAMP**2
    return REFLECTANCE / np.pi * np.sum(LAMP**2 / squared**2 * half * weight * step[..., None], (-1, -2))


LAMPS = {
    "disk": ('value="1"', 1.0, lambda q: np.sqrt(np.maximum(1 - q * q, 0))),
    "rectangle": ('x="0.8" y="0.4"', 0.8, lambda q: 0.4 + 0 * q),
}


def run(claim):
    figure, above, below = curves_and_residuals("distance from the edge (lengths)", "radiance of the floor")
    rows = []
    x, y, weights = floor_pixels(0, HALF, WIDTH, HEIGHT)
    for number, (name, (scale, across, along)) in enumerate(LAMPS.items()):
        edge = 0.005 if claim.planted == SHIFTED else 0
        lamp = lamp_facing_down(name, scale, LAMP, 1.01 if claim.planted == BRIGHTER else 1)
        sheet = shape("rectangle", f'<scale value="10"/><translate x="{edge - 10}" z="{EDGE}"/>', diffuse(0))
        file = scene(claim.work / f"{name}.xml", integrator("path", 2), floor_camera(0, HALF, WIDTH, HEIGHT), FLOOR, sheet, lamp)
        measured = gray(claim, file, 512 if claim.quick else 4096, number + 1)
        expected = radiance(x, y, across, along) @ weights
        ahead, behind = (radiance(x, y, across, along, step) @ weights for step in (0.001, -0.001))
        slope = (ahead - behind) / 0.002
        full = expected.max()
        umbra, lit = ahead.max(0) == 0, (expected.min(0) > 0.01 * full)
        black = np.all(measured[:, umbra] == 0) and umbra.sum() > 10
        claim.holds(f"umbra of the {name} is black", black, f"{umbra.sum()} columns of 32 pixels", "exactly 0", "one path in a million")
        mean, error, freedom = over(measured - expected)
        centre = x.mean(-1)[0]
        claim.agrees(f"columns: {name}", (expected.mean(0) + mean)[lit], expected.mean(0)[lit], error[lit], freedom)
        open_floor = expected.min(0) > 0.9 * full
        ratio, spread, degrees = over((measured[:, open_floor] / expected[:, open_floor]).ravel())
        claim.agrees(f"lit part of the floor: {name}, over what is expected", ratio, 1, spread, degrees)
        steep = np.abs(slope).max(0) > 0.01 * np.abs(slope).max()
        each = np.sum(((measured - expected) * slope)[:, steep], 1) / np.mean(np.sum(slope[:, steep] ** 2, 1))
        place, doubt, degrees = over(each)
        claim.agrees(f"place of the edge: {name}, by regression", place, 0, doubt, degrees, "lengths")
        rows.append((name, f"{ratio:.5f} ± {spread:.1e}", f"{place:+.1e} ± {doubt:.1e}"))
        line = above.plot(centre, expected.mean(0), lw=1)[0]
        above.plot(centre, measured.mean(0), ".", color=line.get_color(), label=name)
        below.plot(centre[lit], mean[lit] / error[lit], ".", color=line.get_color())
    claim.table(("lamp", "lit floor: measured / expected", "place of the edge (expected 0)"), rows, "Summary of both profiles.")
    above.legend()
    claim.figure("penumbra", figure, "Lines: the integral over the seen part of the lamp; dots: means of columns of 32 pixels, and their residuals.")
