"""Twelve scenes in the manner of Mitsuba's own gallery, `gallery/*.xml`: the file's defaults for filter (gaussian) and sampler (independent), colours in RGB.
This writes the pictures and meshes that they name. The same call writes the same bytes."""

import struct
import zlib

import numpy as np

from speed import assets
from speed.assets import ASSETS
from speed.measure import Scene
from speed.programs import HERE


class Gallery(Scene):
    @property
    def path(self):
        return HERE / "gallery" / f"{self.name}.xml"


SCENES = tuple(
    Gallery(name, what, 1, trimmed)
    for name, what, trimmed in (
        ("preview_diffuse", "material preview: bitmap", False),
        ("preview_conductor", "material preview: rough copper", False),
        ("preview_dielectric", "material preview: glass", True),
        ("preview_plastic", "material preview: smooth plastic", False),
        ("preview_roughplastic", "material preview: rough plastic", False),
        ("preview_roughdielectric", "material preview: frosted glass", True),
        ("bunny", "mesh under a sunny sky", False),
        ("cbox", "Cornell box, mirror and glass", True),
        ("plates", "Veach's plates, lamps are balls", False),
        ("lens", "balls out of focus", True),
        ("textures", "bitmaps and checkers", False),
        ("instances", "400 bushes under a sunny sky", False),
    )
)


class Lamps(Scene):
    @property
    def path(self):
        return HERE / "lamps" / f"{self.name.split('-')[0]}.xml"


# The triangles shine as much, all together, whatever their number: sizes go with its root.
EMITTERS = (100, 10_000, 1_000_000)
LAMPS = (
    Lamps("bright_texel", "screen with one bright texel", 1),
    Lamps("small_sun", "small sun in an environment map", 1),
    Lamps("unequal", "very unequal lamps", 1),
    *(Lamps(f"emitters-{count}", f"{count} emitters", 1, defines={"count": str(count)}) for count in EMITTERS),
)


def write_lamps():
    ASSETS.mkdir(parents=True, exist_ok=True)
    assets.spectra()
    screen = np.full((64, 64, 3), 0.3)
    screen[20, 41] = 300, 280, 240
    exr("screen.exr", screen)
    height, width = 1024, 2048
    v, u = (np.mgrid[0:height, 0:width] + 0.5) / [[[height]], [[width]]]
    theta, phi = np.pi * v, 2 * np.pi * u
    toward = np.sin(theta) * np.sin(0.9) * np.cos(phi - 0.6) + np.cos(theta) * np.cos(0.9)
    exr("sun.exr", np.where(toward[..., None] > np.cos(np.radians(0.25)), 1e5, np.where(np.cos(theta) > 0, 0.6, 0.1)[..., None]) * [0.9, 0.95, 1])
    for count in EMITTERS:
        random = np.random.default_rng(5)
        centre = random.uniform(-1, 1, (count, 1, 3)) * [4, 3, 0.8] + [0, 0, 3.2]
        corners = centre + 0.04 * (100 / count) ** 0.5 * random.normal(size=(count, 3, 3))
        ply(f"sparks-{count}.ply", corners.reshape(-1, 3), np.arange(3 * count).reshape(-1, 3))


def write():
    ASSETS.mkdir(parents=True, exist_ok=True)
    assets.spectra()
    assets.ball(76800)
    skies()
    pictures()
    preview()
    bushes()


def skies():
    """A sky with the sun in it, and a dark studio with three soft boxes."""
    height, width = 256, 512
    v, u = (np.mgrid[0:height, 0:width] + 0.5) / [[[height]], [[width]]]
    theta, phi = np.pi * v, 2 * np.pi * u
    up = np.cos(theta)
    blue, haze, ground = np.array([0.25, 0.45, 0.9]), np.array([0.8, 0.85, 0.9]), np.array([0.12, 0.1, 0.08])
    sunny = np.where(up[..., None] > 0, haze + (blue - haze) * np.clip(up, 0, 1)[..., None] ** 0.5, ground)
    toward = np.sin(theta) * np.sin(0.9) * np.cos(phi - 0.6) + up * np.cos(0.9)
    sunny += np.where(toward > np.cos(0.02), 3000, 0)[..., None] * [1, 0.9, 0.75]
    sunny += np.exp((toward - 1) * 30)[..., None] * [2, 1.7, 1.2]
    exr("sunny.exr", sunny)
    studio = 0.06 + 0.06 * np.clip(up, 0, 1)[..., None] * np.ones(3)
    for at, size, value in (((0.12, 0.3), (0.06, 0.08), (14, 13, 12)), ((0.55, 0.22), (0.12, 0.05), (5, 6, 8)), ((0.8, 0.42), (0.02, 0.14), (9, 9, 9))):
        inside = (np.abs(u - at[0]) < size[0] / 2) & (np.abs(v - at[1]) < size[1] / 2)
        studio = np.where(inside[..., None], value, studio)
    exr("studio.exr", studio)


def exr(name, pixels):
    import OpenEXR

    channels = {c: np.ascontiguousarray(pixels[..., i], dtype=np.float32) for i, c in enumerate("RGB")}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, channels).write(str(ASSETS / name))


