"""ΔE2000: Sharma's test pairs and random pairs

abbe's CIEDE2000 is that of ISO/CIE 11664-6:2014 as Sharma, Wu and Dalal (2005) wrote it out, also where the mean of two hues or their difference goes around 0°.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt
from make_reference import SHARMA

from colour_common import ask

METHOD = """The 34 pairs of Sharma's table 1 against its four decimals; then random pairs in three kinds against colour-science: anywhere in CIELAB, close to one another (what renderers
compare), and with hues on both sides of 0° and nearly opposite, where the branches of the formula lie. Exactly opposite hues are left out: there the formula jumps,
and which side a program takes is a matter of its last bit."""
DATA = """G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula: Implementation Notes, Supplementary Test Data, and Mathematical Observations", Color Research and Application 30
(2005), table 1. colour-science 0.4.7, `delta_E(method="CIE 2000")`."""

PLANTED = [
    Planted("mean of two hues across 0° taken the long way", caught_by=("Sharma", "random pairs anywhere", "random pairs across 0°"), mutant="colour_hue_mean"),
    Planted("weight of hue with 0.171 for 0.17", caught_by=("Sharma", "random pairs anywhere", "random close pairs"), mutant="colour_hue_weight"),
    Planted("b* of one of each pair off by 10⁻⁴", caught_by=("random pairs anywhere", "random close pairs")),
]


def polar(lightness, chroma, hue):
    return np.stack([lightness, chroma * np.cos(hue), chroma * np.sin(hue)], -1)


def run(claim):
    rows = np.array([[float(number) for number in line.split()] for line in SHARMA.strip().splitlines()])
    random = np.random.default_rng(1)
    count = 10_000 if claim.quick else 100_000
    anywhere = [np.stack([random.uniform(0, 100, count), *random.uniform(-128, 128, (2, count))], -1) for _ in range(2)]
    near = anywhere[0] + random.normal(size=(count, 3)) * np.geomspace(1e-4, 3, count)[:, None]
    lightness, chroma, hue = random.uniform(0, 100, (2, count)), random.uniform(0, 130, (2, count)), random.normal(size=(2, count)) * 0.3
    # The second of each is nearly opposite in one half, by 10⁻⁶ to 1 rad to either side.
    hue[1, ::2] = hue[0, ::2] + np.pi + random.choice([-1, 1], count // 2) * np.geomspace(1e-6, 1, count // 2)
    across = [polar(lightness[k], chroma[k], hue[k]) for k in range(2)]

    def ours(first, second):
        shift = [0, 0, 1e-4] if claim.planted == PLANTED[-1].what else 0
        return np.array(ask(claim.abbe, "delta_e2000", first=first, second=second + shift))

    claim.bounded("Sharma's 34 pairs, four decimals", ours(rows[:, :3], rows[:, 3:6]) - rows[:, 6], 5e-5)
    figure, axes = plt.subplots(figsize=(7.2, 3.2))
    for name, first, second in (("Sharma's 34 pairs, colour-science", rows[:, :3], rows[:, 3:6]), ("random pairs anywhere", *anywhere), ("random close pairs", anywhere[0], near), ("random pairs across 0° and nearly opposite", *across)):
        expected = colour.delta_E(first, second, method="CIE 2000")
        found = ours(first, second)
        claim.bounded(name, found - expected, 1e-9)
        claim.bounded(f"{name}, swapped", ours(second, first) - found, 1e-9)
        pick = slice(None, None, max(1, len(found) // 2000))
        axes.loglog(expected[pick], np.abs(found - expected)[pick] + 1e-17, ".", ms=2.5, alpha=0.5, label=name)
    axes.set(xlabel="ΔE2000 by colour-science", ylabel="difference of abbe's")
    axes.legend(fontsize=7.5, markerscale=3)
    claim.figure("pairs", figure, "Difference of the two programs against what they tell, some 2000 pairs of each kind (10⁻¹⁷ stands for equal bits): rounding in double precision.")
