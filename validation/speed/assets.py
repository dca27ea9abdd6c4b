"""Writes what the scenes name and what is too large, or too easily made, to be kept: meshes of any number of triangles and spectra from `data/`.
The same call writes the same bytes."""

import csv
from pathlib import Path

import numpy as np

from harness.abbe import ROOT

ASSETS = ROOT / "target/validation/speed/assets"

# A ball whose six faces are grids of n × n squares has 12 n² triangles.
MILLION = 12 * 330**2


def triangles_near(count):
    """The number of triangles nearest to `count` that a ball can have."""
    return 12 * max(round((count / 12) ** 0.5), 1) ** 2


def ball(triangles):
    """The PLY file (binary, little-endian) of a dented ball: a cube's faces as grids, blown up to a sphere and dented by 48 waves.

    The waves are the same whatever the number of triangles, so that all balls are one shape, more or less finely cut."""
    path = ASSETS / f"ball-{triangles}.ply"
    if path.exists():
        return path
    n = round((triangles / 12) ** 0.5)
    assert 12 * n * n == triangles, f"no ball has {triangles} triangles"
    # Equal angles make squares of nearly equal size.
    side = np.tan(np.linspace(-np.pi / 4, np.pi / 4, n + 1))
    u, v = np.meshgrid(side, side, indexing="ij")
    one = np.ones_like(u)
    faces = [(u, v, one), (v, u, -one), (one, u, v), (-one, v, u), (v, one, u), (u, -one, v)]
    directions = np.concatenate([np.stack(face, -1).reshape(-1, 3) for face in faces])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    random = np.random.default_rng(7)
    radius = np.ones(len(directions))
    for wave in range(48):
        frequency = 3 * 1.07**wave
        across = random.normal(size=3)
        across *= frequency / np.linalg.norm(across)
        radius += 0.25 / frequency * np.sin(directions @ across + random.uniform(0, 2 * np.pi))
    points = (directions * radius[:, None]).astype("<f4")
    corner = np.arange(n)[:, None] * (n + 1) + np.arange(n)
    corner = (np.arange(6)[:, None, None] * (n + 1) ** 2 + corner).ravel()
    a, b, c, d = corner, corner + n + 1, corner + n + 2, corner + 1
    indices = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    records = np.empty(triangles, [("count", "u1"), ("corners", "<i4", 3)])
    records["count"], records["corners"] = 3, indices
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
        f"element face {triangles}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    ASSETS.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(".part")
    part.write_bytes(header.encode() + points.tobytes() + records.tobytes())
    part.rename(path)
    return path


def spectrum(name, table, column):
    """A column of a table in `data/` as a file that both programs read: wavelength in nm, value."""
    with (ROOT / "data" / table).open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    ASSETS.mkdir(parents=True, exist_ok=True)
    (ASSETS / f"{name}.spd").write_text("".join(f"{row['wavelength_nm']} {row[column]}\n" for row in rows))


def spectra():
    spectrum("F11", "illuminants/cie_fl1_fl12_5nm.csv", "FL11")
    for metal, table in {"Au": "gold_Au_johnson_christy", "Cu": "copper_Cu_johnson_christy", "Al": "aluminium_Al_rakic1995"}.items():
        spectrum(f"{metal}.eta", f"metals/{table}.csv", "n")
        spectrum(f"{metal}.k", f"metals/{table}.csv", "k")
