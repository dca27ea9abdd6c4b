"""A slab of glass transmits 2n/(n² + 1), and with absorption what Beer, Lambert and Fresnel say together

T = (1 − F)² a / (1 − F² a²), a = exp(−σ d / cos θ_t): all orders of reflection between the two faces, wavelength by wavelength, for clear and
absorbing glass of several thicknesses, and at oblique incidence. A lamp embedded in glass loses n² of its radiance: (1 − F)/n²."""

import math

import mpmath
import numpy as np
import tmm

from harness.claim import Planted
from harness.plots import plt
from harness.quadrature import over_bins
from optics_common import fresnel, glass, measured, repeat, write

METHOD = """A camera of 0.002° looks through one or several cubes, flat and wide, at a wall of radiance 1; a constant index and a σ that rises
over the spectrum, or N-SF11. Each setting is rendered several times; the standard error comes from their spread. **What abbe does not claim**: it
follows no polarisation, so at oblique incidence F is the mean of s and p at every face anew. The true transmittance is ½(T_s + T_p), which
differs once light meets more than one face; the table and the figure say by how much. At normal incidence both are the same. The closed form
itself is checked with 50 digits and against tmm's incoherent transfer matrices, for each polarisation."""
DATA = """N-SF11: SCHOTT's Sellmeier coefficients. T = 0.4720571952 for n = 1.5 and a = 0.512, and 12/13 for a clear slab of 1.5, computed
before and apart from this code."""

THICKER, INDEX, LOST = "absorption off by 1 %", "index off by 0.001", "radiance not divided by n² (1.5² = 2.25)"
PLANTED = [
    Planted(THICKER, ("absorbing slabs",)),
    Planted(INDEX, ("a lamp in glass",)),
    Planted(LOST, ("a lamp in glass",), "optics_lost_eta_squared"),
    Planted("s-polarised light only", ("oblique slabs", "plates at Brewster's angle"), "optics_s_only"),
]
N, WALL = 1.5, 1000
SIGMA = (0.2, 1.2)  # per unit of length at 400 and 700 nm, linear between

SCENE = """<scene version="3.0.0">
    <default name="eye" value="0, 0, 50"/><default name="thickness" value="1"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <float name="fov" value="0.002"/><transform name="to_world"><lookat origin="$eye" target="0, 0, 0" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="2"/><integer name="height" value="2"/><rfilter type="box"/></film>
    </sensor>
    BODY
</scene>
"""
LAMP = '<emitter type="area"><spectrum name="radiance" value="1"/></emitter>'
BACK = f'<shape type="rectangle"><transform name="to_world"><scale value="{WALL}"/><translate z="-20"/></transform>{LAMP}</shape>'


def cube(index, half, z=0.0, medium=""):
    return (
        f'<shape type="cube"><transform name="to_world"><scale x="500" y="500" z="{half}"/><translate z="{z}"/></transform><bsdf'
        f' type="dielectric">{index}</bsdf>{medium}</shape>'
    )


def constant(n):
    return f'<spectrum name="int_ior" value="{n}"/><float name="ext_ior" value="1"/>'


def transmittance(f, a):
    return (1 - f) ** 2 * a / (1 - f**2 * a**2)


def sigma(nm):
    return np.interp(nm, (400, 700), SIGMA)


def model(n, thickness, degrees, nm, polarised=False, absorbing=True):
    """T of abbe's model, or with the two polarisations apart."""
    sine = math.sin(math.radians(degrees)) / n
    a = np.exp(-absorbing * sigma(nm) * thickness / np.sqrt(1 - sine**2))
    s, p = fresnel(math.cos(math.radians(degrees)), n)
    return (transmittance(s, a) + transmittance(p, a)) / 2 if polarised else transmittance((s + p) / 2, a)


