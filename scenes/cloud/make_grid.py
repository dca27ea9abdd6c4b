"""Writes cloud.vol, the cloud of scene.xml: how much water there is from place to place, from 0 to 1. Needs NumPy.

The cloud is made up: a heap of balls with a flat base, whose outside noise of several octaves eats into.
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.append(str(HERE.parent))
from grids import noise, write

X, Y, Z = 56, 40, 32

z, y, x = np.meshgrid(*[(np.arange(n) + 0.5) / n for n in (Z, Y, X)], indexing="ij")
x, y, z = x * 1.75, y * 1.25, z
# Balls: centre and radius.
HEAP = [(0.5, 0.62, 0.28, 0.3), (0.85, 0.6, 0.42, 0.38), (1.2, 0.66, 0.3, 0.31), (0.72, 0.5, 0.6, 0.24), (1.0, 0.72, 0.55, 0.24), (1.45, 0.6, 0.2, 0.18), (0.28, 0.6, 0.2, 0.17)]
depth = np.max([radius - np.sqrt((x - a) ** 2 + (y - b) ** 2 + (z - c) ** 2) for a, b, c, radius in HEAP], axis=0)
ragged = sum(weight * (1 - 2 * np.abs(noise((Z, Y, X), (4 * k, 5 * k, 7 * k), seed))) for seed, (k, weight) in enumerate([(1, 0.06), (2, 0.035), (4, 0.02)], 5))
# Water grows with height above the base.
water = np.clip((depth + ragged) / 0.06, 0, 1) * np.clip((z - 0.1) / 0.05, 0, 1) * (0.55 + 0.45 * z)
water[[0, -1]] = 0
water[:, [0, -1]] = 0
water[:, :, [0, -1]] = 0
write(HERE / "cloud.vol", water)
