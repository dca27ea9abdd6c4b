"""Pixels that share paths, and samples that go where pixels err, show the same picture

What `abbe render` does by default, sharing the suffixes of paths between sixteen pixels and giving cells of the film different numbers of samples,
changes noise alone. In a closed room of albedo ρ whose surfaces all emit E, everything is seen with the radiance E/(1−ρ). In other scenes the
expectation is that of the path tracer, in which each pixel has its own paths and as many samples as any other.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import area, diffuse, integrator, over, scene, shape, spectrum

METHOD = """Pixels of a render have noise in common, so renders are the units: of each scene there are several with other seeds, and the t-tests take
their spread. Compared are the mean of the picture, tiles of 8×8 pixels, and columns of the picture, among which are the edges of cells with different
numbers of samples: the film's filter reaches over them. The room holds blocks that hide its walls from one another, for what the balance heuristic
of sharing rests on is which pixel sees what. The corner has diffuse, glossy and mirroring surfaces, a lamp that lights most of it by way of a
wall, and a part in which there is nothing. The window is a bright wall behind a pane of glass, where suffixes split, and what they find is weighed
against light subpaths."""
DATA = """Bekaert, Sbert and Halton, Accelerating path tracing by re-using paths, EGWR 2002."""

SIZE = 48
EMITTED, ALBEDO = 0.5, 0.5
DARKER = "albedo of the room 0.498 for 0.5"
PLANTED = [
    Planted(DARKER, ("room: mean of the picture",)),
    Planted("who sees what is forgotten", ("corner: tiles",), "sharing_visibility_forgotten"),
    Planted("light behind glass is forgotten", ("window: mean of the picture",), "sharing_branches_forgotten"),
    Planted("Jacobian without the cosine", ("room: tiles", "corner: tiles"), "sharing_without_cosine"),
]


def camera(origin, target, angle):
    """A perspective camera and a film with a wide filter."""
    film = f'''<film type="hdrfilm"><integer name="width" value="{SIZE}"/><integer name="height" value="{SIZE}"/>
        <string name="pixel_format" value="luminance"/><rfilter type="gaussian"/></film>'''
    look = f'<transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 0, 1"/></transform>'
    return f'<sensor type="perspective">{look}<float name="fov" value="{angle}"/>{film}</sensor>'


def room(path, albedo):
    """A closed room with blocks in it, all of one material that emits."""
    surface = area(EMITTED) + diffuse(albedo)
    walls = shape("cube", '<scale value="2"/>', surface + '<boolean name="flip_normals" value="true"/>')
    places = ((-0.6, 0.3, -1.2), (0.7, 0.9, -0.9), (0.1, -0.2, 0.9), (1.3, -0.4, -1.5))
    blocks = [shape("cube", f'<scale x="0.3" y="0.3" z="0.6"/><rotate z="1" angle="{31 * i}"/><translate x="{x}" y="{y}" z="{z}"/>', surface)
              for i, (x, y, z) in enumerate(places)]
    return scene(path, integrator("path"), camera("0, -1.9, 0.2", "0, 1, -0.3", 80), walls, *blocks)


def corner(path):
    """Walls, a block, a mirror and a glossy ball under a lamp that faces a wall, beside a part in which there is nothing."""
    mirror = f'<bsdf type="conductor">{spectrum("eta", 0.2)}{spectrum("k", 3.5)}</bsdf>'
    glossy = f'<bsdf type="roughconductor"><float name="alpha" value="0.2"/>{spectrum("eta", 0.2)}{spectrum("k", 3.0)}</bsdf>'

    def ball(x, y, content):
        return f'<shape type="sphere"><point name="center" x="{x}" y="{y}" z="0.45"/><float name="radius" value="0.45"/>{content}</shape>'

    return scene(
        path,
        integrator("path", 6),
        camera("-1.2, -5, 2", "-1.2, 0, 0.9", 48),
        shape("rectangle", '<scale x="1.5" y="2"/>', diffuse(0.7)),
        shape("rectangle", '<scale x="1.5" y="1.5"/><rotate x="1" angle="90"/><translate y="1.5" z="1"/>', diffuse("400:0.2, 700:0.8")),
        shape("rectangle", '<scale x="2" y="1.5"/><rotate y="1" angle="-90"/><translate x="1.5" z="1"/>', diffuse("400:0.7, 700:0.3")),
        shape("cube", '<scale x="0.25" y="0.25" z="0.7"/><rotate z="1" angle="25"/><translate x="0.9" y="0.6" z="0.7"/>', diffuse(0.6)),
        ball(-0.7, 0.4, mirror),
        ball(0.1, -0.5, glossy),
        shape("disk", '<scale value="0.3"/><rotate y="1" angle="90"/><translate x="0.2" y="0.2" z="2"/>', area(12) + diffuse(0)),
    )


def window(path):
    """A room that one wall lights, through a pane of glass."""
    return scene(
        path,
        integrator("path", 7),
        camera("0, -1.2, 0.7", "0, 1, -0.3", 60),
        shape("cube", '<scale x="2" y="2" z="1.2"/>', diffuse(0.7) + '<boolean name="flip_normals" value="true"/>'),
        shape("cube", '<scale x="1.95" y="0.05" z="1.15"/><translate y="-1.7"/>', '<bsdf type="dielectric"><float name="int_ior" value="1.5"/></bsdf>'),
        shape("rectangle", '<scale x="1.9" y="1.1"/><rotate x="1" angle="-90"/><translate y="-1.95"/>', area(1)),
    )


def pictures(claim, file, estimator, seeds, spp):
    """Luminance of renders with these seeds: renders × rows × columns."""
    found = [claim.abbe.render(file, spp, seed, estimator=estimator).channels["Y"] for seed in seeds]
    return np.stack(found)


def tiles(pictures):
    """Means of tiles of 8×8 pixels: renders × tiles."""
    edge = SIZE // 8
    return pictures.reshape(-1, edge, 8, edge, 8).mean((2, 4)).reshape(-1, edge * edge)


def run(claim):
    renders, spp = (16, 32) if claim.quick else (48, 64)
    above_zero = 1e-3  # of the mean: where nothing is seen nothing is compared
    albedo = 0.498 if claim.planted == DARKER else ALBEDO
    shown = pictures(claim, room(claim.work / "room.xml", albedo), "shared", range(1, renders + 1), spp)
    expected = EMITTED / (1 - ALBEDO)
    # One number for the mean of all: Y of a spectrum that is 1 everywhere.
    unit = claim.abbe.render(sky(claim), 1024, 1).channels["Y"].mean()
    parts = (("mean of the picture", lambda p: p.mean((1, 2))[:, None]), ("tiles", tiles), ("columns", lambda p: p.mean(1)))
    for what, part in parts:
        mean, error, freedom = over(part(shown))
        claim.agrees(f"room: {what}", mean / unit, expected, error / unit, freedom)
    for name, made in (("corner", corner), ("window", window)):
        file = made(claim.work / f"{name}.xml")
        shared = pictures(claim, file, "shared", range(1, renders + 1), spp)
        plain = pictures(claim, file, "plain", range(1001, 1001 + renders), 2 * spp)
        rows = []
        for what, part in parts:
            mean, error, freedom = over(part(shared))
            truth, doubt, _ = over(part(plain))
            seen = truth > above_zero * plain.mean()
            claim.agrees(f"{name}: {what}", mean[seen], truth[seen], error[seen], freedom, expected_error=doubt[seen])
            rows.append((what, len(mean), f"{np.median(error[seen] / truth[seen]):.2e}", f"{np.median(doubt[seen] / truth[seen]):.2e}"))
        header = ("compared", "number", "relative error, shared", "relative error, path tracer of twice the samples")
        claim.table(header, rows, f"How sure the values of the {name} are, medians over {renders} renders.")
        variance = shared.var(0, ddof=1).mean() / plain.var(0, ddof=1).mean() / 2
        brings = f"What sharing brings in the {name}."
        claim.table(("variance of a pixel over that of the path tracer at equal samples",), [(f"{variance:.3f}",)], brings)
        columns(claim, name, shared, plain)


def columns(claim, name, shared, plain):
    """A figure of the columns of a picture."""
    figure, above, below = curves_and_residuals("column", "luminance")
    mean, error, _ = over(shared.mean(1))
    truth, doubt, _ = over(plain.mean(1))
    above.plot(truth, lw=1, label="path tracer")
    above.plot(mean, ".", ms=4, label="shared")
    above.legend(fontsize=7.5)
    total = np.hypot(error, doubt)
    below.plot(np.divide(mean - truth, total, out=np.zeros_like(total), where=total > 0), ".")
    claim.figure(f"columns-{name}", figure, f"Columns of the {name}: where a cell of few samples meets one of many nothing shows.")


def sky(claim):
    """A scene that shows a spectrum of 1 alone."""
    return scene(claim.work / "sky.xml", integrator("path"), camera("0, 0, 0", "0, 1, 0", 40), f'<emitter type="constant">{spectrum("radiance", 1)}</emitter>')
