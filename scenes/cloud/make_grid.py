"""Writes cloud.vol, the density of scene.xml's cloud over that of its core. Needs NumPy.

Puffs on a flat base, eaten away by noise of several sizes: made up, and not simulated.
"""

import struct
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
X, Y, Z = 60, 44, 32
random = np.random.default_rng(7)


def noise(cells, seed):
    """Smooth noise between -1 and 1, interpolated from random values on a coarse grid."""
    grid = np.random.default_rng(seed).uniform(-1, 1, [c + 2 for c in cells])
    for axis, (c, s) in enumerate(zip(cells, (Z, Y, X))):
        places = np.linspace(0, c, s)
        low = places.astype(int)
        t = places - low
        t = (t * t * (3 - 2 * t)).reshape([-1 if a == axis else 1 for a in range(3)])
        grid = np.take(grid, low, axis) * (1 - t) + np.take(grid, low + 1, axis) * t
    return grid


z, y, x = np.meshgrid(*[(np.arange(n) + 0.5) / n for n in (Z, Y, X)], indexing="ij")
shape = np.full(z.shape, -1.0)
for _ in range(16):
    cx, cy = random.uniform(0.2, 0.8), random.uniform(0.28, 0.72)
    middle = 1 - ((cx - 0.5) / 0.36) ** 2 - ((cy - 0.5) / 0.3) ** 2
    size = 0.09 + 0.1 * max(middle, 0)
    cz = 0.16 + 0.42 * max(middle, 0) * random.uniform(0.4, 1)
    distance = np.sqrt((x - cx) ** 2 + ((y - cy) / 1.2) ** 2 + ((z - cz) / 1.5) ** 2)
    shape = np.maximum(shape, 1 - distance / size)
for octave in range(3):
    shape += 0.45 / 2**octave * noise((5 * 2**octave, 7 * 2**octave, 9 * 2**octave), octave)
density = np.clip(shape / 0.35, 0, 1) * np.clip((z - 0.08) / 0.06, 0, 1)
edge = np.minimum.reduce([x, 1 - x, y, 1 - y, 1 - z])
density *= np.clip(edge / 0.05, 0, 1)
header = b"VOL\x03" + struct.pack("<5i6f", 1, X, Y, Z, 1, 0, 0, 0, 1, 1, 1)
(HERE / "cloud.vol").write_bytes(header + density.astype("<f4").tobytes())