def run(claim):
    seeds, spp = (6, 4096) if claim.quick else (12, 32768)
    bins = ("--range", "400:700", "--spectral", "6")
    n = N + 0.001 if claim.planted == INDEX else N
    factor = 1.01 if claim.planted == THICKER else 1.0
    whole = lambda p: p.spectrum()[1].mean((0, 1))
    centres = 400 + 50 * (np.arange(6) + 0.5)
    look = lambda degrees: f"{50 * math.sin(math.radians(degrees)):.12g}, 0, {50 * math.cos(math.radians(degrees)):.12g}"
    exact(claim)

    scene = write(claim, "flint", SCENE.replace("BODY", cube(measured("N-SF11"), 0.5) + BACK))
    mean, error = repeat(claim, scene, spp, seeds, whole, bins)
    flint = lambda nm: 2 * glass("N-SF11", nm) / (glass("N-SF11", nm) ** 2 + 1)
    claim.agrees("clear N-SF11, 2n/(n² + 1) in every bin", mean, over_bins(centres, flint), error, seeds - 1)

    spectrum = ", ".join(f"{nm}:{factor * s}" for nm, s in zip((400, 700), SIGMA))
    fog = f'<medium type="homogeneous" name="interior"><spectrum name="sigma_t" value="{spectrum}"/><float name="albedo" value="0"/></medium>'
    found = []
    for thickness in (0.5, 1.0, 3.0):
        scene = write(claim, "absorbing", SCENE.replace("BODY", cube(constant(n), thickness / 2, medium=fog) + BACK))
        for degrees in (0, 40, 60, 75):
            mean, error = repeat(claim, scene, spp, seeds, whole, bins, {"eye": look(degrees)})
            found.append((thickness, degrees, mean, error, over_bins(centres, lambda nm: model(N, thickness, degrees, nm))))
    straight = [f for f in found if f[1] == 0]
    claim.agrees(
        "absorbing slabs, straight through, in every bin", [f[2] for f in straight], [f[4] for f in straight], [f[3] for f in straight], seeds - 1
    )
    # Bins of one render differ by chance in how many samples they got; their mean weighs less by that, and sees a small error that all share.
    ratio = np.array([(f[2] / f[4]).mean() for f in found])
    spread = np.array([np.sqrt(np.sum((f[3] / f[4]) ** 2)) / len(centres) for f in found])
    weights = 1 / spread**2
    claim.agrees(
        "absorbing slabs, all thicknesses and angles together, over the closed form",
        np.sum(weights * ratio) / weights.sum(),
        1.0,
        1 / math.sqrt(weights.sum()),
        6 * (seeds - 1) * len(found) / 2,
    )
    claim.agrees(
        "oblique slabs, unpolarised at every face",
        [f[2] for f in found if f[1]],
        [f[4] for f in found if f[1]],
        [f[3] for f in found if f[1]],
        seeds - 1,
    )

    one = ("--range", "549:551", "--spectral", "1")
    inside = (
        '<shape type="rectangle"><bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf><transform name="to_world"><scale'
        f' value="400"/></transform>{LAMP}</shape>'
    )
    scene = write(claim, "embedded", SCENE.replace("BODY", cube(constant(n), 0.5) + inside))
    mean, error = repeat(claim, scene, 16 * spp, seeds, whole, one)
    expected = (1 - ((N - 1) / (N + 1)) ** 2) / N**2
    claim.agrees("a lamp in glass: (1 − F)/n²", mean, expected, error, seeds - 1)
    plates(claim, spp, seeds, whole, one, look, constant(n))
    if not claim.planted:
        show(claim, found, centres)


