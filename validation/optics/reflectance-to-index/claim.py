"""Reflectance at normal incidence gives the index, and the index the reflectance back

n = (1 + √R)/(1 − √R) for k = 0 (Glassner 1989, ch. 4), k = √((R(n+1)² − (n−1)²)/(1 − R)) for a known n, and F = R/(2 − R) for one face of a clear
slab, to the last digits from R = 10⁻¹² to 1 − 10⁻¹², alone and as spectra."""

import mpmath
import numpy as np

from harness.claim import Planted
from harness.plots import plt

METHOD = """Each direction against mpmath with 50 digits on the same doubles, then round trips through abbe alone. A bound is 4·10⁻¹⁵ of the value
where abbe's form is well conditioned; 2⁻⁵² of the argument times the derivative is allowed on top (dn/dR = 1/(√R(1 − √R)²) for n; both terms of the
difference for k²). Spectra: a table of reflectances becomes n and k at wavelengths between its nodes, where R is the linear interpolation, and a
conductor rendered with them must have that R again."""
DATA = "Reflectances on logarithmic grids towards 0 and 1; the spectrum is made of seven random values."

OFF, HALF, CANCEL = (
    "reflectance off by 10⁻⁵",
    "back face taken as half of the slab (0.2 % for glass)",
    "1 − √R subtracted, which loses digits towards R = 1",
)
PLANTED = [
    Planted(OFF, ("index from reflectance", "k from reflectance", "spectrum")),
    Planted(HALF, ("front face", "spectrum: a slab"), "optics_half_of_the_slab"),
    Planted(CANCEL, ("index from reflectance",), "optics_cancelling_index"),
]
U = 2.0**-52


def ask(claim, question, **fields):
    [answer] = claim.abbe.probe([{"optics": {question: {name: np.asarray(value).tolist() for name, value in fields.items()}}}])
    return np.array(answer)


def relative(found, exact):
    return np.array([float(abs(mpmath.mpf(f) / e - 1)) if e else abs(f) for f, e in zip(found, exact)])


def run(claim):
    count = 200 if claim.quick else 2000
    off = 1e-5 if claim.planted == OFF else 0.0
    mpmath.mp.dps = 50
    r = np.concatenate([np.geomspace(1e-12, 0.5, count), 1 - np.geomspace(0.5, 1e-12, count)])
    exact_r = [mpmath.mpf(x) for x in r]
    n = ask(claim, "index_of_reflectance", reflectance=r * (1 - off) + off / 2)
    exact_n = [(1 + mpmath.sqrt(x)) / (1 - mpmath.sqrt(x)) for x in exact_r]
    error_n = relative(n, exact_n)
    claim.bounded("index from reflectance, relative", error_n, 4e-15)
    back = ask(claim, "reflectance_of_index", n=n, k=np.zeros_like(n))
    # R = ((n − 1)/(n + 1))²: a rounding of n moves R by 4 n (n − 1)/(n + 1)³.
    allowed = 4e-15 * r + 4 * U * n * 4 * (n - 1) / (n + 1) ** 3
    claim.bounded("reflectance → index → reflectance, over what is allowed", (back - r) / allowed, 1)

    # Every n with every R that some k can explain.
    known, refl = (a.ravel() for a in np.meshgrid([0.05, 0.2, 0.5, 1.0, 1.5, 3.0], r[:: count // 100]))
    possible = refl > ((known - 1) / (known + 1)) ** 2 * (1 + 1e-9)
    known, refl = known[possible], refl[possible]
    k = ask(claim, "extinction_of_reflectance", reflectance=np.minimum(refl + off * (1 - refl), 1 - 1e-16), n=known)
    exact_k2 = [(mpmath.mpf(a) * (mpmath.mpf(b) + 1) ** 2 - (mpmath.mpf(b) - 1) ** 2) / (1 - mpmath.mpf(a)) for a, b in zip(refl, known)]
    terms = (refl * (known + 1) ** 2 + (known - 1) ** 2) / (1 - refl)
    error_k = np.array([float(abs(mpmath.mpf(f) ** 2 - e)) for f, e in zip(k, exact_k2)]) / (8 * U * terms)
    claim.bounded("k from reflectance: error of k² over 8 roundings of its terms", error_k, 1)
    back = ask(claim, "reflectance_of_index", n=known, k=k)
    claim.bounded("reflectance → k → reflectance, relative", back / refl - 1, 4e-15)
    front = ask(claim, "front_face_of_slab", slab=2 * r / (1 + r))
    claim.bounded("front face of a slab, relative, R below 1 − 10⁻³", (front / r - 1)[r < 0.999], 4e-15)
    grid = np.array([a for a in exact_r])
    claim.bounded("front face of a slab is R/(2 − R), relative", relative(ask(claim, "front_face_of_slab", slab=r), grid / (2 - grid)), 4e-16)

    rng = np.random.default_rng(3)
    nodes, values, nm = np.sort(rng.uniform(370, 820, 7)), rng.uniform(0.3, 0.98, 7), np.linspace(360, 830, 471)
    wanted = np.interp(nm, nodes, values)
    fields = {"table_nm": nodes, "table": values * (1 - off), "nm": nm}
    for what, index, slab in (("k = 0", None, False), ("n = 1", 1.0, False), ("a slab's front face", None, True)):
        n, k = ask(claim, "normal_reflectance", n=index, slab=slab, **fields).T
        expected = wanted / (2 - wanted) if slab else wanted
        claim.bounded(
            f"spectrum: {'a slab' if slab else what} has its reflectance between the nodes too, relative",
            ((n - 1) ** 2 + k**2) / ((n + 1) ** 2 + k**2) / expected - 1,
            4e-15,
        )
    if claim.planted:
        return
    figure, axes = plt.subplots()
    x = np.log10(r / (1 - r))
    axes.plot(x, error_n / U, ".", ms=2, label="abbe: (1 + √R)²/(1 − R)")
    naive = (1 + np.sqrt(r)) / (1 - np.sqrt(r))
    axes.plot(x, np.maximum(relative(naive, exact_n) / U, 1e-2), ".", ms=2, label="in doubles as printed: (1 + √R)/(1 − √R)")
    axes.set(xlabel="log₁₀ R/(1 − R)", ylabel="relative error of n, in units of 2⁻⁵²", yscale="log", ylim=(1e-2, None))
    axes.legend()
    claim.figure("digits", figure, "Error of the index from a reflectance, near 0 (left) and near 1 (right), by abbe and by the formula as printed.")
