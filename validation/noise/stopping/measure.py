"""Whether pictures that end at an error reach it as surely as they say, and whether ending there makes them wrong.

`abbe render --until` looks at few numbers of samples, and goes on or ends there. Of each seed all looks of one render are kept:
the picture and its error bounds. From them follows, for any target, where that seed ends, and how far its picture is then from
the truth, which is the mean of all other seeds. The same renders at fixed numbers of samples are the control for the mean, and a
rule that looks at doublings alone is judged by the same renders. Writes validation/noise/stopping/RESULTS.md.
Renders stay in target/validation/stopping. Needs numpy, colour-science, and probe beside the binary (`cargo build --release
--workspace --bins`).

    python validation/noise/stopping/measure.py [--abbe target/release/abbe] [--seeds 20] [--samples 128]
"""

import argparse
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
from colour.difference import delta_E_CIE2000

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
from harness import machine  # noqa: E402

ROOT = Path(__file__).resolve().parents[3]
SCENES = """box caustic coloured-glass doublet fishbowl fluorescent ladders lens lenses metals mug prism shapes sphereflake turntable effects/all-together
    effects/antialias effects/billiards effects/biplane effects/defocus effects/frosted-glass effects/gloss effects/penumbra gallery/bands gallery/instance
    gallery/marble gallery/ply gallery/roughness gallery/torus burley/direct""".split()
# So few pixels that all have the same number of samples.
SIZE = [30, 20]
MEASURES = ["relmse", "error", "de"]
TARGETS = 40
CONFIDENCE = 0.95
REC709_WHITE = np.array([0.95045593, 1.0, 1.08905775])


def renders(probe, scene, samples, seeds, kept, most=None, size=SIZE):
    """What is told of each look of each seed, and the pictures: seeds, looks, pixels, XYZ."""
    name = f"{scene.replace('/', '-')}-{'x'.join(map(str, size))}-{samples}-{seeds}-{most or samples}"
    told, pictures = kept / f"{name}.json", kept / f"{name}.bin"
    if not told.exists():
        question = {"scene": str(ROOT / f"scenes/{scene}/scene.xml"), "size": size, "samples": samples, "seeds": list(range(seeds)), "most": most or samples}
        done = subprocess.run([probe], input=json.dumps({"stopping": question | {"pictures": str(pictures)}}), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{scene}: {done.stderr.strip()}")
        told.write_text(done.stdout)
    looks = json.loads(told.read_text())
    return looks, np.fromfile(pictures, dtype="<f4").reshape(seeds, len(looks[0]), -1, 3).astype(float)


def lab(xyz, white):
    """CIE L*a*b*."""
    ratio = xyz / white
    f = np.where(ratio > (6 / 29) ** 3, np.cbrt(ratio), ratio / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], axis=-1)


def figures(picture, truth):
    """Errors of a picture, as the measures have them."""
    y, of_truth = picture[:, 1], truth[:, 1]
    mean = of_truth.mean()
    # White as `abbe compare` assumes it: the mean is a middle grey.
    ordered = np.sort(of_truth)
    lamp = ordered[len(ordered) - 1 - int(0.01 * (len(ordered) - 1))]
    white = REC709_WHITE * np.minimum(of_truth, lamp).mean() / 0.18
    return {
        "relmse": np.mean((y - of_truth) ** 2 / (of_truth**2 + 0.01 * mean**2)),
        # The mean size of a normal deviate is √(2/π) of its standard error.
        "error": np.abs(y - of_truth).mean() / mean * np.sqrt(np.pi / 2),
        "de": delta_E_CIE2000(lab(picture, white), lab(truth, white)).mean(),
    }


def stops(errors, target, looks):
    """The look at which each seed ends: the first at which its bound is below the target, or the last."""
    met = errors[:, looks] < target
    met[:, -1] = True
    return np.array(looks)[np.argmax(met, axis=1)]


def bias(means, ends):
    """Of pictures that end at these looks, in standard errors of such a picture, against all seeds at the same looks, each as often as renders end there."""
    ended = means[np.arange(len(means)), ends]
    shares = np.bincount(ends, minlength=means.shape[1]) / len(ends)
    return (ended.mean() - shares @ means.mean(axis=0)) / ended.std(ddof=1)


def jackknife(found, count):
    """A figure of all seeds, and its standard error."""
    every = np.arange(count)
    without = np.array([found(np.delete(every, seed)) for seed in every])
    return found(every), np.sqrt((count - 1) / count * ((without - without.mean()) ** 2).sum())


def at_worst(means, errors, looks):
    """The bias where half of the renders meet the target at a look; the mean over the looks but the last."""
    return np.mean([bias(means, stops(errors, np.median(errors[:, look]), looks)) for look in looks[:-1]])


def targets(errors):
    """Spread evenly over the logarithm of the error, of which all renders reach each."""
    low, high = errors[:, -1].max(), errors[:, 0].min()
    return np.geomspace(low, high, TARGETS + 2)[1:-1] if low < high else []


def on_average(means, errors, looks):
    found = [bias(means, stops(errors, target, looks)) for target in targets(errors)]
    return np.mean(found) if found else 0.0


