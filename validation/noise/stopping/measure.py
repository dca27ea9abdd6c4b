"""Whether pictures that end at an error reach it as surely as they say, and whether ending there makes them wrong.

Renders scenes of the repository with several seeds to each target of `abbe render --until`, compares them with a
picture of many samples, and writes validation/noise/stopping/RESULTS.md. Truths and pictures stay in
target/validation/stopping; an interrupted run goes on where it was. Needs numpy and OpenEXR.

    python validation/noise/stopping/measure.py [--abbe target/release/abbe] [--seeds 20] [--truth 16384]
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import OpenEXR

ROOT = Path(__file__).resolve().parents[3]
SIZE = "40x30"
TARGETS = ["relmse<3e-3", "error<3%", "de<1.5"]
CONFIDENCE = 0.95
Y = np.array([0.2126729, 0.7151522, 0.0721750])


def scenes():
    return {path.parent.name: path for path in sorted((ROOT / "scenes").glob("*/scene.xml"))}


def run(abbe, *words):
    done = subprocess.run([str(word) for word in (abbe, *words)], capture_output=True, text=True)
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(map(str, words))}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def render(abbe, scene, output, *words):
    if not output.exists():
        output.parent.mkdir(parents=True, exist_ok=True)
        run(abbe, "render", scene, "-q", "--no-png", "--size", SIZE, "-o", output, *words)
    file = OpenEXR.File(str(output), separate_channels=True)
    channels = {name: channel.pixels.astype(float) for name, channel in file.channels().items()}
    if "R" in channels:
        luminance = sum(weight * channels[name] for weight, name in zip(Y, "RGB"))
    else:
        luminance = channels["Y"]
    return luminance, float(channels["samples"].mean())


def reached(abbe, target, picture, truth, luminance, of_truth):
    """The error in the unit of the target."""
    if target.startswith("de<"):
        return json.loads(run(abbe, "compare", picture, truth, "--json"))["figures"]["delta_e"]
    difference = luminance - of_truth
    if target.startswith("relmse<"):
        return np.mean(difference**2 / (of_truth**2 + 0.01 * of_truth.mean() ** 2))
    # The mean size of a normal deviate is √(2/π) of its standard error.
    return np.abs(difference).mean() / of_truth.mean() * np.sqrt(np.pi / 2)


def signed(value, digits):
    return f"{value:+.{digits}f}".replace("-", "−")


def bound(target):
    number = target.split("<")[1]
    return float(number.rstrip("%")) / (100 if number.endswith("%") else 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary to measure")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--truth", type=int, default=16384, help="samples of each pixel of the truths")
    parser.add_argument("--scenes", help="names of scenes, with commas [default: all]")
    arguments = parser.parse_args()
    kept = ROOT / "target/validation/stopping"
    rows, pooled = [], {target: [] for target in TARGETS}
    wanted = arguments.scenes.split(",") if arguments.scenes else None
    for name, scene in scenes().items():
        if wanted and name not in wanted:
            continue
        path = kept / name / "truth.exr"
        truth, of_truth = render(arguments.abbe, scene, path, "--spp", arguments.truth, "--seed", 99_999)
        for target in TARGETS:
            means, counts, errors = [], [], []
            for seed in range(arguments.seeds):
                picture = kept / name / f"{target.replace('<', '-').replace('%', '')}-{seed}.exr"
                options = ["--until", target, "--spp", arguments.truth // 4, "--seed", seed]
                luminance, samples = render(arguments.abbe, scene, picture, *options)
                means.append(luminance.mean())
                counts.append(samples)
                errors.append(reached(arguments.abbe, target, picture, path, luminance, truth))
            if max(counts) >= arguments.truth // 4:
                rows.append(f"| {name} | `{target}` | not within {arguments.truth // 4} samples | | |")
                print(rows[-1], flush=True)
                continue
            n, sigma = len(means), np.std(means, ddof=1)
            share = np.mean(np.array(errors) < bound(target))
            bias, slack = (np.mean(means) - truth.mean()) / sigma, np.sqrt(1 / n + np.mean(counts) / of_truth)
            pooled[target].append((share, bias, slack, n))
            rows.append(f"| {name} | `{target}` | {np.mean(counts):.0f} | {100 * share:.0f} % | {signed(bias, 2)} ± {slack:.2f} |")
            print(rows[-1], flush=True)
    chosen = f" --scenes {arguments.scenes}" if wanted else ""
    text = ["# Ending at an error", "", __doc__.split("\n\n")[0], ""]
    text += [f"`validation/noise/stopping/measure.py --seeds {arguments.seeds} --truth {arguments.truth}{chosen}`, pictures of {SIZE} pixels."]
    text += ["Bias is that of the mean luminance of the pictures, in standard errors of such a mean, with its own standard error.", "The targets of a scene share its truth, and where they end at the same number of samples its pictures.", ""]
    text += [f"| all scenes | reached (at least {100 * CONFIDENCE:.0f} % is said) | bias | mean square of bias over its standard error |", "|---|---|---|---|"]
    for target, found in pooled.items():
        share, bias, slack, n = map(np.array, zip(*found))
        weight = 1 / slack**2
        total = (weight * bias).sum() / weight.sum()
        of_share = np.sqrt(CONFIDENCE * (1 - CONFIDENCE) / n.sum())
        spread = np.mean(bias**2 / slack**2)
        text.append(f"| `{target}` | {100 * share.mean():.1f} ± {100 * of_share:.1f} % | {signed(total, 3)} ± {weight.sum() ** -0.5:.3f} | {spread:.2f} |")
    text += ["", "| scene | target | samples | reached | bias |", "|---|---|---|---|---|", *rows, ""]
    (Path(__file__).parent / "RESULTS.md").write_text("\n".join(text))


if __name__ == "__main__":
    main()
