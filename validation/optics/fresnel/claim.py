"""Fresnel's equations hold to the last digits, at every angle and index

The unpolarised reflectance of a smooth interface, F = ½(r_s² + r_p²), is right to some 10⁻¹⁵ for dielectrics (relative index 0.05 to 10) and metals
(k up to 10), from normal incidence to 10⁻¹² rad of grazing, and the refracted ray follows Snell's law."""

import math

import mpmath
import numpy as np
import tmm

from harness.claim import Planted
from harness.plots import plt
from exact_fresnel import exact_fresnel

METHOD = """abbe's functions are asked in double precision; the truth is the textbook form (Born and Wolf, Principles of Optics, sections 1.5.2 and
14.2) in mpmath with 50 digits, which takes the same doubles as exact. The bound is 4·10⁻¹⁵ of the value, plus what a rounding of the cosine or of
the index by 2⁻⁵² changes: near the critical angle F has a vertical tangent. A second witness, the transfer matrix package tmm, computes s and p
itself. abbe follows no polarisation: it has F only, and s and p are judged through their mean."""
DATA = "Angles and indices on grids and at random; the seed is fixed. tmm: S. Byrnes, arXiv:1603.02720."

INDEX_OFF, K_OFF, ANGLE_OFF = "index off by 0.001", "k off by 0.01", "angle off by 0.02°"
PLANTED = [
    Planted(INDEX_OFF, ("dielectrics", "tmm: dielectrics")),
    Planted(K_OFF, ("metals", "tmm: metals")),
    Planted(ANGLE_OFF, ("dielectrics", "metals")),
    Planted("r_s in the textbook form, which loses digits near matched indices", ("dielectrics",), "optics_cancelling_form"),
    Planted("s-polarised light only", ("dielectrics", "tmm: dielectrics"), "optics_s_only"),
]


