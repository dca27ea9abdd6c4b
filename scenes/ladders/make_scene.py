"""Writes scene.xml: ladders on a logarithmic spiral (after the model of G. Wyvill, Practical Ray Tracing, 1995, figure 11).

    python make_scene.py [LADDERS]

One ladder is a group of cylinders; the others are instances of it, each turned and shrunk by the same as the one before. 40 without an argument.
"""

import sys
from pathlib import Path

HEAD = """<!-- {count} ladders on a logarithmic spiral, made by make_scene.py -->
<scene version="3.0.0">
    <default name="spp" value="64"/>
    <integrator type="path"><integer name="max_depth" value="6"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="38"/>
        <transform name="to_world"><lookat origin="1.5, 4.2, 6.2" target="0.1, 0.5, 0" up="0, 1, 0"/></transform>
        <sampler type="sobol"><integer name="sample_count" value="$spp"/></sampler>
        <film type="hdrfilm">
            <integer name="width" value="320"/><integer name="height" value="240"/><rfilter type="gaussian"/>
        </film>
    </sensor>
    <emitter type="constant"><spectrum name="radiance" type="d65"><float name="scale" value="0.3"/></spectrum></emitter>
    <shape type="sphere">
        <point name="center" x="-5" y="8" z="4"/><float name="radius" value="1"/>
        <emitter type="area"><spectrum name="radiance" type="d65"><float name="scale" value="30"/></spectrum></emitter>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="-90"/><scale value="30"/></transform>
        <bsdf type="diffuse"><spectrum name="reflectance" type="measured"><string name="name" value="colorchecker/neutral-8"/></spectrum></bsdf>
    </shape>
    <shape type="shapegroup" id="ladder">
{ladder}    </shape>
"""

WOOD = '<bsdf type="plastic"><spectrum name="diffuse_reflectance" type="measured"><string name="name" value="colorchecker/orange"/></spectrum></bsdf>'
TURN, SHRINK = 17.0, 0.94


def bar(a, b, radius):
    ends = "".join(f'<point name="p{i}" x="{x}" y="{y}" z="{z}"/>' for i, (x, y, z) in enumerate((a, b)))
    return f'        <shape type="cylinder">{ends}<float name="radius" value="{radius}"/>{WOOD}</shape>\n'


def main():
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 40
    rails = [bar((0.0, 0.0, z), (0.0, 2.4, z), 0.05) for z in (-0.3, 0.3)]
    rungs = [bar((0.0, 0.2 + 0.25 * i, -0.3), (0.0, 0.2 + 0.25 * i, 0.3), 0.035) for i in range(9)]
    tops = [
        f'        <shape type="sphere"><point name="center" x="0" y="2.4" z="{z}"/><float name="radius" value="0.05"/>{WOOD}</shape>\n'
        for z in (-0.3, 0.3)
    ]
    text = HEAD.format(count=count, ladder="".join(rails + rungs + tops))
    for i in range(count):
        size = SHRINK**i
        text += (
            f'    <shape type="instance"><ref id="ladder"/><transform name="to_world"><scale value="{size:.6f}"/>'
            f'<rotate z="1" angle="15"/><translate x="{2.4 * size:.6f}"/><rotate y="1" angle="{TURN * i:.3f}"/></transform></shape>\n'
        )
    Path(__file__).with_name("scene.xml").write_text(text + "</scene>\n")


main()
