"""Rendered irradiances are the form factors of Howell's catalogue

The mean irradiance on a body under another of radiance L is πL times the form factor (configuration factor) from the body to the other, known in
closed form for rectangles that face each other (C-11) or share an edge (C-14), for coaxial disks (C-41) and for a disk and a ball on its axis.
"""

import numpy as np
from harness.claim import Planted
from harness.plots import plt
from transport_common import area, film, integrator, diffuse, scene, shape, spectrum

METHOD = """By an `irradiancemeter` on the receiver (16 × 16 pixels that divide it evenly, light found by chance), and for rectangles by an
orthographic view from behind of a receiver that is a diffuse sheet of transmittance 0.8, whose mean radiance is 0.8 LF (light samples, weighed against
scattering). Errors are those that the files state, summed over the 256 pixels, whose errors are independent."""
DATA = """J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors: C-11, C-14, C-41; ball and disk from the solid angle of a cone, F
= (1 − 1/√(1 + (r/h)²))/2 from ball to disk."""

BRIGHTER = "emitters 1 % brighter"
TURNED = "normals of a hundredth of the facing rectangles turned round"
PLANTED = [
    Planted(BRIGHTER, ("each form factor by irradiance meter", "each form factor by camera")),
    Planted(TURNED, ("each form factor by irradiance meter", "each form factor by camera")),
    Planted("light samples by the balance, scattering by the power heuristic", ("each form factor by camera",), "transport_mixed_heuristics"),
]
SHEET = 0.8
SHEET_BSDF = f'<bsdf type="diffusetransmitter">{spectrum("reflectance", 0)}{spectrum("transmittance", SHEET)}</bsdf>'


def facing(a, b, c):
    """C-11: equal rectangles a × b at distance c."""
    x, y = a / c, b / c
    p, q = np.sqrt(1 + x * x), np.sqrt(1 + y * y)
    inner = np.log(p * q / np.sqrt(1 + x * x + y * y)) + x * q * np.arctan(x / q) + y * p * np.arctan(y / p) - x * np.arctan(x) - y * np.arctan(y)
    return 2 / (np.pi * x * y) * inner


def at_right_angles(width, height, edge):
    """C-14: from a rectangle of `width` to one of `height` at right angles, with a common edge."""
    w, h = width / edge, height / edge
    ww, hh = w * w, h * h
    total = w * np.arctan(1 / w) + h * np.arctan(1 / h) - np.sqrt(hh + ww) * np.arctan(1 / np.sqrt(hh + ww))
    first = (1 + ww) * (1 + hh) / (1 + ww + hh)
    second = ww * (1 + ww + hh) / ((1 + ww) * (ww + hh))
    third = hh * (1 + hh + ww) / ((1 + hh) * (hh + ww))
    return (total + 0.25 * (np.log(first) + ww * np.log(second) + hh * np.log(third))) / (np.pi * w)


def disks(receiver, emitter, distance):
    """C-41: from one coaxial disk to the other."""
    a, b = receiver / distance, emitter / distance
    x = 1 + (1 + b * b) / (a * a)
    return 0.5 * (x - np.sqrt(x * x - 4 * (b / a) ** 2))


def facing_down(half, height, light, turned):
    """A rectangle over z = 0, of which a hundredth, across x, is a piece of its own and may be turned to face up."""

    def piece(low, high, flip):
        middle, width = half[0] * (low + high) / 2, half[0] * (high - low) / 2
        to = f'<scale x="{width}" y="{half[1]}"/><rotate x="1" angle="180"/><translate x="{middle}" z="{height}"/>'
        return shape("rectangle", to, light + f'<boolean name="flip_normals" value="{str(flip).lower()}"/>')

    return piece(-1, 0, False) + piece(0, 0.02, turned) + piece(0.02, 1, False)


