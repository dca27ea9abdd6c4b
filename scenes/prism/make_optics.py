"""Makes prism.obj and lens.obj and prints where they stand.

Run it in this folder: python3 make_optics.py (needs numpy). Everything is drawn from above: a point x + 1j * u lies x to
the right and u away from the camera, so u = -z. Lengths are decimetres. The centre of the screen is the origin.
"""

from pathlib import Path

import numpy as np

APEX_ANGLE = 55.0  # degrees between the two faces of the prism
INCIDENCE = 65.0  # degrees, of the central ray on the first face
FACE = 0.52  # width of the prism's faces
HEIGHT = 0.46  # of prism and lens
THROW = 1.30  # from the point where the central ray leaves the prism to the screen
BEARING = 44.0  # degrees between the camera and the prism, as seen from the screen
LENS_AHEAD = 0.23  # from the lens to the prism, along the central ray
SLIT_AHEAD = 0.40  # from the slit to the lens
LENS_THICKNESS, LENS_HALF_WIDTH = 0.07, 0.105
LENS_INDEX = 1.4585  # fused silica at 588 nm
LENS_FOCUS = 1.30  # where the lens without its correction would image the slit
# The prism in the converging beam has coma and astigmatism; this much of (y / half width)^2, ^3, ^4 on the lens's front
# cancels most of it. Found by minimising the spread of rays on the screen at 450, 500, 550 and 620 nm.
CORRECTION = (-0.1656e-3, 2.7711e-3, 1.2089e-3)
STRIPS = 64  # flat strips that each of the lens's surfaces is made of
# N-SF66 by SCHOTT's Sellmeier formula: data/dielectrics/dispersion_formulas.csv
PRISM_INDEX = {400: 2.01404, 450: 1.97363, 500: 1.94875, 550: 1.93215, 600: 1.92023, 650: 1.91135, 700: 1.90446}


def heading(degrees):
    return np.exp(1j * np.radians(degrees))


def cross(a, b):
    return (a.conjugate() * b).imag


def dot(a, b):
    return (a.conjugate() * b).real


def meet(origin, direction, a, b):
    """Distance to the line through a and b, and where between them (0 to 1) it is met."""
    return cross(a - origin, b - a) / cross(direction, b - a), cross(a - origin, direction) / cross(direction, b - a)


def refract(direction, edge, ratio):
    """Snell's law in vectors at a surface that runs along `edge`; `ratio` is index before over index behind."""
    normal = 1j * edge / abs(edge)
    if dot(normal, direction) > 0:
        normal = -normal
    cosine = -dot(normal, direction)
    inside = 1 - ratio**2 * (1 - cosine**2)
    return None if inside < 0 else ratio * direction + (ratio * cosine - np.sqrt(inside)) * normal


def sag(focus, y):
    """Depth of the hyperbola of eccentricity n whose focus, `focus` away in air, the glass images to infinity."""
    n = LENS_INDEX
    a = focus / (n + 1)
    return a * (np.sqrt(1 + y**2 / (a**2 * (n**2 - 1))) - 1)


def design():
    """Prism corners, lens outlines and slit on the bench, and headings (degrees) of the central ray."""
    n = PRISM_INDEX[550]
    inside = np.degrees(np.arcsin(np.sin(np.radians(INCIDENCE)) / n))
    leaving = np.degrees(np.arcsin(n * np.sin(np.radians(APEX_ANGLE - inside))))
    out_to = 90 - BEARING
    into = out_to - (INCIDENCE + leaving - APEX_ANGLE)
    first, second = heading(into + INCIDENCE + 90), heading(into + INCIDENCE + 90 - APEX_ANGLE)  # faces, from the apex
    entry = first * FACE / 2
    glass = heading(into + INCIDENCE - inside)
    exit_point = entry + meet(entry, glass, 0j, second * FACE)[0] * glass
    apex = -THROW * heading(out_to) - exit_point
    ahead = heading(into)
    vertex = apex + entry - LENS_AHEAD * ahead
    y = np.linspace(-LENS_HALF_WIDTH, LENS_HALF_WIDTH, STRIPS + 1)
    back = -LENS_THICKNESS + sag(SLIT_AHEAD, y)
    front = -sag(LENS_FOCUS, y) - sum(c * (y / LENS_HALF_WIDTH) ** k for k, c in enumerate(CORRECTION, 2))
    return {
        "prism": (apex, apex + first * FACE, apex + second * FACE),
        "vertex": vertex,
        "into": into,
        "out_to": out_to,
        "leaving": leaving,
        "back": back + 1j * y,
        "front": front + 1j * y,
        "slit": vertex - (LENS_THICKNESS + SLIT_AHEAD) * ahead,
    }


