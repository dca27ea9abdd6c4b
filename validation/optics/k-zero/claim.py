"""How wrong it is to take a metal's reflectance for that of a dielectric

From a metal's reflectance at normal incidence alone, n and k cannot both be told. The assumption k = 0 (Glassner 1989, ch. 4) is exact at 0° and, where k
exceeds n by far (noble metals, aluminium, most others), much too dark towards grazing: n = 1, and Schlick's F = R + (1 − R)(1 − cos θ)⁵, from the same reflectance, err
less. Where n exceeds k (semiconductors, but tungsten, vanadium and zinc too) it is the other way round, and k = 0 is the best of the three. abbe does what each closed
form says, and full n and k when they are known."""

import colour
import numpy as np

from harness.claim import Planted
from harness.plots import plt
from optics_common import FLOOR, floor_picture, metal, moderated, repeat, write

METHOD = """All 26 metals and semiconductors of the catalogue, 380 to 780 nm in 5 nm, 0 to 89°: the truth is F(n, k); the alternatives start from F
at 0°. An assumption is judged by its largest error of F; k/n is the median over the wavelengths. Colours are those of the reflected light of D65 (CIE 1931, Lab against D65), ΔE2000 by colour-science; hemispherical means 2∫F cos θ dcos θ.
abbe is judged three times: its n and k from `normal_reflectance` (probe), its F (probe), and pictures of a gold floor under a white sky, whose rows
are angles from 0 to 90°, in bands of 2 nm, each rendered several times."""
DATA = "n and k: data/metals (Johnson and Christy 1972, Rakić 1995, McPeak 2015 and others, by refractiveindex.info, CC0), as abbe interpolates them."

K_OFF, SCHLICK = "k off by 0.01", "Schlick's approximation in place of Fresnel's equations"
PLANTED = [
    Planted(K_OFF, ("picture: n and k", "F of n and k")),
    Planted(SCHLICK, ("picture: n and k", "picture: k = 0", "picture: n = 1"), "optics_schlick"),
]

NM = np.arange(380.0, 781.0, 5.0)
ANGLES = np.arange(0.0, 89.5, 1.0)
COSINES = np.cos(np.radians(ANGLES))
NAMES = ("k = 0", "n = 1", "Schlick")


def alternatives(r, cosine):
    """F by each assumption, from the reflectance r at normal incidence."""
    return (
        metal(cosine, (1 + np.sqrt(r)) / (1 - np.sqrt(r)), 0 * r),
        metal(cosine, 1 + 0 * r, np.sqrt(4 * r / (1 - r))),
        r + (1 - r) * (1 - cosine) ** 5,
    )


def lab(reflectances):
    """CIELAB under D65 of spectra (… × wavelengths)."""
    shape = colour.SpectralShape(380, 780, 5)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
    light = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    weights = cmfs * light[:, None] / (cmfs[:, 1] @ light)
    white = weights.sum(0)
    return colour.XYZ_to_Lab(reflectances @ weights, colour.XYZ_to_xy(white))