def cases(light, turned):
    """name -> (kind and scale of the receiver, emitters, form factor from receiver to emitter)."""

    def disk_above(scale, height):
        return shape("disk", f'<scale {scale}/><rotate x="1" angle="180"/><translate z="{height}"/>', light)

    def upright(height):
        """From the edge x = −1 of the receiver upwards, facing +x."""
        return shape("rectangle", f'<scale x="{height / 2}" y="1"/><rotate y="1" angle="90"/><translate x="-1" z="{height / 2}"/>', light)

    def ball(radius, height):
        return f'<shape type="sphere"><point name="center" value="0 0 {height}"/><float name="radius" value="{radius}"/>{light}</shape>'

    square = ("rectangle", 'value="1"')
    disk = ("disk", 'value="1"')
    return {
        "squares, distance of a side": (square, facing_down((1, 1), 2, light, turned), facing(2, 2, 2)),
        "squares, distance of a tenth": (square, facing_down((1, 1), 0.2, light, turned), facing(2, 2, 0.2)),
        "rectangles 2 × 1, distance 1": (("rectangle", 'x="1" y="0.5"'), facing_down((1, 0.5), 1, light, turned), facing(2, 1, 1)),
        "square and square on an edge": (square, upright(2), at_right_angles(2, 2, 2)),
        "square and strip on an edge": (square, upright(0.5), at_right_angles(2, 0.5, 2)),
        "disks, distance of the radius": (disk, disk_above('value="1"', 1), disks(1, 1, 1)),
        "disks, the emitter half as wide": (disk, disk_above('value="0.5"', 0.5), disks(1, 0.5, 0.5)),
        # 4πr² F(ball to disk) = π F(disk to ball), for a disk of radius 1.
        "disk and ball": (disk, ball(0.5, 1), 2 * 0.5**2 * (1 - 1 / np.sqrt(2))),
    }


def run(claim):
    light = area(1.01 if claim.planted == BRIGHTER else 1) + diffuse(0)
    rows, shown = [], []

    def measure(name, seed, factor, sensor, *content):
        """Mean over the pixels and its standard error."""
        file = scene(claim.work / f"{name}.xml", integrator("path", 2), sensor, *content)
        _, radiance, error = claim.abbe.render(file, 1024 if claim.quick else 16384, seed, ("--spectral", 1, "--range", "555:556")).spectrum()
        return radiance.mean() * factor, np.sqrt(np.sum(error**2)) / error.size * factor

    for number, (name, ((kind, scale), emitters, truth)) in enumerate(cases(light, claim.planted == TURNED).items()):
        meter = shape(kind, f"<scale {scale}/>", f'<sensor type="irradiancemeter">{film(16, 16)}</sensor>' + diffuse(0))
        shown.append((name, "irradiance meter", truth, *measure(f"meter{number}", 2 * number + 1, 1 / np.pi, "", meter, emitters)))
        if kind == "rectangle":
            # Upwards, from below; the film is the receiver.
            aspect = 2 if "y=" in scale else 1
            look = '<lookat origin="0, 0, -3" target="0, 0, 0" up="0, 1, 0"/>'
            camera = f'<sensor type="orthographic"><transform name="to_world">{look}</transform>{film(16, 16 // aspect)}</sensor>'
            sheet = shape(kind, f"<scale {scale}/>", SHEET_BSDF)
            shown.append((name, "camera", truth, *measure(f"view{number}", 2 * number + 2, 1 / SHEET, camera, sheet, emitters)))
    names, ways, truth, mean, error = (np.array(part) for part in zip(*shown))
    for way in ("irradiance meter", "camera"):
        one = ways == way
        claim.agrees(f"each form factor by {way}", mean[one], truth[one], error[one], 200)
    claim.table(("bodies", "measured by", "form factor", "measured", "standard error", "t"),
                [(n, w, f"{f:.6f}", f"{m:.6f}", f"{e:.1e}", f"{(m - f) / e:+.1f}") for n, w, f, m, e in shown], "From the receiver to the emitter.")
    figure, axes = plt.subplots(figsize=(7.2, 3.4))
    axes.errorbar((mean / truth - 1) * 100, np.arange(len(names)), xerr=2 * error / truth * 100, fmt="o")
    axes.set_yticks(np.arange(len(names)), [f"{n} ({w})" for n, w in zip(names, ways)], fontsize=7.5)
    axes.axvline(0, color="black", lw=0.8)
    axes.set(xlabel="measured off the closed form (%), with two standard errors")
    axes.invert_yaxis()
    claim.figure("factors", figure, "Each form factor over its closed form. A per cent of light more would move every dot by one.")
