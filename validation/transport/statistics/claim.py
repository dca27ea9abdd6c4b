"""What rays take, then and now: counts of abbe render --stats

More than 95 % of the time went into intersections in 1980, and camera rays were less than a third of all rays; a grid of 100³ cells needed two or
three tests of objects for a ray among thousands of them. abbe's counts say what it is now, and add up.
"""

import json
import math

import numpy as np
from harness.claim import Planted
from harness.plots import plt
from transport_common import film, integrator, scene, shape, spectrum

METHOD = """`abbe render --stats --json` counts queries and what each took. Numbers that are known are checked: one camera ray for each sample; kinds that sum
to all; paths between mirrors of a room that nothing leaves and nothing absorbs, whose length is the limit that is given. Lines that meet a box meet
a convex body in it with the ratio of the two areas, by which trees are built: of a cube and its ball π/6. The rest is told in tables. The share
of the time is an upper bound, from queries that are timed as they are where nobody counts; it is no more than told, for it depends on the machine."""
DATA = """J. Arvo and D. Kirk in A. Glassner (ed.), An Introduction to Ray Tracing (1989), section 6.2, after T. Whitted (1980); G. Wyvill, Practical Ray
Tracing (1995), sections 7.1 and 7.3; for the ratio of areas section 6.4.2 of the former. Spheres: random places in a cube, radius 0.3 of their spacing; seed 1."""

SEVEN = "a depth of 7 for one of 8"
SMALLER = "a ball smaller by 1 %"
PLANTED = [Planted(SEVEN, ("paths in a closed room of mirrors",)), Planted(SMALLER, ("lines that meet a cube",))]


def counted(claim, file, *options):
    return json.loads(claim.abbe._run([claim.abbe.binary, "render", file, "-q", "--stats", "--json", "-o", claim.work / "x.exr", *options]))


def room(claim, depth):
    """A room of white walls, of which the camera sees the inside: no path leaves it, and none is absorbed."""
    camera = f'<sensor type="perspective"><float name="fov" value="60"/>{film(16, 16)}</sensor>'
    mirror = '<boolean name="flip_normals" value="true"/><bsdf type="conductor"><string name="material" value="none"/></bsdf>'
    walls = shape("cube", '<scale value="3"/>', mirror)
    lamp = f'<emitter type="point"><point name="position" x="1" y="1" z="1"/>{spectrum("intensity", 1)}</emitter>'
    limits = f'<integrator type="path"><integer name="max_depth" value="{depth}"/><integer name="rr_depth" value="1000"/></integrator>'
    return scene(claim.work / "room.xml", limits, camera, lamp, walls)


def share(stats):
    """The share of the time in ray queries; a render may be too short for it to be known."""
    known = stats["share_of_ray_queries"]
    return "–" if known is None else f"{known:.0%}"


def spheres(claim, count):
    """Spheres in a cube under a sky, each of a size by their spacing."""
    random = np.random.default_rng(1)
    radius = 0.3 * count ** (-1 / 3)
    places = random.uniform(-0.5, 0.5, (count, 3))
    diffuse = f'<bsdf type="diffuse" id="grey">{spectrum("reflectance", 0.5)}</bsdf>'
    balls = "".join(
        f'<shape type="sphere"><point name="center" x="{x:.7f}" y="{y:.7f}" z="{z:.7f}"/><float name="radius" value="{radius:.7f}"/><ref id="grey"/></shape>\n'
        for x, y, z in places
    )
    view = '<float name="fov" value="35"/><transform name="to_world"><lookat origin="0, 0, 2" target="0, 0, 0" up="0, 1, 0"/></transform>'
    camera = f'<sensor type="perspective">{view}{film(64, 64)}</sensor>'
    sky = f'<emitter type="constant">{spectrum("radiance", 1)}</emitter>'
    return scene(claim.work / f"spheres-{count}.xml", integrator("path", 4), camera, sky, diffuse, balls)


