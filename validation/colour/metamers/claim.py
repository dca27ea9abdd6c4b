"""Metamers: paints that match in one light and part in another

Pairs of reflectances with one colour under D65 have the colour differences that colour-science finds under every other light, in the library and in a rendered picture.
"""

import colour
import numpy as np
from harness.abbe import ROOT
from harness.claim import Planted
from harness.plots import plt

from colour_common import STEP, Surfaces, adapted, ask, catalogue, chart, delta_e, illuminant, lab, patch_values, reflectance, srgb

METHOD = """After Wyszecki and Cohen: a reflectance is the sum of a part that fixes its colour and a metameric black. With A the weights of X, Y and Z under D65 on the chart's 36 wavelengths (each the exact integral
over a hat function, by colour-science), the black of a curve ρ′ is ρ′ − A (AᵀA)⁻¹ Aᵀ ρ′. Each ColorChecker patch gets the black of a measured spectrum of another kind (minerals, plants,
test colours of CIE 13.3), as much of it as keeps the reflectance within 0.01 and 0.99. The four pairs of `scenes/fluorescent` come with them. abbe's ΔE2000 of each pair is of its own XYZ; it
must be colour-science's within 0.01 under all lights, and no more than 10⁻⁶ under D65. Then the pairs are rendered, and the difference of X, Y and Z within each pair is judged by its standard error."""
DATA = """ColorChecker (BabelColor) and the test colours of CIE 13.3: colour-science 0.4.7. Minerals and plants: USGS Spectral Library 7 (`data/reflectance`). Lights: colour-science."""

NM = np.arange(380.0, 731.0, 10.0)
LIGHTS = ("D65", "A", "FL2", "FL7", "FL11", "LED-B3", "LED-RGB1", "lamp/high-pressure-sodium")
PLANTED = [
    Planted("one paint of each pair brighter by 10⁻⁴", caught_by=("D65: ΔE2000", "all lights: relative error")),
    Planted("colour-matching functions shifted by 0.1 nm", caught_by=("D65: ΔE2000", "all lights: relative error"), mutant="colour_shifted_observer"),
    Planted("rendered light 0.5 % off D65 at its red end", caught_by=("rendered, D65",)),
]


def weights(light):
    """XYZ of each hat function on NM: 36 × 3, Y = 1 for white."""
    hats = [colour.SpectralDistribution(row, NM) for row in np.eye(len(NM))]
    xyz, _ = Surfaces(hats).colours(light)
    return xyz[:-1]


def make_pairs(claim, light):
    """(name, base, partner) on NM."""
    matrix = weights(light)
    fundamental = matrix @ np.linalg.inv(matrix.T @ matrix) @ matrix.T
    others = [entry for entry in catalogue(claim.abbe, "reflectance") if entry[0].startswith(("usgs/", "cie13.3/"))]
    pairs = []
    for place, (name, file, column) in enumerate(entry for entry in catalogue(claim.abbe, "reflectance") if entry[0].startswith("colorchecker/")):
        base = reflectance(file, column)[0].values
        sd = reflectance(*others[place % len(others)][1:])[0]
        black = np.interp(NM, sd.wavelengths, sd.values)
        black = black - fundamental @ black
        room = np.where(black > 0, 0.99 - base, base - 0.01) / np.abs(black)
        pairs.append((name.split("/")[1], base, base + min(1.0, room.min()) * black))
    return pairs


def read_spd(name):
    rows = [line.split() for line in (ROOT / "scenes/fluorescent" / name).read_text().splitlines() if not line.startswith("#")]
    return np.array(rows, dtype=float)[:, 1]


def run(claim):
    lights = {entry[0]: illuminant(*entry[1:])[0] for entry in catalogue(claim.abbe, "illuminant") if entry[0] in LIGHTS}
    pairs = make_pairs(claim, lights["D65"])
    pairs += [(f"fluorescent/{name}", read_spd(f"{name}-a.spd"), read_spd(f"{name}-b.spd")) for name in ("purple", "skin", "grey", "foliage")]
    first, second = (np.array([pair[k] for pair in pairs]) for k in (1, 2))
    claim.holds("the paints are reflectances", bool(min(first.min(), second.min()) >= 0.009 and max(first.max(), second.max()) <= 1), f"{min(first.min(), second.min()):.3f} to {max(first.max(), second.max()):.3f}", "0 to 1")
    paints = np.vstack([first, second])
    witness = Surfaces([colour.SpectralDistribution(values, NM) for values in paints])
    asked = paints.copy()
    if claim.planted == PLANTED[0].what:
        asked[len(pairs) :] *= 1 + 1e-4
    answers = ask(claim.abbe, "colours", observer="cie1931", illuminants=list(LIGHTS), reflectances=[{"nm": NM.tolist(), "values": values.tolist()} for values in asked])
    relative, ours, theirs, exact = [], [], [], {}
    half = len(pairs)
    for name, answer in zip(LIGHTS, answers):
        exact[name], _ = witness.colours(lights[name])
        relative.append(np.array(answer["xyz"]) / exact[name][:-1] - 1)
        told, expected = np.array(answer["lab"]), lab(exact[name][:-1], exact[name][-1])
        ours.append(np.array(ask(claim.abbe, "delta_e2000", first=told[:half], second=told[half:])))
        theirs.append(delta_e(expected[:half], expected[half:]))
    ours, theirs = np.array(ours), np.array(theirs)
    made = slice(0, 24)
    claim.bounded("D65: ΔE2000 of the pairs that were made here", ours[0][made], 1e-6)
    claim.bounded("all lights: abbe's ΔE2000 of each pair less colour-science's", ours - theirs, 0.01)
    claim.bounded("all lights: relative error of XYZ", relative, 1e-5)
    claim.holds("the pairs part: largest ΔE2000 under another light", ours[1:].max() > 5, f"{ours[1:].max():.1f}", "> 5", "a test in which nothing happens")
    rendered(claim, pairs, lights, witness, exact)
    if claim.planted is None:
        draw(claim, pairs, ours, theirs, exact)


