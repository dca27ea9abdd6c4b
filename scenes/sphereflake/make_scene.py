"""Writes scene.xml: a sphereflake (E. Haines, "A proposal for standard graphics environments", IEEE Computer Graphics and Applications 7(11), 1987).

    python make_scene.py [DEPTH]

Around a ball nine balls of a third of its radius touch it: six around its equator and three nearer to its pole; and so on around each of them. DEPTH 3,
as it is without an argument, makes 820 balls, 4 makes 7381, 5 makes 66,430.
"""

import math
import sys
from pathlib import Path

HEAD = """<!-- A sphereflake of {count} balls, made by make_scene.py -->
<scene version="3.0.0">
    <default name="spp" value="64"/>
    <integrator type="path"><integer name="max_depth" value="8"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="40"/>
        <transform name="to_world"><lookat origin="2.9, 1.8, 3.9" target="0, 0, 0" up="0, 1, 0"/></transform>
        <sampler type="sobol"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="320"/><integer name="height" value="240"/><rfilter type="gaussian"/>
        </film>
    </sensor>
    <emitter type="constant"><spectrum name="radiance" type="d65"><float name="scale" value="0.35"/></spectrum></emitter>
    <shape type="rectangle">
        <transform name="to_world"><scale value="1.5"/><lookat origin="-4, 6, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
        <emitter type="area"><spectrum name="radiance" type="d65"><float name="scale" value="14"/></spectrum></emitter>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="30"/><translate y="-1.6"/></transform>
        <bsdf type="diffuse"><spectrum name="reflectance" type="measured"><string name="name" value="colorchecker/neutral-6.5"/></spectrum></bsdf>
    </shape>
    <bsdf type="roughconductor" id="metal"><string name="material" value="Cu"/><float name="alpha" value="0.1"/></bsdf>
"""


def frame(axis):
    """Two directions across an axis."""
    other = (1.0, 0.0, 0.0) if abs(axis[0]) < 0.9 else (0.0, 1.0, 0.0)
    across = cross(axis, other)
    length = math.sqrt(sum(x * x for x in across))
    across = tuple(x / length for x in across)
    return across, cross(axis, across)


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def flake(centre, radius, axis, depth):
    """The balls around one, each with its own around it, away from the ball that it touches."""
    yield centre, radius
    if depth == 0:
        return
    u, v = frame(axis)
    for count, height, turn in ((6, 0.0, 0.0), (3, math.sqrt(2 / 3), math.pi / 6)):
        across = math.sqrt(1 - height * height)
        for number in range(count):
            angle = turn + 2 * math.pi * number / count
            away = tuple(
                height * axis[i] + across * (math.cos(angle) * u[i] + math.sin(angle) * v[i]) for i in range(3)
            )
            smaller = radius / 3
            place = tuple(centre[i] + (radius + smaller) * away[i] for i in range(3))
            yield from flake(place, smaller, away, depth - 1)


def main():
    depth = int(sys.argv[1]) if len(sys.argv) > 1 else 3
    balls = list(flake((0.0, 0.0, 0.0), 0.75, (0.0, 1.0, 0.0), depth))
    lines = [
        f'    <shape type="sphere"><point name="center" x="{x:.6f}" y="{y:.6f}" z="{z:.6f}"/>'
        f'<float name="radius" value="{radius:.6f}"/><ref id="metal"/></shape>\n'
        for (x, y, z), radius in balls
    ]
    text = HEAD.format(count=len(balls)) + "".join(lines) + "</scene>\n"
    Path(__file__).with_name("scene.xml").write_text(text)


main()
