"""The rate at which the error of each effect falls with the number of samples, for every sampler.

Runs `abbe study` on the scenes in scenes/effects and on the smooth ones in tests/scenes/smooth, and writes the slopes of log RMSE on log samples
with their 95 % intervals, and the errors at the most samples, to validation/noise/rates/RESULTS.md. The studies, with their pages, stay in
target/validation/effects; an interrupted run goes on where it was. Needs nothing but Python; about ten minutes on two cores.

    python validation/noise/rates/effects.py [--abbe target/release/abbe]
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
SAMPLES = [4, 16, 64, 256, 1024]
REPLICATES = 8
SIZE = "32x24"


def study(abbe, scene, name):
    folder = ROOT / "target/validation/effects" / name
    folder.parent.mkdir(parents=True, exist_ok=True)
    command = [abbe, "study", scene, "-o", folder, "-q", "--replicates", REPLICATES, "--spp", ",".join(map(str, SAMPLES)), "--reference-spp", 16 * SAMPLES[-1]]
    if scene.is_relative_to(ROOT / "scenes"):
        command += ["--size", SIZE]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{name}: abbe exits with {done.returncode}: {done.stderr.strip()}")
    return json.loads((folder / "study.json").read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary to study")
    arguments = parser.parse_args()
    smooth = {f"smooth: {path.stem}": path for path in sorted((ROOT / "tests/scenes/smooth").glob("*.xml"))}
    effects = {path.parent.name: path for path in sorted((ROOT / "scenes/effects").glob("*/scene.xml"))}
    slopes, errors, worse, samplers = [], [], [], None
    for name, scene in (smooth | effects).items():
        found = study(arguments.abbe, scene, name.replace(": ", "-"))
        samplers = found["study"]["samplers"]
        laws = {series["sampler"]: series["log_rmse_against_log_samples"] for series in found["series"]}
        last = {run["sampler"]: run for run in found["runs"] if run["samples_per_pixel"] == SAMPLES[-1]}
        law = lambda sampler: "" if not laws.get(sampler) else f"{laws[sampler]['slope']:.2f} ± {laws[sampler]['slope_half_width']:.2f}".replace("-", "−")
        slopes.append(f"| {name} | " + " | ".join(map(law, samplers)) + " |")
        errors.append(f"| {name} | " + " | ".join(f"{100 * last[sampler]['relative_rmse']:.2g}" for sampler in samplers) + " |")
        runs = {(run["sampler"], run["samples_per_pixel"]): run for run in found["runs"]}
        for samples in SAMPLES:
            a, b = runs["sobol", samples], runs["independent", samples]
            z = (a["relmse"] - b["relmse"]) / (a["relmse_standard_error"] ** 2 + b["relmse_standard_error"] ** 2) ** 0.5
            if z > 3:
                worse.append(f"{name} at {samples} samples ({z:.1f} standard errors)")
        print(slopes[-1], flush=True)
    heads = ["| scene | " + " | ".join(samplers) + " |", "|---" * (len(samplers) + 1) + "|"]
    verdict = "; ".join(worse) if worse else "nowhere"
    text = [
        "# Rates of convergence",
        "",
        f"Written by `python validation/noise/rates/effects.py`: {REPLICATES} replicates, {', '.join(map(str, SAMPLES))} samples per pixel in one sequence, pictures of {SIZE.replace('x', ' × ')} pixels",
        "(8 × 8 in the smooth scenes). Scenes in `scenes/effects` have edges and rare bright samples beside their effect; the smooth ones have one effect and nothing else.",
        "",
        "Slope of log RMSE on log samples with its 95 % interval:",
        "",
        *heads,
        *slopes,
        "",
        f"Relative RMSE at {SAMPLES[-1]} samples, %:",
        "",
        *heads,
        *errors,
        "",
        f"`sobol` is worse than `independent` by more than three standard errors: {verdict}.",
        "",
    ]
    (ROOT / "validation/noise/rates/RESULTS.md").write_text("\n".join(text))


if __name__ == "__main__":
    main()