def met_in_a_box(claim):
    """Of lines that meet a cube, uniform among all such lines, the share that meets the ball in it, with its standard error: rays of an irradiance
    meter all over the cube's inside. Where they meet the black ball there is no light."""
    inside = '<boolean name="flip_normals" value="true"/><bsdf type="null"/>'
    box = shape("cube", "", f'{inside}<sensor type="irradiancemeter">{film(16, 16)}</sensor>')
    radius = 0.99 if claim.planted == SMALLER else 1
    ball = f'<shape type="sphere"><float name="radius" value="{radius}"/><bsdf type="diffuse">{spectrum("reflectance", 0)}</bsdf></shape>'
    sky = f'<emitter type="constant">{spectrum("radiance", 1)}</emitter>'
    file = scene(claim.work / "box.xml", integrator("path", 3), box, ball, sky)
    picture = claim.abbe.render(file, 256 if claim.quick else 4096, 3, ("--spectral", 1, "--range", "555:556"))
    _, irradiance, errors = picture.spectrum()
    return 1 - irradiance.mean() / math.pi, np.sqrt(np.sum(errors**2)) / errors.size / math.pi


def run(claim):
    asked = 7 if claim.planted == SEVEN else 8
    stats = counted(claim, room(claim, asked), "--spp", 16, "--estimator", "plain")
    claim.holds(
        "paths in a closed room of mirrors are as long as they may be",
        stats["paths"]["mean_segments"] == 8 and stats["paths"]["ends"]["max_depth"] == stats["paths"]["number"],
        f"{stats['paths']['mean_segments']} segments",
        "8",
        "one ray of them",
    )
    met, error = met_in_a_box(claim)
    claim.agrees("lines that meet a cube meet the ball in it with π/6", met, math.pi / 6, error)
    if claim.planted:
        return
    rows, sums = [], []
    counts = (1000, 10_000) if claim.quick else (1000, 10_000, 100_000)
    for count in counts:
        stats = counted(claim, spheres(claim, count), "--spp", 16, "--estimator", "plain")
        rays = stats["rays"]
        sums.append(sum(kind["rays"] for kind in rays.values()) - stats["all_rays"])
        sums.append(rays["camera"]["rays"] - stats["samples"])
        queries = sum(kind["queries"] for kind in rays.values())
        tests = sum(kind["surfaces"] + kind["packets"] for kind in rays.values()) / queries
        nodes = sum(kind["nodes"] for kind in rays.values()) / queries
        rows.append((count, f"{tests:.2f}", f"{nodes:.2f}", f"{rays['camera']['rays'] / stats['all_rays']:.0%}", share(stats)))
        claim.holds(f"{count} spheres: tests of objects for a ray", tests < 15, f"{tests:.2f}", "< 15", "twice as many")
    claim.holds("kinds of rays add up, and each sample has one camera ray", not any(sums), f"{len(sums)} sums", "exactly", "one ray")
    header = ("spheres", "tests of objects", "nodes", "camera rays of all", "time in queries")
    claim.table(header, rows, "For each query of the tree; paths of at most 4 segments.")

    from harness.abbe import ROOT

    box, depths = [], (2, 3, 4, 6, 8, 16)
    for depth in depths:
        stats = counted(claim, ROOT / "scenes/box/scene.xml", "--spp", 16, "--size", "64x64", "--max-depth", depth, "--estimator", "plain")
        box.append(stats)
    per_sample = [stats["all_rays"] / stats["samples"] for stats in box]
    growing = all(a <= b for a, b in zip(per_sample, per_sample[1:]))
    claim.holds("rays of a sample grow with the depth of paths", growing, f"{per_sample[-1]:.1f} at 16", "never fewer", "one ray")
    claim.table(
        ("depth", "rays of a sample", "camera rays of all", "mean segments", "time in queries"),
        [
            (depth, f"{rays:.2f}", f"{1 / rays:.0%}", f"{stats['paths']['mean_segments']:.2f}", share(stats))
            for depth, rays, stats in zip(depths, per_sample, box)
        ],
        "The room of `scenes/box` at 16 samples: below a third from 2 segments on.",
    )
    figure, axes = plt.subplots(figsize=(6, 3.2))
    axes.plot(depths, per_sample, "o-")
    axes.set(xlabel="most segments of a path", ylabel="rays of a sample")
    claim.figure("depth", figure, "Rays of a sample by the depth of paths, in the room of scenes/box.")
