"""Writes the images, meshes and volumes that the scenes need: scenes/{meshes,textures,volumes}. The files are kept beside it; this is where
they come from. Run it with the environment that validation/run makes: validation/.venv/bin/python validation/mitsuba/assets.py

Every picture is coarse and has no symmetry, so that a mirrored, shifted or differently filtered one is seen.
"""

import struct
import sys
import zlib
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parents[1] / "scenes"))
import grids

SCENES = HERE / "scenes"
MESHES, TEXTURES, VOLUMES = (SCENES / folder for folder in ("meshes", "textures", "volumes"))


def png(path, pixels):
    """8 or 16 bits, one, three or four channels."""
    pixels = np.atleast_3d(pixels)
    height, width, channels = pixels.shape
    depth = pixels.dtype.itemsize * 8
    chunk = lambda kind, data: struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + row.astype(pixels.dtype.newbyteorder(">")).tobytes() for row in pixels)
    kind = {1: 0, 2: 4, 3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", width, height, depth, kind, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


def exr(path, pixels):
    import OpenEXR

    names = {1: "Y", 3: "RGB"}[pixels.shape[2]]
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {c: np.ascontiguousarray(pixels[..., i]) for i, c in enumerate(names)}).write(str(path))


def hdr(path, pixels):
    """Radiance's RGBE, not run-length coded."""
    height, width, _ = pixels.shape
    mantissa, exponent = np.frexp(pixels.max(-1))
    scale = np.where(pixels.max(-1) > 1e-32, mantissa * 256 / np.maximum(pixels.max(-1), 1e-32), 0)
    coded = np.concatenate([np.floor(pixels * scale[..., None]), (exponent + 128)[..., None]], -1).astype(np.uint8)
    path.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + f"-Y {height} +X {width}\n".encode() + coded.tobytes())


def bmp(path, pixels):
    height, width, _ = pixels.shape
    data = np.ascontiguousarray(pixels[::-1, :, ::-1]).tobytes()
    assert width % 4 == 0
    path.write_bytes(b"BM" + struct.pack("<IIIIIIHHIIiiII", 54 + len(data), 0, 54, 40, width, height, 1, 24, 0, len(data), 2835, 2835, 0, 0) + data)


def jpeg(path, pixels):
    import mitsuba

    mitsuba.set_variant("scalar_rgb")
    mitsuba.Bitmap(pixels).write(str(path), quality=100)