def cosines(count):
    """Over the quarter turn, crowded towards grazing: down to 1e-12 rad."""
    return np.concatenate([np.cos(np.radians(np.linspace(0, 89.5, count))), np.geomspace(5e-3, 1e-12, count // 3)])


def conditioning(cosine, n, k):
    """What a rounding of an argument does to F, relative: 2⁻⁵² (1 + 1/|g|²), |g|² = |m² − sin² θ|, small near the critical angle only."""
    g2 = np.abs((n + 1j * k) ** 2 - 1 + cosine**2)
    return 2.0**-52 * np.minimum(2e9, 4 / np.maximum(np.sqrt(g2), 1e-300))


def run(claim):
    count = 60 if claim.quick else 180
    rng = np.random.default_rng(5)
    indices = np.concatenate([np.geomspace(0.05, 10, count // 3), [1 - 1e-6, 1 - 1e-10, 1 + 2.0**-52, 1 + 1e-10, 1 + 1e-6, 1.000277, 1.5, 1 / 1.5]])
    c, n = (a.ravel() for a in np.meshgrid(cosines(count), indices))
    turn = math.radians(0.02) if claim.planted == ANGLE_OFF else 0.0
    asked = np.cos(np.minimum(np.arccos(c) + turn, np.pi / 2)) if turn else c
    # The planted index is seen at ordinary glass; the others would be changed by more than a small error.
    wrong = 0.001 if claim.planted == INDEX_OFF else 0.0
    [found] = claim.abbe.probe([{"optics": {"dielectric": {"cosine": asked.tolist(), "eta": (n + wrong).tolist()}}}])
    found = np.array(found)
    with mpmath.workdps(50):
        truth = [exact_fresnel(a, b) for a, b in zip(c, n)]
        error = np.array([float(abs(mpmath.mpf(a) / b - 1)) if b else abs(a) for a, b in zip(found[:, 0], truth)])
        bend = np.array([float(mpmath.sqrt(max(0, 1 - (1 - mpmath.mpf(a) ** 2) / mpmath.mpf(b) ** 2))) for a, b in zip(c, n)])
    claim.bounded("dielectrics: relative error over what is allowed", error / (4e-15 + conditioning(c, n, 0)), 1)
    total = np.array([t == 1 for t in truth])
    claim.bounded(
        "Snell: cosine of refraction, relative, where |g| > 10⁻³", (found[:, 1] / np.where(total, 1, bend) - 1)[(bend * n > 1e-3) & ~total], 1e-12
    )
    claim.holds(
        "total reflection is exactly 1, and nothing else is above",
        np.all(found[total, 0] == 1) and found.max() <= 1,
        f"{total.sum()} angles",
        "1",
        "2⁻⁵³",
    )

    n = 0.05 * 200 ** rng.random(count * 60)
    k = np.where(rng.random(len(n)) < 0.5, 10 * rng.random(len(n)), 10 ** rng.uniform(-8, 1, len(n)))
    c = np.where(rng.random(len(n)) < 0.8, np.cos(rng.random(len(n)) * np.pi / 2), 10 ** rng.uniform(-12, -2, len(n)))
    asked = np.cos(np.minimum(np.arccos(c) + turn, np.pi / 2)) if turn else c
    [metals] = claim.abbe.probe(
        [{"optics": {"conductor": {"cosine": asked.tolist(), "n": n.tolist(), "k": (k + (0.01 if claim.planted == K_OFF else 0)).tolist()}}}]
    )
    with mpmath.workdps(50):
        wrong_by = np.array([float(abs(mpmath.mpf(f) / exact_fresnel(*a) - 1)) for f, a in zip(metals, zip(c, n, k))])
    claim.bounded("metals: relative error over what is allowed", wrong_by / (4e-15 + conditioning(c, n, k)), 1)

    witness(claim, rng, wrong)
    if not claim.planted:
        show(claim, error, len(indices), count, indices, cosines(count))


def witness(claim, rng, wrong):
    """tmm, in double precision."""
    angle, n, k = np.arccos(rng.uniform(0.01, 1, 500)), rng.uniform(1.05, 4, 500), rng.uniform(0.1, 8, 500)
    half = lambda n2: np.array([sum(tmm.interface_R(p, 1.0, m, a, tmm.snell(1.0, m, a)) for p in "sp") / 2 for m, a in zip(n2, angle)])
    [glass, metal] = claim.abbe.probe(
        [
            {"optics": {"dielectric": {"cosine": np.cos(angle).tolist(), "eta": (n + wrong).tolist()}}},
            {
                "optics": {
                    "conductor": {"cosine": np.cos(angle).tolist(), "n": n.tolist(), "k": (k + (0.01 if claim.planted == K_OFF else 0)).tolist()}
                }
            },
        ]
    )
    claim.bounded("tmm: dielectrics, relative difference", np.array(glass)[:, 0] / half(n + 0j) - 1, 1e-13)
    claim.bounded("tmm: metals, relative difference", np.array(metal) / half(n + 1j * k) - 1, 1e-13)


def show(claim, error, rows, count, indices, cosine):
    figure, (left, right) = plt.subplots(1, 2, sharey=True, width_ratios=(2, 1))
    order = np.argsort(indices)
    image = np.log10(np.maximum(error.reshape(rows, -1)[order], 2.0**-54))
    for axes, part, x in (
        (left, image[:, :count], np.linspace(0, 89.5, count)),
        (right, image[:, count:], np.log10(cosine[count:])),
    ):
        drawn = axes.pcolormesh(x, np.arange(rows), part, cmap="viridis", vmin=-17, vmax=-12, rasterized=True)
        axes.grid(False)
    ticks = [0, *np.searchsorted(np.sort(indices), [0.1, 0.3, 1, 3]), rows - 1]
    left.set(xlabel="angle of incidence, °", ylabel="relative index", yticks=ticks, yticklabels=["0.05", "0.1", "0.3", "1", "3", "10"])
    right.set(xlabel="near grazing: log₁₀(90° − θ), rad")
    right.invert_xaxis()
    figure.colorbar(drawn, label="log₁₀ |relative error|")
    claim.figure(
        "error",
        figure,
        "Relative error of the reflectance of a dielectric against 50 digits. The bright curve below index 1 is the critical angle, where F changes"
        " infinitely fast with its argument; above it F = 1 exactly.",
    )
