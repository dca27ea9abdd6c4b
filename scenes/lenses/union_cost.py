"""What a union of opaque shapes costs beside the same shapes by themselves: union_cost.py path/to/abbe [PAIRS]

Renders 225 clasps, of a torus, a cone and a ball each, as unions and as 675 shapes, in turn, on one thread. Prints the median user times and the
quartiles of their ratio, and whether the pictures are the same.
"""

import resource
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

SCENE = """<scene version="3.0.0"><integrator type="path"><integer name="max_depth" value="6"/></integrator>
<sensor type="perspective"><float name="fov" value="45"/><transform name="to_world"><lookat origin="0, -14, 11" target="0, 0, 0" up="0, 0, 1"/></transform>
<sampler type="sobol"><integer name="sample_count" value="4"/></sampler>
<film type="hdrfilm"><integer name="width" value="192"/><integer name="height" value="128"/><rfilter type="box"/></film></sensor>
<bsdf type="diffuse" id="matt"><spectrum name="reflectance" value="0.6"/></bsdf>
<shape type="rectangle"><transform name="to_world"><scale value="20"/></transform><ref id="matt"/></shape>
{shapes}<emitter type="constant"><spectrum name="radiance" value="1"/></emitter></scene>"""
MATT = '<ref id="matt"/>'


def clasp(column, row):
    """The shapes of one, each with a place for its material."""
    x, y, angle = column - 7, row - 7, (column * 37 + row * 53) % 180
    ring = f'<rotate x="1" y="{column % 5 * 0.3}" angle="{angle}"/><translate x="{x}" y="{y}" z="0.5"/>'
    return (
        '<shape type="torus"><float name="major_radius" value="0.35"/><float name="minor_radius" value="0.08"/>'
        f'<transform name="to_world">{ring}</transform>%s</shape>',
        f'<shape type="cone"><point name="p0" value="{x}, {y}, 0"/><point name="p1" value="{x}, {y}, 0.5"/>'
        '<float name="radius" value="0.22"/><float name="radius1" value="0.05"/>%s</shape>',
        f'<shape type="sphere"><point name="center" x="{x + 0.35}" y="{y}" z="0.5"/><float name="radius" value="0.15"/>%s</shape>',
    )


def user_time(abbe, scene):
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    subprocess.run([abbe, "render", scene, "-q", "--threads", "1", "-o", scene.with_suffix(".exr")], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def main():
    abbe, pairs = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 15
    clasps = [clasp(column, row) for column in range(15) for row in range(15)]
    with tempfile.TemporaryDirectory() as folder:
        union, plain = (Path(folder) / f"{name}.xml" for name in ("union", "plain"))
        union.write_text(SCENE.format(shapes="".join('<shape type="union">' + MATT + "".join(s % "" for s in c) + "</shape>" for c in clasps)))
        plain.write_text(SCENE.format(shapes="".join(s % MATT for c in clasps for s in c)))
        times = {union: [], plain: []}
        for pair in range(pairs):
            for scene in (union, plain) if pair % 2 else (plain, union):
                times[scene].append(user_time(abbe, scene))
        same = union.with_suffix(".png").read_bytes() == plain.with_suffix(".png").read_bytes()
    low, middle, high = statistics.quantiles([a / b for a, b in zip(times[union], times[plain])], n=4)
    print(f"unions {statistics.median(times[union]):.3f} s, plain shapes {statistics.median(times[plain]):.3f} s")
    print(f"ratio {middle:.3f}, quartiles {low:.3f} and {high:.3f}; the same picture: {same}")


if __name__ == "__main__":
    main()
