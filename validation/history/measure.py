#!/usr/bin/env python3
"""Figures of the source texts, then and now: renders what can be rendered and prints ours.

    python validation/history/measure.py [--abbe target/release/abbe] [NAME …]

docs/claims-then-and-now.md has the figures beside those of the texts. Needs numpy and OpenEXR.
"""
import argparse
import math
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parents[2]


class Abbe:
    def __init__(self, program, folder):
        self.program, self.folder, self.count = program, Path(folder), 0

    def render(self, scene, *arguments):
        """The channels of a picture of a scene, given by its path or its content, and the CPU seconds that it took."""
        self.count += 1
        if "<" in str(scene):
            path = self.folder / f"scene-{self.count}.xml"
            path.write_text(f'<scene version="3.0.0">{scene}</scene>')
            scene = path
        picture = self.folder / f"picture-{self.count}.exr"
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [self.program, "render", scene, "-q", "-o", picture, *map(str, arguments)]
        subprocess.run(command, check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        seconds = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        channels = OpenEXR.File(str(picture), separate_channels=True).channels()
        return {name: channel.pixels for name, channel in channels.items()}, seconds


def luminance(channels):
    if "Y" in channels:
        return channels["Y"]
    return 0.2126 * channels["R"] + 0.7152 * channels["G"] + 0.0722 * channels["B"]


def film(width, height, pixel_format="luminance"):
    return f"""<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>
        <string name="pixel_format" value="{pixel_format}"/><rfilter type="box"/></film>"""


def meter(origin, target, pixel_format="luminance"):
    return f"""<sensor type="radiancemeter">
        <transform name="to_world"><lookat origin="{origin}" target="{target}" up="0, 1, 0"/></transform>
        {film(1, 1, pixel_format)}</sensor>"""


def flat(width, height):
    """Looks down at the square from -1 to 1 of x and y."""
    return f"""<sensor type="orthographic">
        <transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
        {film(width, height)}</sensor>"""


FURNACE = '<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>'


def comb(abbe):
    """The period that the rows of a comb of triangles show, and the error of a pixel."""
    scene = ROOT / "scenes/effects/comb/scene.xml"
    truth = luminance(abbe.render(scene, "--spp", 4096, "--seed", 9)[0])
    white = truth.max()
    for sampler in ["regular", "jittered"]:
        for spp in [1, 16]:
            y = luminance(abbe.render(scene, "--spp", spp, "--sampler", sampler, "--replicates", 1)[0])
            rows = y[20:30, 30:226]
            rows = rows - rows.mean(axis=1, keepdims=True)
            # Zeros behind the rows tell the period more finely.
            power = (np.abs(np.fft.rfft(rows, 4096)) ** 2).mean(axis=0)
            first = 4096 // 150
            peak = first + power[first:].argmax()
            error = np.sqrt(((y - truth) ** 2).mean()) / white
            off = np.abs((y - truth).mean(axis=1)).max() / white
            print(f"  {sampler}, {spp}: period {4096 / peak:.1f} pixels, error {error:.3f}, rows off by {off:.3f}")


def samples(abbe):
    """Error of a pixel, of the picture's mean, by the samples of a pixel."""
    for name in ["penumbra", "gloss", "defocus", "billiards"]:
        found = []
        for spp in [4, 16, 64, 256]:
            channels, _ = abbe.render(ROOT / f"scenes/effects/{name}/scene.xml", "--spp", spp, "--size", "64x48")
            error, mean = channels["error.G"], channels["G"].mean()
            found.append(f"{np.sqrt((error**2).mean()) / mean:.3f} ({np.quantile(error, 0.95) / mean:.3f})")
        print(f"  {name}: " + ", ".join(found))


def together(abbe):
    """All effects at once against antialiasing alone, at equal samples."""
    found = {}
    for name in ["antialias", "all-together"]:
        scene = ROOT / f"scenes/effects/{name}/scene.xml"
        size = ["--size", "64x48", "--estimator", "plain"]
        truth = luminance(abbe.render(scene, "--spp", 1024, "--seed", 9, *size)[0])
        channels, seconds = abbe.render(scene, "--spp", 64, *size)
        squares = (luminance(channels) - truth) ** 2 / (truth**2 + 0.01 * truth.mean() ** 2)
        squares = np.sort(squares.ravel())[: -(squares.size // 1000)]
        found[name] = seconds, squares.mean()
        print(f"  {name}: {seconds:.2f} CPU s, relMSE {squares.mean():.3g} (without the worst 0.1 % of the pixels)")
    (alone, rough), (all_of_them, fine) = found["antialias"], found["all-together"]
    print(f"  all together over antialias: time {all_of_them / alone:.2f}, relMSE {fine / rough:.2f}")


def copper(abbe):
    """Distance of the chromaticity of a polished metal's reflection from that of the light, by angle."""
    sky = '<emitter type="constant"><spectrum name="radiance" type="d65"/></emitter>'

    def chromaticity(content):
        channels, _ = abbe.render(content + sky, "--spp", 4096)
        x, y, z = (channels[name].mean() for name in "XYZ")
        return np.array([x, y]) / (x + y + z)

    for metal in ["Cu", "Au"]:
        light = chromaticity(meter("0, 0, 1", "1, 0, 1", "xyz"))
        found = []
        for angle in [0, 30, 60, 75, 85, 88]:
            x, z = math.sin(math.radians(angle)), math.cos(math.radians(angle))
            plane = f"""<shape type="rectangle"><transform name="to_world"><scale value="100"/></transform>
                <bsdf type="conductor"><string name="material" value="{metal}"/></bsdf></shape>"""
            seen = chromaticity(meter(f"{x}, 0, {z}", "0, 0, 0", "xyz") + plane)
            found.append(f"{angle}° {np.linalg.norm(seen - light):.3f}")
        print(f"  {metal}: " + ", ".join(found))


def morphine(abbe):
    """40 balls between two mirrors, 10 levels, 9 samples: CPU time of 2048² pixels."""
    place = np.random.default_rng(1).uniform(-1, 1, (40, 3))
    balls = "".join(
        f"""<shape type="sphere"><point name="center" x="{2 * x:.3f}" y="{y:.3f}" z="{z:.3f}"/>
            <float name="radius" value="0.2"/><bsdf type="plastic"/></shape>"""
        for x, y, z in place
    )
    mirrors = "".join(
        f"""<shape type="sphere"><point name="center" x="0" y="{y}" z="0"/><float name="radius" value="3"/>
            <bsdf type="conductor"><string name="material" value="Ag"/></bsdf></shape>"""
        for y in (-4.5, 4.5)
    )
    scene = f"""<integrator type="path"><integer name="max_depth" value="11"/></integrator>
        <sensor type="perspective"><float name="fov" value="60"/>
            <transform name="to_world"><lookat origin="7, 0, 1" target="0, 0, 0" up="0, 0, 1"/></transform>
            {film(512, 512, "rgb")}</sensor>
        <shape type="sphere"><point name="center" x="4" y="0" z="8"/><float name="radius" value="0.5"/>
            <emitter type="area"><spectrum name="radiance" value="50"/></emitter></shape>
        <emitter type="constant"><spectrum name="radiance" value="0.2"/></emitter>{balls}{mirrors}"""
    _, seconds = abbe.render(scene, "--spp", 9, "--replicates", 1)
    print(f"  {16 * seconds:.0f} CPU s (16 times that of 512²)")


def diamond(abbe):
    """Part of a furnace's radiance that a turned diamond returns, by the limit of depth."""
    for depth in [4, 8, 16, 32, 64, 128]:
        scene = f"""<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>{flat(48, 48)}{FURNACE}
            <shape type="revolution"><string name="profile" value="0 -0.45, 0.95 0.15, 0.95 0.2, 0.55 0.5, 0 0.5"/>
                <bsdf type="dielectric"><spectrum name="int_ior" type="measured">
                    <string name="name" value="diamond"/></spectrum></bsdf></shape>"""
        y = luminance(abbe.render(scene, "--spp", 64)[0])
        across = (np.arange(48) + 0.5) / 24 - 1
        inside = across[:, None] ** 2 + across[None, :] ** 2 < 0.9**2
        print(f"  depth {depth}: {y[inside].mean():.3f}")


def zone_plate(abbe):
    """Error of a zone plate at 4 samples, of its mean; on a regular grid of wavelengths the whole picture is off, which is not meant."""
    scene = ROOT / "scenes/effects/zone-plate/scene.xml"
    part = ["--crop", "64,64,64,64"]
    truth = luminance(abbe.render(scene, "--spp", 1024, "--seed", 9, *part)[0])
    for sampler in ["regular", "independent", "jittered", "poisson", "sobol"]:
        y = luminance(abbe.render(scene, "--spp", 4, "--sampler", sampler, "--replicates", 1, "--estimator", "plain", *part)[0])
        y *= truth.mean() / y.mean()
        print(f"  {sampler}: {np.sqrt(((y - truth) ** 2).mean()) / truth.mean():.3f} of the mean")


def mirrors(abbe):
    """What comes by way of 30 mirrors that each reflect 0.9."""
    mirror = """<bsdf type="conductor"><string name="material" value="none"/>
        <spectrum name="specular_reflectance" value="0.9"/></bsdf>"""
    planes = "".join(
        f"""<shape type="rectangle"><transform name="to_world"><scale x="16" y="5"/>{turn}
            <translate x="15" z="{z}"/></transform>{mirror}</shape>"""
        for z, turn in [(0, ""), (1, '<rotate x="1" angle="180"/>')]
    )
    lamp = """<shape type="rectangle"><transform name="to_world"><scale value="5"/><rotate y="1" angle="-90"/>
        <translate x="30"/></transform><emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>"""
    for what, depth in [("no limit of depth, roulette from 5", -1), ("depth 16", 16)]:
        limit = f'<integrator type="path"><integer name="max_depth" value="{depth}"/></integrator>'
        channels, _ = abbe.render(limit + meter("0, 0, 0.5", "1, 0, 1.5") + planes + lamp, "--spp", 65536)
        whole, _ = abbe.render(limit + meter("29.9, 0, 0.5", "31, 0, 0.5") + planes + lamp, "--spp", 1024)
        scale = whole["Y"].mean()
        print(f"  {what}: {channels['Y'].mean() / scale:.4f} ± {channels['error.Y'].mean() / scale:.4f}, 0.9³⁰ = {0.9**30:.4f}")


CLAIMS = [comb, samples, together, copper, morphine, diamond, zone_plate, mirrors]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", default=str(ROOT / "target/release/abbe"))
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(claim.__name__ for claim in CLAIMS))
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        abbe = Abbe(options.abbe, folder)
        for claim in CLAIMS:
            if not options.names or claim.__name__ in options.names:
                print(f"{claim.__name__}: {claim.__doc__}", flush=True)
                claim(abbe)


if __name__ == "__main__":
    main()
