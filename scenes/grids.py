"""Values on grids for the scripts of the scenes and of validation/mitsuba: noise, and Mitsuba's file format, version 3. Needs NumPy."""

import struct

import numpy as np


def noise(shape, cells, seed):
    """Smooth noise between -1 and 1, interpolated from random values on a coarse grid."""
    random = np.random.default_rng(seed)
    grid = random.uniform(-1, 1, [c + 2 for c in cells])
    axes = [np.linspace(0, c, s) for c, s in zip(cells, shape)]
    for axis, places in enumerate(axes):
        low = places.astype(int)
        t = places - low
        t = (t * t * (3 - 2 * t)).reshape([-1 if a == axis else 1 for a in range(3)])
        grid = np.take(grid, low, axis) * (1 - t) + np.take(grid, low + 1, axis) * t
    return grid


def write(path, values, box=(0, 0, 0, 1, 1, 1)):
    """Values over a box, given by its two corners, by z, y, x and, where there are several, channel."""
    z, y, x, *channels = values.shape
    header = b"VOL\x03" + struct.pack("<5i6f", 1, x, y, z, *(channels or [1]), *box)
    with open(path, "wb") as file:
        file.write(header + values.astype("<f4").tobytes())