def images():
    rng = np.random.default_rng(3)
    # Four by three coloured fields, the first row dark, no two alike.
    fields = np.array(
        [
            [[60, 20, 20], [20, 70, 30], [30, 30, 90], [80, 80, 20]],
            [[220, 60, 40], [60, 200, 70], [50, 80, 230], [230, 210, 60]],
            [[240, 200, 190], [190, 240, 250], [128, 128, 128], [250, 240, 250]],
        ],
        np.uint8,
    )
    png(TEXTURES / "fields.png", fields)
    png(TEXTURES / "fields16.png", fields.astype(np.uint16) * 257)
    png(TEXTURES / "grey.png", fields[..., :1] // 2 + np.arange(4, dtype=np.uint8)[None, :, None] * 30)
    png(TEXTURES / "alpha.png", np.concatenate([fields, np.array([[255, 128, 0, 255], [64, 255, 192, 0], [255, 0, 255, 96]], np.uint8)[..., None]], -1))
    # Smooth enough that every JPEG decoder agrees.
    y, x = np.mgrid[0:16, 0:16] / 16
    soft = (255 * np.stack([0.2 + 0.7 * x, 0.8 - 0.6 * y, 0.3 + 0.3 * x + 0.3 * y], -1)).astype(np.uint8)
    jpeg(TEXTURES / "soft.jpg", soft)
    bmp(TEXTURES / "soft.bmp", soft)
    # A ramp with steps, for weights, opacity and roughness.
    ramp = (np.linspace(0, 255, 8)[None, :] * np.linspace(0.4, 1, 4)[:, None]).astype(np.uint8)
    png(TEXTURES / "ramp.png", ramp)
    stripes = np.zeros((1, 4), np.uint8)
    stripes[0] = [0, 255, 255, 90]
    png(TEXTURES / "stripes.png", stripes)
    # Smooth heights and a smooth normal map of waves, 32 × 32.
    y, x = np.mgrid[0:32, 0:32] / 32
    height = 0.5 + 0.3 * np.sin(2 * np.pi * (2 * x + y)) + 0.2 * np.cos(2 * np.pi * (x - 2 * y))
    png(TEXTURES / "heights.png", (height * 65535).astype(np.uint16))
    slope = np.stack([0.5 * np.cos(2 * np.pi * (2 * x + y)), 0.35 * np.sin(2 * np.pi * (x - 2 * y)), np.ones_like(x)], -1)
    slope /= np.linalg.norm(slope, axis=-1, keepdims=True)
    png(TEXTURES / "normals.png", (slope * 127.5 + 127.5).round().astype(np.uint8))
    # Radiance beyond 1: a sky with one warm lamp, one cool strip and a dark ground; 32 × 16.
    sky = np.zeros((16, 32, 3), np.float32)
    sky[:8] = np.linspace([0.25, 0.4, 0.8], [0.9, 0.9, 0.8], 8)[:, None]
    sky[8:] = [0.12, 0.1, 0.06]
    sky[3:5, 5:8] = [14, 9, 4]
    sky[6:8, 20:30] = [1, 2.5, 4]
    sky *= 0.9 + 0.2 * rng.random((16, 32, 1), np.float32)
    exr(TEXTURES / "sky.exr", sky)
    hdr(TEXTURES / "sky.hdr", sky)
    exr(TEXTURES / "slide.exr", (fields.astype(np.float32) / 100) ** 2)
    # Radiance files as reflectances: nothing above 1.
    exr(TEXTURES / "slide_low.exr", fields.astype(np.float32) / 255)
    hdr(TEXTURES / "low.hdr", fields.astype(np.float32) / 256)
    exr(TEXTURES / "grey.exr", (fields[..., :1].astype(np.float32) / 255))


def grid(columns, rows, height):
    """A wavy sheet over [-1, 1]²: positions, normals, uv and quads."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    u, v = u.ravel(), v.ravel()
    x, y = 2 * u - 1, 2 * v - 1
    z = height * np.sin(3 * x + 0.5) * np.cos(2 * y)
    normal = np.stack([-3 * height * np.cos(3 * x + 0.5) * np.cos(2 * y), 2 * height * np.sin(3 * x + 0.5) * np.sin(2 * y), np.ones_like(x)], 1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    at = lambda i, j: j * (columns + 1) + i
    quads = [[at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)] for j in range(rows) for i in range(columns)]
    return np.stack([x, y, z], 1), normal, np.stack([u, v], 1), np.array(quads)


def triangles(quads):
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]], 1).reshape(-1, 3)


def ply(path, form, vertex, faces, face=()):
    """`vertex` and `face`: pairs of (property names, type) and values. `form`: ascii, binary_little_endian or binary_big_endian."""
    codes = {"float": "f", "double": "d", "uchar": "B", "int": "i", "uint": "I", "ushort": "H"}
    lines = ["ply", f"format {form} 1.0", "comment written by assets.py", f"element vertex {len(vertex[0][1])}"]
    lines += [f"property {kind} {name}" for (names, kind), _ in vertex for name in names.split()]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += [f"property {kind} {name}" for (names, kind), _ in face for name in names.split()] + ["end_header"]
    body = []
    order = ">" if form.endswith("big_endian") else "<"
    words = lambda kind, values: (
        " ".join(f"{x:.7g}" if kind in ("float", "double") else str(int(x)) for x in values).encode()
        if form == "ascii"
        else struct.pack(f"{order}{len(values)}{codes[kind]}", *(v if kind in ("float", "double") else int(v) for v in values))
    )
    gap, end = (b" ", b"\n") if form == "ascii" else (b"", b"")
    for i in range(len(vertex[0][1])):
        body.append(gap.join(words(kind, values[i]) for (_, kind), values in vertex) + end)
    for i, corners in enumerate(faces):
        parts = [words("uchar", [len(corners)]), words("int", corners)] + [words(kind, values[i]) for (_, kind), values in face]
        body.append(gap.join(parts) + end)
    path.write_bytes(("\n".join(lines) + "\n").encode() + b"".join(body))


def serialized(path, meshes):
    """Mitsuba's serialized format, version 4; each mesh (name, flags, vertices, normals, uv, colours, triangles)."""
    blob, offsets = b"", []
    for name, flags, vertices, normals, uv, colours, faces in meshes:
        kind = "<f8" if flags & 0x2000 else "<f4"
        body = struct.pack("<I", flags) + name.encode() + b"\0" + struct.pack("<QQ", len(vertices), len(faces))
        for present, values in ((True, vertices), (flags & 1, normals), (flags & 2, uv), (flags & 8, colours)):
            body += np.asarray(values, kind).tobytes() if present else b""
        body += np.asarray(faces, "<u4").tobytes()
        offsets.append(len(blob))
        blob += struct.pack("<HH", 0x041C, 4) + zlib.compress(body, 9)
    path.write_bytes(blob + b"".join(struct.pack("<Q", o) for o in offsets) + struct.pack("<I", len(offsets)))


def obj(path, vertices, normals, uv, faces, relative=False):
    lines = ["# written by assets.py", "mtllib none.mtl", "o sheet"]
    lines += ["v " + " ".join(f"{x:.7g}" for x in v) for v in vertices]
    lines += ["vt " + " ".join(f"{x:.7g}" for x in v) for v in uv] + ["vn " + " ".join(f"{x:.7g}" for x in v) for v in normals]
    corner = lambda i: f"{i + 1}" + (f"/{i + 1 if len(uv) else ''}" if len(uv) or len(normals) else "") + (f"/{i + 1}" if len(normals) else "")
    lines += ["g faces", "usemtl none", "s 1"] + ["f " + " ".join(corner(i) for i in f) for f in faces]
    path.write_text("\n".join(lines) + "\n")


def meshes():
    points, normals, uv, quads = grid(12, 10, 0.25)
    faces = triangles(quads)
    colour = 0.15 + 0.7 * np.stack([uv[:, 0], uv[:, 1], 1 - uv[:, 0] * uv[:, 1]], 1)
    shade = 0.2 + 0.6 * ((np.arange(len(faces)) // 2 + np.arange(len(faces)) // 24) % 3)[:, None] / 2
    coarse = 0.1 + 0.2 * (np.arange(len(faces)) % 4)[:, None] * np.array([1.0, 0.6, 0.3])
    place, turn, map_uv = ("x y z", "float"), ("nx ny nz", "float"), ("u v", "float")
    ply(MESHES / "sheet_ascii.ply", "ascii", [(place, points), (turn, normals), (map_uv, uv), (("r g b", "float"), colour)], faces)
    ply(
        MESHES / "sheet_little.ply",
        "binary_little_endian",
        [(place, points), (("s t", "float"), uv), (("tone_r tone_g tone_b", "float"), colour[:, ::-1])],
        faces,
        [(("tint_r tint_g tint_b", "float"), coarse)],
    )
    ply(
        MESHES / "sheet_big.ply",
        "binary_big_endian",
        [(place, points), (turn, normals), (map_uv, uv), (("dim_x", "float"), 1 - 0.8 * uv[:, :1])],
        faces,
        [(("shade_x", "float"), shade)],
    )
    obj(MESHES / "sheet_quads.obj", points, [], uv, quads)
    obj(MESHES / "sheet_uv_normals.obj", points, normals, uv, quads)
    # A prism over a heptagon: two seven-sided faces and seven quads, nothing but positions.
    angle = 2 * np.pi * np.arange(7) / 7
    rim = np.stack([np.cos(angle), np.sin(angle)], 1)
    corners = np.concatenate([np.c_[rim, -np.ones(7)], np.c_[0.7 * rim, np.ones(7)]])
    sides = [[i, (i + 1) % 7, 7 + (i + 1) % 7, 7 + i] for i in range(7)]
    obj(MESHES / "prism.obj", corners, [], [], [list(range(6, -1, -1)), list(range(7, 14))] + sides)
    smooth, double, flat = 1 | 2 | 0x1000, 2 | 0x2000, 0x10 | 0x1000
    serialized(
        MESHES / "sheets.serialized",
        [
            ("smooth", smooth, points, normals, uv, [], faces),
            ("double", double | 8, points * [1, 1, -1], [], uv, colour, faces),
            ("facets", flat, points * [0.8, 0.8, 1.5], [], [], [], faces),
        ],
    )


def volumes():
    rng = np.random.default_rng(7)
    grey = 0.1 + 0.8 * rng.random((3, 4, 5, 1), np.float32)
    colour = 0.1 + 0.8 * rng.random((2, 3, 4, 3), np.float32)
    for name, data, box in (("grey", grey, (0, 0, 0, 1, 1, 1)), ("colour", colour, (-1, -0.5, 0, 1, 1, 1.5))):
        grids.write(VOLUMES / f"{name}.vol", data, box)
    # Flakes of SGGX, the same everywhere.
    for name, matrix in (("flakes_flat", (0.05, 0.1, 1, 0, 0, 0)), ("flakes_skewed", (1, 0.35, 0.32, 0.52, 0.44, 0.2))):
        grids.write(VOLUMES / f"{name}.vol", np.reshape(matrix, (1, 1, 1, 6)))
    # Two balls that run into one another, on few points: cells are as large as what they show. As many points along z as along x, for
    # Mitsuba takes either for the other (FACTS.md, 89).
    z, y, x = np.meshgrid(*(np.linspace(0, 1, points) for points in (11, 9, 11)), indexing="ij")
    balls = [np.sqrt((x - cx) ** 2 + (y - 0.5) ** 2 + (z - cz) ** 2) - r for cx, cz, r in ((0.36, 0.42, 0.24), (0.66, 0.6, 0.2))]
    distances = -0.05 * np.log(sum(np.exp(-ball / 0.05) for ball in balls))
    grids.write(VOLUMES / "distances.vol", distances)


if __name__ == "__main__":
    for folder in (MESHES, TEXTURES, VOLUMES):
        folder.mkdir(exist_ok=True)
    images()
    meshes()
    volumes()
