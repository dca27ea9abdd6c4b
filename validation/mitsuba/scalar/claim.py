"""abbe and Mitsuba's scalar variant render the same pictures

`scalar_spectral`, in which Mitsuba traces one ray at a time by other code than the vectorised variants, gives the pictures of abbe, too.
"""

import tomllib

import compare
from compare import FULL, HERE, QUICK, Pair

METHOD = """As in the claim on pairs, with a handful of scenes that between them have reflection, refraction, many bounces, lamps, a sky, textures and a lens. All have the box filter: the
scalar variants tabulate wider ones coarsely (`FACTS.md`, 36)."""
DATA = """`validation/mitsuba/scenes`; the witness is Mitsuba 3.9.1, `scalar_spectral`. That these tests catch planted errors is shown in the claim on pairs."""

SCENES = ("defaults", "twosided_kinds", "dielectrics", "roughplastic", "checkerboards", "delta_lights", "fov_x")
QUICK_SCENES = ("defaults", "checkerboards")


def run(claim):
    with open(HERE / "pairs.toml", "rb") as file:
        settings = tomllib.load(file)
    reference, ours = compare.Mitsuba("scalar_spectral"), compare.Abbe(claim.abbe)
    power = QUICK if claim.quick else FULL
    results = []
    for name in claim.only or (QUICK_SCENES if claim.quick else SCENES):
        pair = Pair.of(name, settings[name])
        # Other seeds than in the claim on pairs.
        results.append(compare.judge(pair, ours, reference, power, seed=200_001))
        print("    " + " | ".join(compare.row(results[-1])), flush=True)
    compare.report(claim, results, power)
    claim.table(compare.HEADER, [compare.row(r) for r in results], "As in the claim on pairs.")
    compare.sheets(claim, results)