def run(claim):
    [entries] = claim.abbe.probe([{"optics": {"names": {"conductors": True}}}])
    metals = [entry["name"] for entry in entries]
    if claim.quick:
        metals = [name for name in metals if name.startswith(("Au/", "Ag/", "Cu/", "Si/", "W/"))]
    indices = claim.abbe.probe([{"optics": {"complex_index": {"name": name, "nm": NM.tolist()}}} for name in metals])
    rows, kept = [], {}
    node, weight = np.polynomial.legendre.leggauss(48)
    node, weight = (node + 1) / 2, weight / 2
    for name, index in zip(metals, indices):
        n, k = np.array(index).T
        r = metal(1.0, n, k)
        truth = metal(COSINES[:, None], n, k)
        guesses = alternatives(r, COSINES[:, None])
        kept[name] = (n, k, truth, guesses)
        seen = lab(truth)
        delta = [colour.delta_E(lab(guess), seen, method="CIE 2000") for guess in guesses]
        whole = lambda f: 2 * np.einsum("a,aw->w", weight * node, f)
        over = lab(whole(metal(node[:, None], n, k)))
        hemispherical = [float(colour.delta_E(lab(whole(guess)), over, method="CIE 2000")) for guess in alternatives(r, node[:, None])]
        cells = (
            [f"{np.abs(g - truth).max():.3f}" for g in guesses]
            + [f"{d.mean():.1f} / {d.max():.1f}" for d in delta]
            + [f"{h:.2f}" for h in hemispherical]
        )
        rows.append((name, f"{np.interp(550, NM, r):.3f}", f"{np.median(k / n):.2f}", *cells))
        kept[name] += (delta,)
    closed_forms(claim, kept)
    pictures(claim)
    if claim.planted:
        return
    worst = {name: [np.abs(g - v[2]).max() for g in v[3]] for name, v in kept.items()}
    ratio = {name: np.median(v[1] / v[0]) for name, v in kept.items()}
    for what, chosen, right in (
        ("k = 0 is the worst of the three where k is more than 1.5 n", [w for name, w in worst.items() if ratio[name] > 1.5], lambda w: w[0] > max(w[1:])),
        ("k = 0 is the best of the three where k is less than n", [w for name, w in worst.items() if ratio[name] < 1], lambda w: w[0] < min(w[1:])),
    ):
        claim.holds(what, len(chosen) > 0 and all(map(right, chosen)), f"{sum(map(right, chosen))} of {len(chosen)}", "all", "one metal")
    claim.table(
        ("metal", "R(550)", "k/n", *(f"max |ΔF|, {n}" for n in NAMES), *(f"ΔE mean / max, {n}" for n in NAMES), *(f"ΔE hemisph., {n}" for n in NAMES)),
        rows,
        "Errors of the three assumptions against n and k: of F over all angles (0–89°) and wavelengths, ΔE2000 of the light reflected at one angle"
        " (mean and worst over 0–89°), and of all that a diffuse sky sends up.",
    )
    show(claim, kept)


def closed_forms(claim, kept):
    """abbe's F and its n and k from a reflectance, against the closed forms."""
    wrong = 0.01 if claim.planted == K_OFF else 0.0
    c = np.repeat(COSINES, len(NM))
    questions, truths = [], []
    for n, k, truth, guesses, _ in kept.values():
        questions.append(
            {"optics": {"conductor": {"cosine": c.tolist(), "n": np.tile(n, len(ANGLES)).tolist(), "k": np.tile(k + wrong, len(ANGLES)).tolist()}}}
        )
        truths.append(truth.ravel())
    claim.bounded("F of n and k, all metals, relative", np.array(claim.abbe.probe(questions)) / np.array(truths) - 1, 1e-12)
    for which, index in ((0, None), (1, 1.0)):
        found = []
        for n, k, *_ in kept.values():
            table = metal(1.0, n, k)
            found.append(
                {"optics": {"normal_reflectance": {"table_nm": NM.tolist(), "table": table.tolist(), "n": index, "slab": False, "nm": NM.tolist()}}}
            )
        answers = [np.array(a).T for a in claim.abbe.probe(found)]
        again = [
            {"optics": {"conductor": {"cosine": c.tolist(), "n": np.tile(n, len(ANGLES)).tolist(), "k": np.tile(k, len(ANGLES)).tolist()}}}
            for n, k in answers
        ]
        # Towards R = 1 the closed form subtracts R from 1.
        claim.bounded(f"F under {NAMES[which]}, all metals", np.array(claim.abbe.probe(again)) - [v[3][which].ravel() for v in kept.values()], 1e-12)
    # What is known of gold (Johnson and Christy) at 550 nm, to four places: true F and that of k = 0 at 60° and 80°.
    at = int(np.flatnonzero(NM == 550)[0])
    _, _, truth, guesses, _ = kept["Au/johnson-christy"]
    claim.bounded(
        "gold at 550 nm: 0.7923 and 0.7578 at 60°, 0.8637 and 0.6038 at 80°",
        [f[a, at] - known for f, a, known in ((truth, 60, 0.7923), (guesses[0], 60, 0.7578), (truth, 80, 0.8637), (guesses[0], 80, 0.6038))],
        1e-3,
    )


