"""Write measured BSDFs and Mitsuba 3's values of them, the witnesses of tests/statistical/bsdf/measured.rs.

`gold.bsdf` is what a gonioreflectometer would measure of rough gold (GGX, α = 0.35, n and k of Johnson and
Christy), isotropic. `half.bsdf` and `quarter.bsdf` hold random numbers for azimuths of the eye over a half
and a quarter of the circle; the spectra of the first are not relative to the density of normals. The tables
are those of Dupuy and Jakob, "An Adaptive Parameterization for Efficient Material Acquisition and Rendering"
(SIGGRAPH Asia 2018).

Needs mitsuba (written with 3.9.1, variant scalar_spectral, single precision) and numpy.

    python validation/optics/make_measured_reference.py tests/data/measured
"""

import random
import struct
import sys
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_spectral")
from mitsuba import BSDFContext, SurfaceInteraction3f  # noqa: E402

ALPHA = 0.35
GOLD = Path(__file__).parents[2] / "data/metals/gold_Au_johnson_christy.csv"
# A wavelength below the tables, two within, one above.
WAVELENGTHS = [380.0, 456.5, 611.25, 760.0]


def write(path, fields):
    """A tensor file, version 1.0: names, shapes and places of the fields, then their values."""
    types = {np.dtype("uint8"): 1, np.dtype("float32"): 10}
    at = 18 + sum(2 + len(name) + 11 + 8 * values.ndim for name, values in fields.items())
    header = b"tensor_file\0" + bytes([1, 0]) + struct.pack("<I", len(fields))
    for name, values in fields.items():
        header += struct.pack("<H", len(name)) + name.encode()
        header += struct.pack(f"<HBQ{values.ndim}Q", values.ndim, types[values.dtype], at, *values.shape)
        at += values.nbytes
    path.write_bytes(header + b"".join(values.tobytes() for values in fields.values()))


def bilinear(grid, x, y):
    """A grid over the unit square, between its points; x along the last axis."""
    rows, columns = grid.shape
    x, y = x * (columns - 1), y * (rows - 1)
    i, k = np.minimum(x.astype(int), columns - 2), np.minimum(y.astype(int), rows - 2)
    x, y = x - i, y - k
    top = grid[k, i] * (1 - x) + grid[k, i + 1] * x
    return top * (1 - y) + (grid[k + 1, i] * (1 - x) + grid[k + 1, i + 1] * x) * y


def inverse(density, u):
    """Where a density that is linear between points at equal steps in [0, 1] has the fraction u before it."""
    fine = np.linspace(0, 1, 20001)
    values = np.interp(fine, np.linspace(0, 1, len(density)), density)
    sums = np.concatenate([[0], np.cumsum(values[1:] + values[:-1])])
    return np.interp(u, sums / sums[-1], fine)


def warped(density, x, y):
    """The place whose marginal along y and conditional along x have the fractions y and x."""
    y = inverse((density[:, 1:] + density[:, :-1]).sum(axis=1), y)
    columns = np.linspace(0, 1, density.shape[1])
    row = [bilinear(density, columns, np.full(len(columns), at)) for at in y]
    return np.array([float(inverse(values, at)) for values, at in zip(row, x)]), y


def facet(x, y):
    """The normal at a place of the unit square: its angle is π/2 x², its azimuth π (2 y − 1)."""
    theta, phi = np.pi / 2 * x**2, np.pi * (2 * y - 1)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)


def distribution(m):
    return ALPHA**2 / (np.pi * (m[..., 2] ** 2 * (ALPHA**2 - 1) + 1) ** 2)


def masked(v):
    """Smith's G1."""
    cos = np.maximum(v[..., 2], 1e-4)
    return 2 / (1 + np.sqrt(1 + ALPHA**2 * (1 - cos**2) / cos**2))


def fresnel(cos, n, k):
    """Reflectance of a metal, averaged over both polarisations."""
    eta, cos = (n + 1j * k), np.clip(cos, 0, 1)
    inner = np.sqrt(eta**2 - (1 - cos**2))
    s, p = (cos - inner) / (cos + inner), (eta**2 * cos - inner) / (eta**2 * cos + inner)
    return (np.abs(s) ** 2 + np.abs(p) ** 2) / 2