def rendered(claim, pairs, lights, witness, exact):
    """Charts of all paints under D65 and FL11: differences within pairs."""
    size, spp, half = 4, 1024 if claim.quick else 4096, len(pairs)
    surfaces = [(NM, values) for k in (1, 2) for values in (pair[k] for pair in pairs)]
    for seed, name in enumerate(("D65", "FL11")):
        scene = chart(claim.work / f"pairs-{name}.xml", surfaces, name, size)
        if claim.planted == PLANTED[2].what:
            sd = lights[name]
            tilted = sd.values * (1 + 0.005 * (sd.wavelengths - 360) / 470) * np.pi
            values = ", ".join(f"{nm:.6g}:{value!r}" for nm, value in zip(sd.wavelengths, tilted.tolist()))
            text = scene.read_text()
            start = text.index('<spectrum name="irradiance"')
            end = text.index("</spectrum>", start) + len("</spectrum>")
            scene.write_text(text[:start] + f'<spectrum name="irradiance" value="{values}"/>' + text[end:])
        found, error, freedom = patch_values(claim.abbe.render(scene, spp, seed=seed).stack("XYZ"), 2 * half, size)
        unit = witness.luminance(lights[name]) / 106.7502594
        expected = unit * exact[name][:-1]
        spread = np.hypot(error[:half], error[half:])
        # The difference of two means has at least as many degrees as one of them.
        claim.agrees(f"rendered, {name}: XYZ of all paints", found, expected, error, freedom)
        claim.agrees(f"rendered, {name}: difference within each pair", found[:half] - found[half:], expected[:half] - expected[half:], spread, freedom)


def draw(claim, pairs, ours, theirs, exact):
    half = len(pairs)
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 3.4))
    order = np.argsort(-theirs[LIGHTS.index("FL11")][:24])[:3]
    nm = NM
    for place, ink in zip(order, ("#0072b2", "#d55e00", "#009e73")):
        name, base, partner = pairs[place]
        axes[0].plot(nm, base, color=ink, label=name)
        axes[0].plot(nm, partner, "--", color=ink)
    axes[0].set(xlabel="wavelength, nm", ylabel="reflectance")
    axes[0].legend(fontsize=7.5)
    for k, light in enumerate(LIGHTS):
        axes[1].plot(theirs[k], ours[k], "o", ms=3, label=light.split("/")[-1])
    top = theirs.max() * 1.05
    axes[1].plot([0, top], [0, top], color="0.6", lw=0.8)
    axes[1].set(xlabel="ΔE2000 of a pair by colour-science", ylabel="by abbe")
    axes[1].legend(fontsize=6.5, ncols=2)
    claim.figure("pairs", figure, "Left: the three pairs that part most under FL11 (solid: the patch as measured; dashed: its metamer under D65). Right: the difference of every pair under every light, on the diagonal.")
    figure, panels = plt.subplots(len(LIGHTS), 1, figsize=(9.5, 4.6), sharex=True)
    for panel, light in zip(panels, LIGHTS):
        xyz, white = exact[light][:-1], exact[light][-1]
        inks = srgb(adapted(xyz, white))
        panel.imshow(np.stack([inks[:half], inks[half:]])[:, :, :], aspect="auto", interpolation="nearest")
        panel.set(yticks=[], xticks=[])
        panel.set_ylabel(light.split("/")[-1].replace("high-pressure-", ""), rotation=0, ha="right", va="center", fontsize=8)
        panel.grid(False)
        for place, difference in enumerate(ours[LIGHTS.index(light)]):
            panel.text(place, 0.5, f"{difference:.0f}" if difference > 0.5 else "", ha="center", va="center", fontsize=6.5, color="k" if inks[place].mean() > 0.45 else "w")
    panels[-1].set_xticks(range(half), [name for name, *_ in pairs], rotation=90, fontsize=6.5)
    claim.figure("swatches", figure, "All pairs, one paint above the other, adapted to daylight; the number is abbe's ΔE2000 where it is over 0.5. Under D65 no seam.")