def pictures():
    """Rings of wood, glazed tiles and how rough something is."""
    y, x = np.mgrid[0:512, 0:512] / 512
    rings = 0.5 + 0.5 * np.sin(60 * (x + 0.08 * np.sin(2 * np.pi * y) + 0.03 * np.sin(6 * np.pi * (x + y))))
    png(ASSETS / "wood.png", (np.array([110, 62, 30]) + rings[..., None] * [90, 68, 44]).astype(np.uint8))
    column, row = np.floor(4 * x), np.floor(4 * y)
    joint = np.minimum((4 * x) % 1, (4 * y) % 1) < 0.06
    hue = (np.sin(column * 12.9898 + row * 78.233) * 43758.5453) % 1
    tile = np.array([60, 90, 130]) + hue[..., None] * [140, 60, 20] + 20 * np.sin(40 * (x * y))[..., None]
    png(ASSETS / "tiles.png", np.where(joint[..., None], 190, tile).astype(np.uint8))
    png(ASSETS / "rough.png", (40 + 60 * (0.5 + 0.5 * np.sin(30 * x) * np.sin(30 * y))).astype(np.uint8))


def png(path, pixels):
    """8 bits, one or three channels."""
    pixels = np.atleast_3d(pixels)
    height, width, channels = pixels.shape
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, {1: 0, 3: 2}[channels], 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def revolved(name, profile, normals, segments=192):
    """A surface of revolution about z: points (radius, z) and normals of its profile."""
    n = len(profile)
    angle = np.linspace(0, 2 * np.pi, segments + 1)
    around = np.stack([np.cos(angle), np.sin(angle)], -1)
    place = lambda p: np.concatenate([around[:, None] * p[None, :, :1], np.broadcast_to(p[None, :, 1:], (segments + 1, n, 1))], -1).reshape(-1, 3)
    u, v = np.meshgrid(angle / (2 * np.pi), np.linspace(0, 1, n), indexing="ij")
    corner = (np.arange(segments)[:, None] * n + np.arange(n - 1)).ravel()
    a, b, c, d = corner, corner + n, corner + n + 1, corner + 1
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)])
    points = place(profile)
    corners = points[triangles]
    flat = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) < 1e-9
    ply(name, np.concatenate([points, place(normals), np.stack([u.ravel(), v.ravel()], -1)], 1), triangles[~flat])


def ply(name, vertices, triangles):
    records = np.empty(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    records["count"], records["corners"] = 3, triangles
    names = ("x", "y", "z", "nx", "ny", "nz", "u", "v")[: vertices.shape[1]]
    lines = ["ply", "format binary_little_endian 1.0", f"element vertex {len(vertices)}", *(f"property float {n}" for n in names)]
    lines += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header\n"]
    (ASSETS / name).write_bytes("\n".join(lines).encode() + vertices.astype("<f4").tobytes() + records.tobytes())


def arc(radius, start, end, count, z=0.0):
    """Points of a circle's arc and its outward normals; angles from +z."""
    t = np.linspace(start, end, count)
    normals = np.stack([np.sin(t), np.cos(t)], -1)
    return normals * radius + [0, z], normals


def preview():
    """An open shell with a round rim, the ball within, and a stand. Profiles run so that triangles face outward."""
    opening = 0.75
    outer, outward = arc(1, np.pi, opening, 96)
    inner, inward = arc(0.92, opening, np.pi, 96)
    t = np.linspace(0, np.pi, 17)[1:-1]
    across, along = np.array([np.sin(opening), np.cos(opening)]), np.array([-np.cos(opening), np.sin(opening)])
    rim_normals = np.cos(t)[:, None] * across + np.sin(t)[:, None] * along
    rim = 0.96 * across + 0.04 * rim_normals
    revolved("shell.ply", np.concatenate([outer, rim, inner]), np.concatenate([outward, rim_normals, -inward]))
    revolved("core.ply", *arc(0.6, np.pi, 0, 64))
    profile, normals = [], []
    corners = np.array([[1.15, 0.0], [1.15, 0.06], [0.7, 0.12], [0.0, 0.12]])
    for a, b in zip(corners, corners[1:]):
        along = (b - a) / np.linalg.norm(b - a)
        profile += [a, b]
        normals += [[along[1], -along[0]]] * 2
    revolved("stand.ply", np.array(profile), np.array(normals))


def bushes():
    """Leaves on a ball, and a field of them."""
    random = np.random.default_rng(11)
    count = 6000
    centre = random.normal(size=(count, 3))
    centre *= (0.5 * random.uniform(0.3, 1, (count, 1)) ** (1 / 3)) / np.linalg.norm(centre, axis=1, keepdims=True)
    a = random.normal(size=(count, 3))
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = np.cross(a, random.normal(size=(count, 3)))
    b /= np.linalg.norm(b, axis=1, keepdims=True)
    quads = centre[:, None] + 0.05 * np.stack([-a, 0.4 * b, a, -0.4 * b], 1)
    first = 4 * np.arange(count)[:, None]
    ply("bush.ply", quads.reshape(-1, 3), np.concatenate([first + [0, 1, 2], first + [0, 2, 3]]))
    lines = ['<scene version="3.0.0">']
    for row in range(20):
        for column in range(20):
            x, y = (np.array([column, row]) - 9.5) * 0.95 + random.uniform(-0.25, 0.25, 2)
            scale, angle = random.uniform(0.6, 1.1), random.uniform(0, 360)
            pose = f'<scale value="{scale:.3f}"/><rotate z="1" angle="{angle:.1f}"/><translate x="{x:.3f}" y="{y:.3f}" z="{0.45 * scale:.3f}"/>'
            lines.append(f'<shape type="instance"><ref id="bush"/><transform name="to_world">{pose}</transform></shape>')
    (ASSETS / "field.xml").write_text("\n".join(lines + ["</scene>\n"]))
