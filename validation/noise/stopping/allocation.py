"""What the allocation of samples over the picture gains at equal error.

Each scene is rendered with several seeds with samples allocated, and with the same number for each pixel. The truth of a picture is the mean of all others. *Efficiency* is relMSE × CPU seconds of the even pictures over that
of the allocated ones, without pilots: by so much the time to a given error is shorter. Writes validation/noise/stopping/ALLOCATION.md. Needs what measure.py needs.

    python validation/noise/stopping/allocation.py [--abbe target/release/abbe] [--seeds 8] [--samples 64]
"""

import argparse
import time
from pathlib import Path

import numpy as np
from measure import ROOT, SCENES, figures, renders
from harness import machine

SIZE = [64, 48]

# Written beside the table, of 2026-11-25.
REMARKS = """\
In these small pictures hardly anything is predicted to gain (`LEAST_GAIN` in `src/render/allocation.rs` is 1.25), so their pictures are even and nothing is lost but the pilot. Until samples were weighed by what
they cost, allocation lost 9 to 17 % in `box`, `caustic` and `fishbowl`. Where it was forced (a least gain of 1.02), by the bench scenes at 64 samples and six seeds, relMSE × CPU seconds over that before: `caustic`
0.69 (1.38 predicted), `metals` 0.89 (1.19), `absorber` 0.95 (1.11), `mesh` 1.36 (1.11): in smooth pictures nets err less than their samples alone, and fewer samples cost more than is predicted. Left open: no scene
with a caustic gains twofold, and the script compares where each pixel has at least the same number of samples, not times to one error.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary, with probe beside it")
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--scenes", default=",".join(SCENES), help="folders under scenes/, with commas")
    arguments = parser.parse_args()
    kept = ROOT / "target/validation/stopping"
    kept.mkdir(parents=True, exist_ok=True)
    rows, gains = [], {}
    for scene in arguments.scenes.split(","):
        kinds = [renders(arguments.abbe.with_name("probe"), scene, arguments.samples, arguments.seeds, kept, most, SIZE) for most in (1 << 23, 1 << 24)]
        pictures = np.concatenate([pictures[:, -1] for _, pictures in kinds])
        total, n = pictures.sum(axis=0), len(pictures)
        error = np.array([figures(picture, (total - picture) / (n - 1))["relmse"] for picture in pictures]).reshape(2, -1)
        seconds = np.array([[run[-1]["seconds"] for run in looks] for looks, _ in kinds])
        cost = error.mean(axis=1) * np.median(seconds, axis=1)
        # Of the error alone: times vary with what else the machine does.
        spread = np.sqrt(((error.std(axis=1, ddof=1) / error.mean(axis=1)) ** 2).sum() / arguments.seeds)
        gain = cost[1] / cost[0]
        gains[scene] = gain
        rows.append(f"| {scene} | {error[1].mean() / error[0].mean():.2f} ± {spread * error[1].mean() / error[0].mean():.2f} | {np.median(seconds[0]) / np.median(seconds[1]):.2f} | {gain:.2f} ± {gain * spread:.2f} |")
        print(rows[-1], flush=True)
    values = np.array(list(gains.values()))
    text = ["# What the allocation of samples gains", "", *__doc__.split("\n\n")[:2], "", REMARKS]
    text += [f"`{Path(__file__).relative_to(ROOT)} --seeds {arguments.seeds} --samples {arguments.samples} --scenes {arguments.scenes}`, {time.strftime('%Y-%m-%d')}, {machine.describe()}: {len(values)} scenes, pictures of {SIZE[0]} × {SIZE[1]} pixels.", ""]
    text += [f"Geometric mean {np.exp(np.log(values).mean()):.2f}, least {values.min():.2f} ({min(gains, key=gains.get)}), largest {values.max():.2f} ({max(gains, key=gains.get)}).", ""]
    text += ["| scene | relMSE, even over allocated | CPU time, allocated over even | efficiency |", "|---|---|---|---|", *rows, ""]
    (Path(__file__).parent / "ALLOCATION.md").write_text("\n".join(text))


if __name__ == "__main__":
    main()
