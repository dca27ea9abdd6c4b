"""abbe and Mitsuba 3 render the same pictures

The same XML file, given to both programs, has the same expectation in every channel of every pixel. The scenes use between them every BSDF, emitter, shape,
texture, sensor and film that both programs have, with every parameter, alone and combined.
"""

import tomllib
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

import compare
import coverage
from compare import FULL, HERE, QUICK, Pair
from harness.claim import Planted
from harness.plots import plt

METHOD = """Both programs render 10 pictures with different seeds (8 of a quarter of the samples with `--quick`, and of fewer scenes), so the variance of each is measured and
nothing is assumed of its sampler. The means of the pictures, of tiles of 8×8 pixels and of single pixels are compared by Welch's t-test (Biometrika 34, 1947), with Šidák's correction
for the number of tiles or pixels and channels, at a false alarm of 1 % a scene; the t values of all pixels together must follow Student's distribution. No tolerance is
relative to the pixel, so a local bias is not hidden by a bright picture. A scene that fails is rendered again with fresh seeds and twice as often, and fails by what fails both
times. The standard errors that abbe writes beside each pixel are compared with the spread between its pictures.

What the t-test assumes, means that are nearly normal and unequal variances, is tested by the claim on calibration, which compares Mitsuba with itself."""
DATA = """`validation/mitsuba/scenes`, written for this comparison, and two files that others exported with Mitsuba's Blender add-on (`tests/scenes/foreign`); `pairs.toml` has the samples per
pixel. The witness is Mitsuba 3.9.1 (Jakob et al.), `llvm_ad_spectral`. `FACTS.md` tells what its files mean, each with the experiment that settled it. abbe uses the
colour-matching functions that Mitsuba tabulates, every 5 nm."""

PATCH = """<shape type="rectangle"><transform name="to_world"><scale value="{size}"/><translate x="{x}" y="{y}" z="0.0001"/></transform>
<bsdf type="diffuse"><spectrum name="reflectance" value="{reflectance}"/></bsdf></shape></scene>"""
PANEL = """<translate x="-0.6" z="0.8"/>
        </transform>
        <boolean name="flip_normals" value="{}"/>"""


@dataclass(frozen=True)
class Fault:
    """An error in one scene, or of abbe's source seen in it: what stands in the file, and what abbe alone gets in its place."""

    scene: str
    caught_by: tuple
    old: str = ""
    new: str = ""
    power: compare.Power = QUICK
    mutant: str | None = None


FAULTS = {
    "the lamp 1 % brighter, 0.4 % of the picture": Fault("direct_emitters", ("mean", "uniform"), "360:3 830:4", "360:3.03 830:4.04"),
    "two of eight bounces missing, 0.8 % of the light": Fault("cornell", ("mean", "uniform"), '"depth" value="8"', '"depth" value="6"'),
    "a patch of some 8×8 pixels reflects 3 % less: the mean does not see it": Fault(
        "direct_emitters", ("tile",), "</scene>", PATCH.format(size=0.45, x=0.31, y=-1.34, reflectance=0.582)
    ),
    "a patch of a pixel reflects 30 % less: neither mean nor tile need see it": Fault("direct_emitters", ("pixel",), "</scene>", PATCH.format(size=0.04, x=0.197, y=-1.63, reflectance=0.42)),
    "the normal of one panel turned round": Fault("sides", ("mean", "tile", "pixel"), PANEL.format("true"), PANEL.format("false")),
    "the cosine dropped from the Lambert law": Fault("direct_emitters", ("mean", "tile", "pixel", "uniform"), mutant="dropped_cosine"),
    "1/C missing from the light that a path meets": Fault("depth_one", ("mean", "tile", "pixel"), mutant="mitsuba_missing_one_over_c"),
    "stated errors 6 % too small: the spread of 8 replicates over 8 instead of 7": Fault("direct_emitters", ("error",), power=FULL, mutant="mitsuba_stated_error"),
}
PLANTED = [Planted(what, fault.caught_by, fault.mutant) for what, fault in FAULTS.items()]


def faulty(claim, settings):
    """The pair of a planted error, and at what power it is judged."""
    fault = FAULTS[claim.planted]
    pair = Pair.of(fault.scene, settings[fault.scene])
    if fault.old:
        text = pair.scene.read_text()
        if text.count(fault.old) != 1:
            raise RuntimeError(f"{fault.old!r} stands {text.count(fault.old)} times in {pair.scene.name}")
        changed = claim.work / pair.scene.name
        # It stands in another folder than the files that it names.
        changed.write_text(text.replace(fault.old, fault.new).replace('filename="', f'filename="{pair.scene.parent}/'))
        pair = replace(pair, scene=changed)
    return pair, fault.power


