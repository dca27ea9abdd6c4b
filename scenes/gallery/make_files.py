"""Makes the meshes, images and the grid of the gallery. Run it in this folder: python3 make_files.py (needs numpy and Pillow)."""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

sys.path.append(str(Path(__file__).resolve().parent.parent))
import grids


def stella_obj(path):
    """Two tetrahedra through one another."""
    lines = ["# Two tetrahedra through one another"]
    for sign in (1, -1):
        corners = sign * np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]])
        lines += [f"v {x} {y} {z}" for x, y, z in corners]
        for a, b, c in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)):
            p, q, r = corners[[a, b, c]]
            if np.dot(np.cross(q - p, r - p), p + q + r) < 0:
                b, c = c, b
            lines.append("f " + " ".join(str(i - 4) for i in (a, b, c)))
    path_write(path, "\n".join(lines) + "\n")


def path_write(path, text):
    with open(path, "w", encoding="ascii") as file:
        file.write(text)


def knot(around=90, across=14, radius=0.28):
    """A tube along the trefoil knot: points, outward normals, and the share of the way along it."""
    t = np.linspace(0, 2 * np.pi, around, endpoint=False)

    def curve(t):
        return np.stack([np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)], axis=-1)

    middle = curve(t)
    along = curve(t + 1e-4) - curve(t - 1e-4)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, np.array([0.0, 0.0, 1.0]))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    a = np.linspace(0, 2 * np.pi, across, endpoint=False)
    normals = np.cos(a)[None, :, None] * side[:, None] + np.sin(a)[None, :, None] * up[:, None]
    points = middle[:, None] + radius * 2.2 * normals
    return 0.4 * points, normals, t / (2 * np.pi)