def trace(bench, height, index):
    """Where on the screen a ray from the middle of the slit lands that meets the lens at `height`, or None."""
    ahead, screen = heading(bench["into"]), heading(-BEARING / 2)
    origin = bench["slit"]
    direction = bench["vertex"] - LENS_THICKNESS * ahead + 1j * height * ahead - origin
    direction /= abs(direction)
    for outline, ratio in ((bench["back"], 1 / LENS_INDEX), (bench["front"], LENS_INDEX)):
        points = bench["vertex"] + outline * ahead
        strip = next((k for k in range(STRIPS) if 0 <= meet(origin, direction, *points[k : k + 2])[1] <= 1), None)
        if strip is None:
            return None
        a, b = points[strip : strip + 2]
        origin, direction = origin + meet(origin, direction, a, b)[0] * direction, refract(direction, b - a, ratio)
    apex, first, second = bench["prism"]
    for corner, ratio in ((first, 1 / index), (second, index)):
        distance, where = meet(origin, direction, apex, corner)
        origin, direction = origin + distance * direction, refract(direction, corner - apex, ratio)
        if direction is None or not 0 <= where <= 1:
            return None
    return dot(screen, origin + meet(origin, direction, 0j, screen)[0] * direction)


def write(path, text, outline, bands):
    """An upright solid: the outline, counter-clockwise from above, between two heights; `bands` tile its top."""
    m = len(outline)
    lines = [f"# {text}. Made by make_optics.py; lengths in decimetres"]
    lines += [f"v {p.real:.6f} {y:.6f} {-p.imag:.6f}" for y in (0.0, HEIGHT) for p in outline]
    sides = [(k, (k + 1) % m, (k + 1) % m + m, k + m) for k in range(m)]
    tops = [tuple(k + m for k in band) for band in bands]
    bottoms = [tuple(reversed(band)) for band in bands]
    lines += ["f " + " ".join(str(k + 1) for k in face) for face in sides + tops + bottoms]
    Path(path).write_text("\n".join(lines) + "\n")


def main():
    bench = design()
    corners = bench["prism"]
    centre = sum(corners) / 3
    turn = np.degrees(np.angle(corners[0] - centre))
    local = [(corner - centre) * heading(-turn) for corner in corners]
    if cross(local[1] - local[0], local[2] - local[0]) < 0:
        local.reverse()
    write("prism.obj", f"A prism of {APEX_ANGLE:.0f} degrees about the y axis, its apex towards +x", local, [(0, 1, 2)])
    outline = list(bench["front"]) + list(bench["back"][::-1])
    m = len(outline)
    bands = [(k, k + 1, m - 2 - k, m - 1 - k) for k in range(STRIPS)]
    write("lens.obj", "A lens for light along +x that images a line onto a line", outline, bands)
    print(f"prism: rotate {turn:.3f} degrees, translate x {centre.real:.4f} z {-centre.imag:.4f}")
    print(f"lens and lamp: rotate {bench['into']:.3f} degrees, translate x {bench['vertex'].real:.4f} z {-bench['vertex'].imag:.4f}")
    print(f"central ray: leaves at {bench['leaving']:.1f} degrees, deviated by {bench['out_to'] - bench['into']:.1f}")
    for nm, index in PRISM_INDEX.items():
        heights = np.linspace(-0.98, 0.98, 41) * LENS_HALF_WIDTH
        landed = [x for x in (trace(bench, height, index) for height in heights) if x is not None]
        print(f"{nm} nm: lands at {np.mean(landed):+.3f}, spread {np.std(landed):.3f}, {len(landed)} of 41 rays")


if __name__ == "__main__":
    main()
