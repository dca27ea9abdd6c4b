"""The image tests pass where nothing differs

Mitsuba against itself with other seeds passes every test, although one side has a quarter of the samples: so a failure of a pair is a difference of the programs, not of the noise.
"""

import tomllib
from dataclasses import replace

import compare
from compare import FULL, HERE, QUICK, Pair
from harness.claim import Planted

METHOD = """The t-test needs means of replicates that are nearly normal. Single samples are skewed where light is found by chance (caustics, mirror images of small lamps), their means over
hundreds of samples less so. Skewness that is equal in both programs cancels in their difference; so Mitsuba with a quarter of the samples is compared with Mitsuba with all of them,
where it does not cancel: twice the standard error, half of it skewed alone. All tests and thresholds are those of the claim on pairs; if a scene fails here it needs more samples."""
DATA = """The scenes of the claim on pairs: those that it renders with `--quick`, but `depth_one`, whose sampler makes replicates that are not normal; five of them here with `--quick`. Others can be named: `--only`; every scene's seeds are its own and differ from those of the pairs."""

BRIGHTER = "Mitsuba's own lamp 1 % brighter"
PLANTED = [Planted(BRIGHTER, ("mean", "tile", "uniform"))]
QUICK_SCENES = ("cornell", "rough_glass", "checkerboards", "envmap", "direct_emitters")
# Its ldsampler makes replicates that are not normal in pixels at an edge (FACTS.md, 82): the test of pixels may cry wolf there; it hides nothing.
LEFT_OUT = ("depth_one",)


def run(claim):
    with open(HERE / "pairs.toml", "rb") as file:
        settings = tomllib.load(file)
    mitsuba = compare.Mitsuba()
    fewer = compare.Fewer(mitsuba)
    if claim.planted:
        # The box names its lamp's power, so both sides are the same file.
        pair = Pair.of("cornell", settings["cornell"])
        compare.report(claim, [compare.judge(pair, compare.Given(fewer, {"power": "5.05"}), mitsuba, QUICK)], QUICK)
        return
    # Whether 0.5 % can be seen is judged where the noise is abbe's.
    power = QUICK if claim.quick else replace(FULL, strict=False)
    names = claim.only or (QUICK_SCENES if claim.quick else [n for n in settings if settings[n].get("quick") and n not in LEFT_OUT and not (mitsuba.variant.startswith("scalar") and settings[n].get("exact_filter"))])
    results = []
    for name in names:
        results.append(compare.judge(Pair.of(name, settings[name]), fewer, mitsuba, power))
        if results[-1].failures or results[-1].redrawn:
            print("    " + " | ".join(compare.row(results[-1])), flush=True)
    compare.report(claim, results, power)
    redrawn = sum(r.redrawn for r in results)
    claim.table(("", ""), [("scenes", len(results)), ("failed a test in the first draw", redrawn), ("failed it again", sum(not r.passed for r in results))],
                "With three tests at 1 % a scene and three standard errors in three channels, one scene in some twenty fails the first draw by chance.")
