"""Writes soot.vol and heat.vol, the fire of scene.xml: how much soot there is, and how hot it is (K). Needs NumPy.

The fire is made up: tongues that sway with height, hottest at their rims, cooling toward their tips.
"""

import struct
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
X, Y, Z = 28, 28, 44


def noise(shape, cells, seed):
    """Smooth noise between -1 and 1, interpolated from random values on a coarse grid."""
    random = np.random.default_rng(seed)
    coarse = random.uniform(-1, 1, [c + 2 for c in cells])
    axes = [np.linspace(0, c, s) for c, s in zip(cells, shape)]
    grid = coarse
    for axis, places in enumerate(axes):
        low = places.astype(int)
        t = places - low
        t = (t * t * (3 - 2 * t)).reshape([-1 if a == axis else 1 for a in range(3)])
        grid = np.take(grid, low, axis) * (1 - t) + np.take(grid, low + 1, axis) * t
    return grid


z, y, x = np.meshgrid((np.arange(Z) + 0.5) / Z, *([(np.arange(n) + 0.5) / n * 2 - 1 for n in (Y, X)]), indexing="ij")
sway = [0.35 * z * noise((Z, Y, X), (4, 2, 2), seed) for seed in (1, 2)]
x, y = x + sway[0], y + sway[1]
reach = 0.62 * np.sqrt(np.clip(z / 0.12, 0, 1)) * np.clip(1 - z, 0, 1) ** 0.7
ragged = reach * (1 + 0.55 * noise((Z, Y, X), (9, 5, 5), 3))
depth = ragged - np.hypot(x, y)
inside = np.clip(depth / 0.22, 0, 1)
soot = inside * (0.25 + 0.75 * z) * (1 + 0.6 * noise((Z, Y, X), (11, 7, 7), 4)).clip(0.1)
rim = np.exp(-((depth - 0.12) / 0.16) ** 2)
heat = np.where(depth > -0.1, 1350 + 420 * rim + 180 * (1 - z), 900)
for name, values in (("soot", soot), ("heat", heat)):
    header = b"VOL\x03" + struct.pack("<5i6f", 1, X, Y, Z, 1, 0, 0, 0, 1, 1, 1)
    (HERE / f"{name}.vol").write_bytes(header + values.astype("<f4").tobytes())
