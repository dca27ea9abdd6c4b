"""How far `abbe render --until` moves the mean of a picture by ending when chance makes the error look small.

A render decides at few numbers of samples, and goes on or ends there. Of each seed all decisions of one render are kept: the
mean luminance M(N) and the error bound E(N) after N samples. From them follow, for any target, where each seed would end and
with what mean; the same renders at a fixed N are the control. Writes validation/noise/stopping/DECISIONS.md. Renders stay in
target/validation/stopping. Needs numpy, and examples/probe beside the binary (`cargo build --release --example probe`).

    python validation/noise/stopping/decisions.py [--abbe target/release/abbe] [--seeds 32] [--samples 256]
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[3]
SCENES = "metals,caustic,coloured-glass,box,mug,shapes,sphereflake,prism"
SIZE = [40, 30]
MEASURES = ["relmse", "error", "de"]


def renders(probe, scene, samples, seeds, kept):
    """For each seed what is seen at each decision."""
    path = kept / f"{scene}-{samples}.json"
    known = json.loads(path.read_text()) if path.exists() else []
    if len(known) < seeds:
        question = {"scene": str(ROOT / f"scenes/{scene}/scene.xml"), "size": SIZE, "samples": samples}
        question["seeds"] = list(range(len(known), seeds))
        done = subprocess.run([probe], input=json.dumps({"stopping": question}), capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{scene}: {done.stderr.strip()}")
        known += json.loads(done.stdout)
        path.write_text(json.dumps(known))
    return known[:seeds]


def bias(means, stops):
    """Of pictures that end at decision `stops`, in standard errors of such a picture, against the same seeds at the decision
    at which most of them end: what the decision is independent of, and nearly the same numbers."""
    seeds = np.arange(len(means))
    ended, control = means[seeds, stops], means[:, np.bincount(stops).argmax()]
    return (ended - control).mean() / ended.std(ddof=1)


def jackknife(found, count):
    """A figure of all seeds, and its standard error."""
    every = np.arange(count)
    without = np.array([found(np.delete(every, seed)) for seed in every])
    return found(every), np.sqrt((count - 1) / count * ((without - without.mean()) ** 2).sum())


def at_worst(means, errors):
    """The bias where the target lies in the middle of the errors at a decision, so that half of the renders end there; the mean over the decisions but the last."""
    found = []
    for step in range(means.shape[1] - 1):
        ends = errors[:, step] < np.median(errors[:, step])
        stops = np.where(ends, step, step + 1)
        seeds = np.arange(len(means))
        ended = means[seeds, stops]
        # Both are fixed; their mean has the least noise beside what ends by half there.
        control = 0.5 * (means[:, step] + means[:, step + 1])
        found.append((ended - control).mean() / ended.std(ddof=1))
    return np.mean(found)


def on_average(means, errors):
    """The mean over targets, spread evenly over the logarithm of the error, of which all renders reach each."""
    low, high = errors[:, -1].max(), errors[:, 0].min()
    if low >= high:
        return 0.0
    found = []
    for target in np.geomspace(low, high, 60)[1:-1]:
        stops = np.argmax(errors < target, axis=1)
        found.append(bias(means, stops))
    return np.mean(found)


def signed(value, digits=3):
    return f"{value:+.{digits}f}".replace("-", "−")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary, with examples/probe beside it")
    parser.add_argument("--seeds", type=int, default=32)
    parser.add_argument("--samples", type=int, default=256, help="samples of a pixel, a power of two")
    parser.add_argument("--scenes", default=SCENES, help="names of scenes, with commas")
    arguments = parser.parse_args()
    kept = ROOT / "target/validation/stopping/decisions"
    kept.mkdir(parents=True, exist_ok=True)
    pooled, rows = {measure: [] for measure in MEASURES}, []
    for scene in arguments.scenes.split(","):
        probe = arguments.abbe.parent / "examples/probe"
        runs = renders(probe, scene, arguments.samples, arguments.seeds, kept)
        means = np.array([[seen["mean"] for seen in run] for run in runs])
        for measure in MEASURES:
            errors = np.array([[seen[measure] for seen in run] for run in runs], dtype=float)
            steps = range(means.shape[1] - 1)
            correlation = np.mean([np.corrcoef(means[:, step], errors[:, step])[0, 1] for step in steps])
            of_correlation = 1 / np.sqrt(len(steps) * len(runs))
            worst = jackknife(lambda seeds: at_worst(means[seeds], errors[seeds]), len(runs))
            average = jackknife(lambda seeds: on_average(means[seeds], errors[seeds]), len(runs))
            pooled[measure].append((correlation, of_correlation, *worst, *average))
            rows.append(f"| {scene} | `{measure}` | {signed(correlation, 2)} ± {of_correlation:.2f} | {signed(worst[0])} ± {worst[1]:.3f} | {signed(average[0])} ± {average[1]:.3f} |")
            print(rows[-1], flush=True)
    text = ["# What ending at an error does to the mean", "", *__doc__.split("\n\n")[:2], ""]
    text += [f"`validation/noise/stopping/decisions.py --seeds {arguments.seeds} --samples {arguments.samples} --scenes {arguments.scenes}`, pictures of {SIZE[0]} × {SIZE[1]} pixels; decisions at {', '.join(str(seen['samples']) for seen in runs[0])} samples."]
    text += ["The bias is in standard errors of the mean luminance of a picture that ends so. At worst: for the target that half of the renders meet at a decision. On average: over targets spread evenly over the logarithm of the error.", ""]
    text += ["Where the error bound and the mean have the correlation ρ, the pictures that end at N because the bound looks small are too dark by ρ φ(z)/p standard errors, where p is the fraction that ends and φ(z) the normal density there. Those that go on have as much the other way, of which twice as many samples leave half: the bias is −ρ φ(z)/2, for p = ½ it is −0.2 ρ. So it is at most a fifth of a standard error in any scene, and it is where rare bright samples make both the mean and the error.", ""]
    head = "| correlation of error bound and mean | bias at worst | bias on average |"
    text += [f"| all scenes {head}", "|---|---|---|---|"]
    for measure, found in pooled.items():
        correlation, of_correlation, worst, of_worst, average, of_average = np.array(found).T
        whole = lambda values, errors: (values.mean(), np.sqrt((errors**2).sum()) / len(values))
        of = [whole(correlation, of_correlation), whole(worst, of_worst), whole(average, of_average)]
        text.append(f"| `{measure}` | " + " | ".join(f"{signed(value)} ± {error:.3f}" for value, error in of) + " |")
        print(text[-1])
    text += ["", f"| scene | target {head}", "|---|---|---|---|---|", *rows, ""]
    (Path(__file__).parent / "DECISIONS.md").write_text("\n".join(text))


if __name__ == "__main__":
    main()