def signed(value, digits=3):
    return f"{value:+.{digits}f}".replace("-", "−")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary, with probe beside it")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--samples", type=int, default=128, help="samples of a pixel at the last look")
    parser.add_argument("--scenes", default=",".join(SCENES), help="folders under scenes/, with commas")
    arguments = parser.parse_args()
    kept = ROOT / "target/validation/stopping"
    kept.mkdir(parents=True, exist_ok=True)
    chosen, n = arguments.scenes.split(","), arguments.seeds
    pooled, rows = {}, []
    for scene in chosen:
        looks, pictures = renders(arguments.abbe.with_name("probe"), scene, arguments.samples, n, kept)
        samples = np.array([look["samples"] for look in looks[0]])
        per_replicate = samples // (samples[0] // 4)
        rules = {"now": list(range(len(samples))), "doublings": [k for k, count in enumerate(per_replicate) if count & (count - 1) == 0]}
        means = pictures[..., 1].mean(axis=2)
        sum_of_last = pictures[:, -1].sum(axis=0)
        actual = {measure: np.zeros(means.shape) for measure in MEASURES}
        for seed in range(n):
            truth = (sum_of_last - pictures[seed, -1]) / (n - 1)
            for look, count in enumerate(samples):
                # The truth has errors of its own.
                larger = 1 + count / samples[-1] / (n - 1)
                for measure, value in figures(pictures[seed, look], truth).items():
                    actual[measure][seed, look] = value / (larger if measure == "relmse" else np.sqrt(larger))
        for measure in MEASURES:
            errors = np.array([[np.inf if look[measure] is None else look[measure] for look in run] for run in looks], dtype=float)
            spread = np.mean(errors.std(axis=0, ddof=1) / errors.mean(axis=0))
            correlation = np.mean([np.corrcoef(means[:, look], errors[:, look])[0, 1] for look in range(len(samples))])
            for rule, at in rules.items():
                wanted = targets(errors)
                ends = [stops(errors, target, at) for target in wanted]
                hits = np.array([actual[measure][np.arange(n), end] < target for target, end in zip(wanted, ends)])
                used = np.mean([samples[end].mean() for end in ends]) if len(wanted) else np.nan
                # What is reached by 19 of 20 is counted seed by seed: targets share their pictures.
                share = (hits.mean(), hits.mean(axis=0).std(ddof=1) / np.sqrt(n)) if len(wanted) else (np.nan, np.nan)
                worst = jackknife(lambda seeds: at_worst(means[seeds], errors[seeds], at), n)
                average = jackknife(lambda seeds: on_average(means[seeds], errors[seeds], at), n)
                pooled.setdefault((measure, rule), []).append((*share, used, *worst, *average))
                if rule == "now":
                    rows.append(f"| {scene} | `{measure}` | {100 * share[0]:.1f} % | {100 * spread:.1f} % | {signed(correlation, 2)} | {signed(worst[0])} ± {worst[1]:.3f} | {signed(average[0])} ± {average[1]:.3f} |")
        print(scene, flush=True)
    text = ["# Ending at an error", "", *__doc__.split("\n\n")[:2], ""]
    text += [f"`{Path(__file__).relative_to(ROOT)} --seeds {n} --samples {arguments.samples}`, {time.strftime('%Y-%m-%d')}, {machine.describe()}: {len(chosen)} scenes × {n} seeds, pictures of {SIZE[0]} × {SIZE[1]} pixels. Looks at {', '.join(map(str, samples))} samples."]
    text += ["", f"Targets are spread evenly over the logarithm of the error, {TARGETS} of each measure and scene, such that all renders reach them. *Reached*: pictures that are nearer to the truth than was asked; at least {100 * CONFIDENCE:.0f} % is said. *Bias*: of the mean luminance, in standard errors of the mean of a picture that ends so. On average over the targets; and at worst, for the targets that half of the renders meet at a look."]
    text += ["", "Where the error bound and the mean have the correlation ρ, pictures that end because the bound looks small are too dark. Those that go on have as much the other way, but more samples: that leaves −cov(N, M)/E[N] in all, where N is the number of samples at which a picture ends and M its mean (N (M − μ) is a martingale, so that its mean is 0). Looking at doublings alone, N takes two values that differ by two where half of the renders end at a look: −0.2 ρ standard errors. With four looks for each doubling N varies as little as the bound does: by twice its spread.", ""]
    text += ["| all scenes | looks | reached | in the scene with fewest | samples | bias on average | bias at worst | largest in a scene |", "|---|---|---|---|---|---|---|---|"]
    for (measure, rule), found in sorted(pooled.items(), key=lambda item: (MEASURES.index(item[0][0]), item[0][1])):
        share, of_share, used, worst, of_worst, average, of_average = np.array(found).T
        whole = lambda values, errors: f"{signed(values.mean())} ± {np.sqrt((errors**2).sum()) / len(values):.3f}"
        at = np.argmax(np.abs(worst))
        text.append(f"| `{measure}` | {'four for each doubling' if rule == 'now' else 'doublings'} | {100 * np.nanmean(share):.1f} ± {100 * np.sqrt(np.nansum(of_share**2)) / np.sum(~np.isnan(share)):.1f} % | {100 * np.nanmin(share):.1f} % | {np.nanmean(used):.1f} | {whole(average, of_average)} | {whole(worst, of_worst)} | {signed(worst[at])} ± {of_worst[at]:.3f} ({chosen[at]}) |")
        print(text[-1])
    text += ["", "With four looks for each doubling, scene by scene; the spread is that of the bound from seed to seed.", "", "| scene | target | reached | spread | correlation of bound and mean | bias at worst | bias on average |", "|---|---|---|---|---|---|---|", *rows, ""]
    (Path(__file__).parent / "RESULTS.md").write_text("\n".join(text))


if __name__ == "__main__":
    main()