def gold(angles=8, points=16, colours=6):
    line = np.linspace(0, 1, points)
    x, y = np.meshgrid(line, line)
    m = facet(x, y)
    theta = np.linspace(0, 1, angles) ** 2 * np.radians(85)
    wavelengths = np.linspace(400, 700, colours)
    rows = [line.split(",") for line in GOLD.read_text().splitlines() if line[0].isdigit()]
    nm, n, k = np.array(rows, dtype=float).T
    n, k = np.interp(wavelengths, nm, n), np.interp(wavelengths, nm, k)
    sigma_of = lambda v: np.maximum(v[..., 2], 1e-4) / masked(v)  # noqa: E731
    vndf, luminance, spectra = [], [], []
    for angle in theta:
        eye = np.array([np.sin(angle), 0, np.cos(angle)])
        seen = np.maximum(m @ eye, 0) * distribution(m) * x * np.sin(np.pi / 2 * x**2)
        # Points of a grid do not reach the density's zeros between them.
        seen = np.maximum(seen, 1e-3 * seen.max())
        px, py = warped(seen, x.ravel(), y.ravel())
        normal = facet(px, py)
        cos = normal @ eye
        light = 2 * cos[:, None] * normal - eye
        facing = (light[:, 2] > 0) & (cos > 0)
        shadowed = np.where(facing, masked(eye) * masked(light) * sigma_of(eye) / eye[2], 0)
        values = np.array([fresnel(cos, a, b) * shadowed for a, b in zip(n, k)])
        values = values.reshape(colours, points, points)
        vndf.append(seen)
        spectra.append(values)
        luminance.append(np.maximum(values.mean(axis=0), 1e-2))
    # Values beside the density of visible normals are f cos over D / (4 σ).
    u = facet(line[None, :].repeat(points, 0), y)
    return {
        "theta_i": theta,
        "phi_i": np.zeros(1),
        "ndf": distribution(m),
        "sigma": sigma_of(u),
        "vndf": np.array(vndf)[None],
        "luminance": np.array(luminance)[None],
        "wavelengths": wavelengths,
        "spectra": np.array(spectra)[None],
    }


def noise(azimuths, angles=4, points=5, colours=3):
    uniform = np.random.default_rng(len(azimuths)).uniform
    slices = (len(azimuths), angles)
    return {
        "theta_i": np.linspace(0, np.pi / 2, angles),
        "phi_i": np.array(azimuths),
        "ndf": uniform(0.5, 2, (points, points)),
        "sigma": uniform(0.3, 1, (points + 1, points)),
        # Most normals are near that of the surface, so that most samples count.
        "vndf": uniform(0.2, 2, (*slices, points, points)) * np.linspace(1, 0.2, points),
        "luminance": uniform(0.3, 2, (*slices, points, points)),
        "wavelengths": np.linspace(420, 680, colours),
        "spectra": uniform(0, 0.2, (*slices, colours, points, points)),
    }


def direction():
    z, phi = random.uniform(0.05, 1), random.uniform(0, 2 * np.pi)
    v = np.array([np.sqrt(1 - z * z) * np.cos(phi), np.sqrt(1 - z * z) * np.sin(phi), z])
    return [float(np.float32(c)) for c in v]


def main():
    folder = Path(sys.argv[1])
    random.seed(2018)
    materials = {
        "gold": (gold(), 1),
        "half": (noise([-np.pi, -2.0, -0.7, 0]), 0),
        "quarter": (noise([-np.pi, -2.5, -np.pi / 2]), 1),
    }
    print(f"# Mitsuba {mi.__version__} scalar_spectral, by validation/optics/make_measured_reference.py")
    print("# wavelengths " + " ".join(map(str, WAVELENGTHS)))
    print("file,eye_x,eye_y,eye_z,light_x,light_y,light_z,f_cos_0,f_cos_1,f_cos_2,f_cos_3,density")
    for name, (fields, jacobian) in materials.items():
        fields = {field: values.astype(np.float32) for field, values in fields.items()}
        fields["jacobian"] = np.array([jacobian], dtype=np.uint8)
        fields["description"] = np.frombuffer(name.encode(), dtype=np.uint8)
        path = folder / f"{name}.bsdf"
        write(path, fields)
        bsdf = mi.load_dict({"type": "measured", "filename": str(path)})
        si = SurfaceInteraction3f()
        si.wavelengths = WAVELENGTHS
        for row in range(40):
            eye = direction()
            si.wi = mi.Vector3f(eye)
            light = direction()
            while row % 2:
                u = mi.Point2f(random.random(), random.random())
                sample, _ = bsdf.sample(BSDFContext(), si, random.random(), u, True)
                light = [float(c) for c in sample.wo]
                if light[2] > 0.02:
                    break
            value = bsdf.eval(BSDFContext(), si, mi.Vector3f(light), True)
            density = bsdf.pdf(BSDFContext(), si, mi.Vector3f(light), True)
            print(",".join([name, *(f"{c:.9g}" for c in [*eye, *light, *value, density])]))


main()