def pictures(claim):
    """A gold floor rendered with n and k, and with each assumption from its reflectance."""
    table = np.arange(380.0, 781.0, 1.0)
    [index] = claim.abbe.probe([{"optics": {"complex_index": {"name": "Au/johnson-christy", "nm": table.tolist()}}}])
    n, k = np.array(index).T
    r = metal(1.0, n, k)
    words = lambda values: ", ".join(f"{a:g}:{v:.15g}" for a, v in zip(table, values))
    reflectance = f'<spectrum name="normal_reflectance" value="{words(r)}"/>'
    kinds = {
        "n and k": f'<spectrum name="eta" value="{words(n)}"/><spectrum name="k" value="{words(k + (0.01 if claim.planted == K_OFF else 0))}"/>',
        "k = 0": reflectance + '<string name="assume" value="k=0"/>',
        "n = 1": reflectance + '<string name="assume" value="n=1"/>',
    }
    at = lambda values, nm: np.interp(nm, table, values)
    forms = {
        "n and k": lambda c, nm: metal(c, at(n, nm), at(k, nm)),
        "k = 0": lambda c, nm: alternatives(at(r, nm), c)[0],
        "n = 1": lambda c, nm: alternatives(at(r, nm), c)[1],
    }
    seeds, spp, count = (6, 64, 60) if claim.quick else (12, 256, 90)
    for name, inside in kinds.items():
        scene = write(claim, name.replace(" ", ""), FLOOR.replace("BSDF", f'<bsdf type="conductor">{inside}</bsdf>'))
        band = lambda nm: repeat(
            claim, scene, spp, seeds, lambda p: p.spectrum()[1][:, 0, 0], ("--range", f"{nm - 1}:{nm + 1}", "--spectral", "1"), {"rows": count}
        )
        mean, error = np.moveaxis([band(nm) for nm in (450, 520, 550, 650)], 1, 0)
        expected = np.array([floor_picture(forms[name], np.array([nm, nm + 2.0]), count)[:, 0] for nm in (450.0, 520.0, 550.0, 650.0)])
        claim.agrees(f"picture: {name}, every row at 450, 520, 550 and 650 nm", mean, expected, *moderated(error, seeds))
        spread = np.sqrt(np.sum((error / expected) ** 2)) / expected.size
        claim.agrees(
            f"picture: {name}, all rows together, over the closed form", (mean / expected).mean(), 1.0, spread, (seeds - 1) * expected.size / 4
        )


def show(claim, kept):
    figure, axes = plt.subplots(3, 3, figsize=(7.2, 6.2), sharex=True, sharey=True)
    for row, name in zip(axes, ("Au/johnson-christy", "Cu/johnson-christy", "Ag/johnson-christy")):
        _, _, truth, guesses, _ = kept[name]
        for at, guess, what in zip(row, guesses, NAMES):
            drawn = at.pcolormesh(NM, ANGLES, guess - truth, cmap="RdBu_r", vmin=-0.5, vmax=0.5, rasterized=True)
            at.contour(NM, ANGLES, guess - truth, levels=[-0.4, -0.2, -0.05, -0.01, 0.01, 0.05], colors="black", linewidths=0.5)
            at.set_title(f"{name.split('/')[0]}, {what}", fontsize=8)
            at.grid(False)
        row[0].set_ylabel("angle, °")
    for at in axes[-1]:
        at.set_xlabel("wavelength, nm")
    figure.colorbar(drawn, ax=axes, label="F assumed − F true", shrink=0.7)
    claim.figure(
        "maps", figure, "Error of the reflectance of gold, copper and silver by each assumption; contours at −0.4, −0.2, −0.05, ±0.01, 0.05."
    )
    figure, axes = plt.subplots(1, 3, figsize=(7.2, 2.7), sharey=True)
    for at, which in zip(axes, range(3)):
        for name, (*_, delta) in kept.items():
            bold = name.split("/")[0] in ("Au", "Ag", "Cu", "Al") and not name.endswith("mcpeak")
            at.plot(
                ANGLES,
                delta[which],
                color=None if bold else "#cccccc",
                lw=1.4 if bold else 0.6,
                zorder=3 if bold else 1,
                label=name.split("/")[0] if bold else None,
            )
        at.axhline(1, color="black", lw=0.6, ls=":")
        at.set(title=NAMES[which], xlabel="angle, °", yscale="log", ylim=(0.01, 60))
    axes[0].set_ylabel("ΔE2000 under D65")
    axes[0].legend(fontsize=7)
    claim.figure(
        "delta-e",
        figure,
        "Colour difference of what a metal reflects at one angle from what it should; grey: the other metals of the catalogue; dotted: ΔE = 1.",
    )