def knot_ply(path):
    points, normals, share = knot()
    around, across = points.shape[:2]
    header = ["ply", "format ascii 1.0", f"element vertex {around * across}"]
    header += [f"property float {name}" for name in ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b")]
    header += [f"element face {around * across}", "property list uchar int vertex_indices", "end_header"]
    lines = header
    for i in range(around):
        for j in range(across):
            colour = 0.45 + 0.35 * np.cos(2 * np.pi * (share[i] + np.array([0, 1, 2]) / 3))
            numbers = [*points[i, j], *normals[i, j], *colour]
            lines.append(" ".join(f"{number:.3f}" for number in numbers))
    for i in range(around):
        for j in range(across):
            a, b = i * across + j, i * across + (j + 1) % across
            c, d = (a + across) % (around * across), (b + across) % (around * across)
            lines.append(f"4 {a} {b} {d} {c}")
    path_write(path, "\n".join(lines) + "\n")


def tiles_png(path):
    """A tile: a star of eight points in a square."""
    size = 128
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 2 - 1
    angle, radius = np.arctan2(y, x), np.hypot(x, y)
    star = radius < 0.55 + 0.2 * np.abs(np.abs((angle * 8 / (2 * np.pi)) % 1 * 2 - 1))
    core = radius < 0.3
    rim = np.maximum(abs(x), abs(y)) > 0.93
    image = np.empty((size, size, 3))
    image[:] = (0.86, 0.83, 0.72)
    image[star] = (0.12, 0.3, 0.55)
    image[core] = (0.85, 0.6, 0.15)
    image[rim] = (0.45, 0.16, 0.1)
    Image.fromarray((255 * image).astype(np.uint8)).save(path, optimize=True)


def normals_png(path):
    """Normals of round studs, each component x stored as (x + 1)/2."""
    size = 128
    y, x = (np.mgrid[0:size, 0:size] + 0.5) / size * 2 - 1
    radius = np.hypot(x, y)
    within = radius < 0.8
    slope = np.where(within, 1.2 * radius / 0.8, 0)
    normal = np.stack([slope * x / np.maximum(radius, 1e-9), slope * y / np.maximum(radius, 1e-9), np.ones_like(x)], -1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    Image.fromarray(np.round(255 * (normal + 1) / 2).astype(np.uint8)).save(path, optimize=True)


def leaf_png(path):
    """A leaf: where it is, and where it is not."""
    height, width = 192, 128
    y, x = np.mgrid[0:height, 0:width] + 0.5
    v, u = 1 - y / height, x / width * 2 - 1
    edge = 0.9 * np.sin(np.pi * np.clip(v, 0, 1) ** 0.75) * (0.85 + 0.15 * np.cos(26 * np.pi * v))
    leaf = (np.abs(u) < edge) | ((np.abs(u) < 0.03) & (v < 0.3))
    veins = (np.abs((np.abs(u) * 0.6 + (1 - v) * 1.0) * 7 % 1 - 0.5) < 0.06) & (np.abs(u) > 0.06) & (np.abs(u) < 0.8 * edge)
    Image.fromarray((255 * (leaf & ~veins)).astype(np.uint8)).save(path, optimize=True)


def grid_vol(path):
    """Colours in space: red along x, green along y, blue along z."""
    n = 8
    z, y, x = np.mgrid[0:n, 0:n, 0:n] / (n - 1)
    checker = ((np.indices((n, n, n)) // 2).sum(axis=0) % 2)[..., None]
    values = 0.08 + 0.75 * np.stack([x, y, z], axis=-1) * (0.35 + 0.65 * checker)
    grids.write(path, values)


def cage_vol(path):
    """Distances from a ball in a rounded cube that a greater ball has been cut out of, over the cube of half size 1."""
    n = 32
    z, y, x = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    from_centre = np.sqrt(x * x + y * y + z * z)
    off = np.abs(np.stack([x, y, z])) - 0.58
    cube = np.sqrt((np.maximum(off, 0) ** 2).sum(0)) + np.minimum(off.max(0), 0) - 0.2
    hole = 0.92 - from_centre
    cut = 0.5 * (cube + hole + np.sqrt((cube - hole) ** 2 + 0.12**2))
    values = 0.5 * np.minimum(cut, from_centre - 0.55)
    grids.write(path, values)


def ripples_png(path):
    """Waves around two places."""
    v, u = np.meshgrid(*[np.linspace(-1, 1, 96)] * 2, indexing="ij")

    def ring(x, y):
        r = np.hypot(u - x, v - y)
        return np.cos(16 * r) * np.exp(-1.2 * r)

    heights = ring(-0.35, -0.3) + 0.8 * ring(0.5, 0.4)
    heights = (heights - heights.min()) / np.ptp(heights)
    Image.fromarray(np.round(65535 * heights).astype(np.uint16)).save(path)


def teapot_bpt(path):
    """The teapot of Martin Newell (University of Utah, 1975; F. Crow, "The origins of the teapot", IEEE CG&A 7(1), 1987), with the bottom
    that others gave it: 32 patches. Most of it is turned, by control points of its profile, r z, and not quite round."""
    profiles = [
        [(1.4, 2.4), (1.3375, 2.53125), (1.4375, 2.53125), (1.5, 2.4)],
        [(1.5, 2.4), (1.75, 1.875), (2, 1.35), (2, 0.9)],
        [(2, 0.9), (2, 0.45), (1.5, 0.225), (1.5, 0.15)],
        [(0, 3.15), (0.8, 3.15), (0, 2.85), (0.2, 2.7)],
        [(0.2, 2.7), (0.4, 2.55), (1.3, 2.55), (1.3, 2.4)],
        # The bottom goes around the other way: its normals, too, point out.
        [(0, 0), (1.425, 0), (1.5, 0.075), (1.5, 0.15)],
    ]
    # One half of handle and spout: for each row x and z below and above, and half the width.
    halves = [
        [(-1.6, 2.025, -1.5, 2.25, 0.3), (-2.3, 2.025, -2.5, 2.25, 0.3), (-2.7, 2.025, -3, 2.25, 0.3), (-2.7, 1.8, -3, 1.8, 0.3)],
        [(-2.7, 1.8, -3, 1.8, 0.3), (-2.7, 1.575, -3, 1.35, 0.3), (-2.5, 1.125, -2.65, 0.9375, 0.3), (-2, 0.9, -1.9, 0.6, 0.3)],
        [(1.7, 1.425, 1.7, 0.6, 0.66), (2.6, 1.425, 3.1, 0.825, 0.66), (2.3, 2.1, 2.4, 2.025, 0.25), (2.7, 2.4, 3.3, 2.4, 0.25)],
        [(2.7, 2.4, 3.3, 2.4, 0.25), (2.8, 2.475, 3.525, 2.49375, 0.25), (2.9, 2.475, 3.45, 2.5125, 0.15), (2.8, 2.4, 3.2, 2.4, 0.15)],
    ]
    patches = []
    for index, profile in enumerate(profiles):
        for quarter in range(4):
            rows = []
            for r, z in profile:
                side = 0.45 if (r, z) == (0.8, 3.15) else round(0.56 * r, 6)
                for x, y in [(r, 0), (r, -side), (side, -r), (0, -r)]:
                    for _ in range(quarter):
                        x, y = y, -x
                    rows.append((x, -y if index == 5 else y, z))
            patches.append(rows)
    for half in halves:
        below = [[(x, 0, z), (x, -w, z), (a, -w, b), (a, 0, b)] for x, z, a, b, w in half]
        patches.append([point for row in below for point in row])
        patches.append([(x, -y, z) for row in below for x, y, z in reversed(row)])
    lines = [str(len(patches))]
    for patch in patches:
        lines.append("3 3")
        lines += [" ".join(f"{number + 0:g}" for number in point) for point in patch]
    path_write(path, "\n".join(lines) + "\n")


stella_obj("obj/stella.obj")
knot_ply("parts/knot.ply")
tiles_png("bitmap/tile.png")
normals_png("normalmap/studs.png")
leaf_png("mask/leaf.png")
grid_vol("volume/colours.vol")
cage_vol("sdfgrid/cage.vol")
ripples_png("heightfield/ripples.png")
teapot_bpt("bezierpatch/teapot.bpt")
