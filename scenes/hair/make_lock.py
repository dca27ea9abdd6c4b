"""Write lock.txt, a lock of wavy hair that hangs from the origin down to z = -2: control points "x y z radius".

    python scenes/hair/make_lock.py
"""

import math
import random
from pathlib import Path

STRANDS = 700
POINTS = 12
LENGTH = 2.0
THICKNESS = 0.004
HERE = Path(__file__).resolve().parent


def strand(rng):
    """Points of a strand: it spreads from its root, and waves with its neighbours and a little by itself."""
    around, out = rng.uniform(0, 2 * math.pi), math.sqrt(rng.random())
    length = LENGTH * rng.uniform(0.85, 1.0)
    phase, stray = 1.2 * out * math.cos(around), rng.gauss(0, 0.3)
    for i in range(POINTS):
        down = i / (POINTS - 1)
        spread = 0.10 + 0.22 * math.sin(2.4 * down) + 0.04 * stray * down
        wave = 0.06 * down * math.sin(9.0 * down + phase + stray)
        curl = 0.05 * down * math.cos(9.0 * down + phase + stray)
        x = spread * out * math.cos(around) + wave
        y = 0.7 * spread * out * math.sin(around) + curl
        yield x, y, -length * down, THICKNESS * (1.0 - 0.6 * down * down)


def main():
    rng = random.Random(11)
    lines = []
    for _ in range(STRANDS):
        lines += [" ".join(f"{number:.4f}" for number in point) for point in strand(rng)] + [""]
    (HERE / "lock.txt").write_text("\n".join(lines))


main()
