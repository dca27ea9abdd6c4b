"""Writes soot.vol and heat.vol, the fire of scene.xml: how much soot there is, and how hot it is (K). Needs NumPy.

The fire is made up: tongues that sway with height, hottest at their rims, cooling toward their tips.
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from grids import noise, write

X, Y, Z = 28, 28, 44

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
write(HERE / "soot.vol", soot)
write(HERE / "heat.vol", heat)