def chosen(settings, claim):
    """The scenes of this run: those asked for, the cheap ones with --quick, or all."""
    if claim.only:
        unknown = set(claim.only) - settings.keys()
        if unknown:
            raise ValueError(f"no such scene: {', '.join(sorted(unknown))}; there are {', '.join(settings)}")
        return list(claim.only)
    return [name for name, of in settings.items() if of.get("quick") or not claim.quick]


def run(claim):
    with open(HERE / "pairs.toml", "rb") as file:
        settings = tomllib.load(file)
    reference, ours = compare.Mitsuba(), compare.Abbe(claim.abbe)
    power = QUICK if claim.quick else FULL
    if claim.planted:
        pair, power = faulty(claim, settings)
        compare.report(claim, [compare.judge(pair, ours, reference, power)], power)
        return
    names = chosen(settings, claim)
    if reference.variant.startswith("scalar"):
        names = [name for name in names if not settings[name].get("exact_filter")]
    results = []
    for name in names:
        result = compare.judge(Pair.of(name, settings[name]), ours, reference, power)
        print("    " + " | ".join(compare.row(result)), flush=True)
        for note in result.notes:
            print(f"        {note}", flush=True)
        results.append(result)
    compare.report(claim, results, power)
    if not claim.only:
        lacking = coverage.missing()
        words = sum(1 for _ in coverage.table())
        claim.holds("coverage: every word of Mitsuba's scene language that abbe knows is in a scene", not lacking, ", ".join(lacking) or f"all {words} words", "all", "one word")
    left = [name for name in settings if name not in names]
    told = f" Left out: {', '.join(left)}." if left else ""
    claim.table(compare.HEADER, [compare.row(r) for r in results], f"All scenes; several numbers are of X, Y, Z or the film's own channels. 3 σ is three standard errors of the difference of "
                f"the means (of the median tile), error² the variance between abbe's pictures over the square of what it states, variance ratio abbe's over Mitsuba's at equal samples, CPU "
                f"seconds abbe's and Mitsuba's (0 where its pictures were kept).{told}")
    distributions(claim, [r for r in results if r.mean is not None])
    compare.sheets(claim, results)
    return results


def distributions(claim, results):
    """Histogram of the pixels' p-values, and the tiles' t values against Student's distribution."""
    shown = lambda values: [v[..., compare.middle(r.channels)].ravel() for r, v in values]
    pixels = np.concatenate(shown((r, r.signed) for r in results))
    tiles = np.concatenate(shown((r, r.tile_signed) for r in results))
    pixels, tiles = pixels[np.isfinite(pixels)], tiles[np.isfinite(tiles)]
    p = 2 * np.minimum(pixels, 1 - pixels)
    figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.4))
    count, bins = np.histogram(p, 50, (0, 1))
    expected = len(p) / 50
    left.axhspan(1 - 3 / np.sqrt(expected), 1 + 3 / np.sqrt(expected), color="#e4e4e4", label="3 standard errors")
    margin = max(0.1, 6 / np.sqrt(expected))
    left.stairs(count / expected, bins, baseline=None, color="C0", label=f"{len(p):,} pixels")
    left.set(xlabel="two-sided p of a pixel", ylabel="number over that of a uniform distribution", ylim=(1 - margin, 1 + margin), xlim=(0, 1))
    left.legend(loc="lower right")
    # Every t through its own Student's distribution to the normal one, so that tiles of different degrees of freedom share an axis.
    z = stats.norm.ppf(np.clip(tiles, 1e-12, 1 - 1e-12))
    edges = np.linspace(-5, 5, 41)
    right.stairs(np.histogram(z, edges)[0], edges, color="C0", label=f"{len(z):,} tiles")
    right.plot(edges[:-1] + 0.125, len(z) * np.diff(stats.norm.cdf(edges)), color="C1", label="expected")
    right.set(yscale="log", ylim=(0.3, None), xlabel="t of a tile, in standard deviations of Student's distribution", ylabel="tiles")
    right.legend()
    beyond = {level: (p < level).mean() for level in (0.05, 0.01, 0.001)}
    claim.figure(
        "distributions",
        figure,
        "The first comparison of every scene, in Y. Left: p-values of all independent pixels; "
        + ", ".join(f"{share:.3%} are below {level:.1%}" for level, share in beyond.items())
        + f". Right: the tiles' t values; their mean is {z.mean():+.3f} ± {1 / np.sqrt(len(z)):.3f}, their variance {z.var():.3f} ± {np.sqrt(2 / len(z)):.3f}, the largest {np.abs(z).max():.1f}.",
    )