def exact(claim):
    with mpmath.workdps(50):
        f = (mpmath.mpf("0.5") / mpmath.mpf("2.5")) ** 2
        t = [(1 - f) ** 2 * a / (1 - f**2 * a**2) for a in (mpmath.mpf(1), mpmath.mpf("0.512"))]
        claim.bounded("closed form: 12/13 and 0.4720571952", [float(t[0] - mpmath.mpf(12) / 13), float(t[1] - mpmath.mpf("0.4720571952"))], 1e-10)
    differences = []
    for degrees in (0, 40, 75):
        for sine_d in (0.2, 1.0):
            # k so small that it absorbs over d and changes nothing else.
            d, wave = sine_d * 1e7, 500.0
            index = N + 1j * wave / (4 * math.pi * 1e7)
            found = [tmm.inc_tmm(p, [1, index, 1], [np.inf, d, np.inf], ["i", "i", "i"], math.radians(degrees), wave)["T"] for p in "sp"]
            s, p = fresnel(math.cos(math.radians(degrees)), N)
            a = math.exp(-sine_d / math.sqrt(1 - (math.sin(math.radians(degrees)) / N) ** 2))
            differences += [found[0] - transmittance(s, a), found[1] - transmittance(p, a)]
    claim.bounded("closed form against tmm, s and p", differences, 1e-8)


def plates(claim, spp, seeds, whole, options, look, index):
    """A pile of plates at Brewster's angle: where the missing polarisation shows most."""
    brewster = math.atan(N)
    s, p = fresnel(math.cos(brewster), N)
    f = (s + p) / 2
    through = lambda f, count: (1 - f) / (1 + (2 * count - 1) * f)
    rows, measured_all = [], []
    for count in (1, 4, 16):
        body = "".join(cube(index, 0.05, 0.25 * (i - (count - 1) / 2)) for i in range(count))
        mean, error = repeat(
            claim, write(claim, f"pile{count}", SCENE.replace("BODY", body + BACK)), spp, seeds, whole, options, {"eye": look(math.degrees(brewster))}
        )
        truth = (through(s, count) + through(p, count)) / 2
        measured_all.append((mean[0], through(f, count), error[0]))
        rows.append(
            (count, f"{mean[0]:.4f} ± {error[0]:.4f}", f"{through(f, count):.4f}", f"{truth:.4f}", f"{(through(f, count) / truth - 1) * 100:+.1f} %")
        )
    mean, expected, error = np.array(measured_all).T
    claim.agrees("plates at Brewster's angle: 1, 4 and 16, unpolarised at every face", mean, expected, error, seeds - 1)
    if not claim.planted:
        claim.table(
            ("plates of n = 1.5", "T in the picture", "T, unpolarised at every face", "T, s and p apart (true)", "abbe's error"),
            rows,
            "What the missing polarisation costs at Brewster's angle: little for a pane, much for a pile.",
        )


def show(claim, found, centres):
    figure, (left, right) = plt.subplots(1, 2)
    nm, degrees = np.linspace(400, 700, 100), np.linspace(0, 89, 180)
    for thickness, at, mean, error, _ in found:
        if at == 0:
            (drawn,) = left.plot(nm, model(N, thickness, 0, nm), label=f"d = {thickness:g}")
            left.errorbar(centres, mean, 2 * error, fmt="o", color=drawn.get_color(), capsize=2)
    left.set(xlabel="wavelength, nm", ylabel="transmittance, straight through", ylim=(0, 1))
    left.legend()
    for thickness in (0.5, 1.0, 3.0):
        (drawn,) = right.plot(degrees, [model(N, thickness, a, 575.0) for a in degrees], label=f"d = {thickness:g}")
        right.plot(degrees, [model(N, thickness, a, 575.0, True) for a in degrees], ":", color=drawn.get_color())
        points = [(at, mean[3], error[3]) for t, at, mean, error, _ in found if t == thickness]
        a, m, e = np.array(points).T
        right.errorbar(a, m, 2 * e, fmt="o", color=drawn.get_color(), capsize=2)
    right.set(xlabel="angle of incidence, °", ylabel="transmittance, 550–600 nm", ylim=(0, 1))
    claim.figure(
        "slabs",
        figure,
        "Absorbing slabs of n = 1.5 and thickness d: closed form (lines) and pictures (points, ± 2 standard errors). Right, dotted: with s and p"
        " followed apart, as light does and abbe does not.",
    )
