"""A moving edge smears into the integral of the shutter over the time that it covers a place

A bright square of width s that moves by d across the film while the shutter is open leaves a trapezoid of height s/d with ramps s wide (box shutter);
two parabolas where the shutter is a triangle; sharp pictures of equal brightness where it is a strobe.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import area, film, gray, integrator, over, scene

METHOD = """A square of radiance 1, 8 pixels wide, moves by 64 pixels in unit time before an orthographic camera. The light of column i is the mean
over the pixel of G(t₁) − G(t₂), where G is the share of light let in up to a time and the square covers the place between t₂ and t₁: box G = t;
triangle G = 2t² and 1 − 2(1 − t)²; strobe G = steps. Columns of 64 pixels by their spread; the time for which the shutter is open by regression on
the derivative after it. Columns that nothing reaches must be black."""
DATA = "None but the shutters' definitions."

WIDTH, HEIGHT, SQUARE, FROM, SPEED = 96, 64, 8.0, -32.0, 64.0
LONGER = "shutter closes 1 % later"
PLANTED = [Planted(LONGER, ("time for which the shutter is open",))]
FLASHES = 3


def box(t):
    return np.clip(t, 0, 1)


def triangle(t):
    t = np.clip(t, 0, 1)
    return np.where(t < 0.5, 2 * t * t, 1 - 2 * (1 - t) ** 2)


def strobe(t):
    return sum((t >= k / (FLASHES - 1)) * 1.0 for k in range(FLASHES)) / FLASHES


SHUTTERS = {"box": ("", box), "triangle": ('<string name="shutter" value="triangle"/>', triangle),
            "strobe": (f'<string name="shutter" value="strobe"/><integer name="strobe_flashes" value="{FLASHES}"/>', strobe)}


def expected(let_in, close=1.0):
    """Light of each column."""
    nodes = 4096
    place = np.arange(WIDTH)[:, None] - WIDTH / 2 + (np.arange(nodes) + 0.5) / nodes
    middle = (place - FROM) / SPEED / close
    half = SQUARE / 2 / SPEED / close
    return np.mean(let_in(middle + half) - let_in(middle - half), 1)


def run(claim):
    figure, above, below = curves_and_residuals("column (pixels)", "light let in")
    close = 1.01 if claim.planted == LONGER else 1
    keys = "".join(
        f'<transform time="{time}"><scale x="{SQUARE / 2}" y="{HEIGHT}"/><translate x="{FROM + SPEED * time}"/></transform>' for time in (0, 2)
    )
    square = f'<shape type="rectangle"><animation name="to_world">{keys}</animation>{area(1)}</shape>'
    found, rows = [], []
    for number, (name, (words, let_in)) in enumerate(SHUTTERS.items()):
        camera = f"""<sensor type="orthographic"><float name="shutter_open" value="0"/><float name="shutter_close" value="{close}"/>{words}
            <transform name="to_world"><scale x="{WIDTH / 2}" y="{WIDTH / 2}"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
            {film(WIDTH, HEIGHT)}</sensor>"""
        file = scene(claim.work / f"{name}.xml", integrator("path", 1), camera, square)
        measured = gray(claim, file, 256 if claim.quick else 4096, number + 1)
        truth = expected(let_in)
        mean, error, freedom = over(measured)
        lit = truth > 1e-9
        dark = measured[:, ~lit]
        claim.holds(f"columns out of reach: {name}", np.all(dark == 0), f"{dark.shape[1]} columns", "exactly 0", "one path in a hundred thousand")
        judged = lit & (truth > 0.002)
        claim.agrees(f"columns: {name}", mean[judged], truth[judged], error[judged], freedom)
        if name != "strobe":
            slope = (expected(let_in, 1.001) - expected(let_in, 0.999)) / 0.002
            change, doubt, degrees = over((measured - truth) @ slope / (slope @ slope))
            found.append((1 + change, doubt, degrees))
            rows.append((name, f"{1 + change:.6f}", f"{doubt:.1e}"))
        line = above.plot(np.arange(WIDTH) + 0.5, truth, lw=1)[0]
        above.plot(np.arange(WIDTH) + 0.5, mean, ".", color=line.get_color(), label=name)
        residual = (mean - truth) / np.where(error > 0, error, 1)
        below.plot((np.arange(WIDTH) + 0.5)[judged], residual[judged], ".", color=line.get_color())
    mean, error, freedom = zip(*found)
    claim.agrees("time for which the shutter is open, by regression", mean, 1, error, freedom)
    claim.table(("shutter", "time open, expected 1", "standard error"), rows, "The time for which the shutter is open, as the smear tells it.")
    above.legend()
    claim.figure("smear", figure, "Lines: the integral of the shutter; dots: means of columns of 64 pixels, and their residuals.")
