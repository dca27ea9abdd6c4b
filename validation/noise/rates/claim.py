"""Errors fall with the number of samples as theory says, and faster with the default sampler

The mean square error of independent samples falls as 1/N: the slope of log RMSE on log N is −1/2. In scenes with one smooth effect (lens, frosted
glass, gloss, soft light, motion) the default sampler's is steeper than −0.6.
"""

import json

import numpy as np
from harness.abbe import ROOT
from harness.claim import Planted
from harness.plots import plt

METHOD = """`abbe study` renders each scene of tests/scenes/smooth in replicates at several N, against a reference of 16 times the most samples whose
own error is subtracted. The slope between the fewest and the most samples follows from the two mean square errors, its standard error from theirs
(the spread of the replicates). RESULTS.md beside this file has the slopes of all samplers in these scenes and in scenes/effects (`effects.py`)."""
DATA = "The scenes of the repository."

REPLACED = "independent samples in place of the default sampler"
MISCOUNTED = "a fifth fewer samples at the most than told"
PLANTED = [Planted(REPLACED, ("steeper",)), Planted(MISCOUNTED, ("1/N",))]


def run(claim):
    counts = [4, 256] if claim.quick else [4, 16, 64, 256, 1024]
    replicates = 32
    slopes, rows = {}, []
    scenes = sorted((ROOT / "tests/scenes/smooth").glob("*.xml"))
    figure, every = plt.subplots(1, len(scenes), figsize=(9.5, 2.6), sharex=True)
    for axes, scene in zip(every, scenes):
        folder = claim.work / scene.stem
        samplers = "independent,sobol"
        claim.abbe.study(scene, "-o", folder, "-q", "--samplers", samplers, "--replicates", replicates, "--spp", ",".join(map(str, counts)),
                         "--reference-spp", 16 * counts[-1])
        runs = {(run["sampler"], run["samples_per_pixel"]): run for run in json.loads((folder / "study.json").read_text())["runs"]}
        for sampler in samplers.split(","):
            taken = "independent" if claim.planted == REPLACED else sampler
            error = np.array([runs[taken, n]["relmse"] for n in counts])
            doubt = np.array([runs[taken, n]["relmse_standard_error"] for n in counts])
            n = np.array(counts, float)
            if claim.planted == MISCOUNTED:
                # The last error as if it were of fewer samples.
                error[-1] /= 0.8
            span = np.log(n[-1] / n[0])
            slope = 0.5 * np.log(error[-1] / error[0]) / span
            slopes.setdefault(sampler, []).append((slope, 0.5 * np.hypot(doubt[0] / error[0], doubt[-1] / error[-1]) / span))
            axes.errorbar(n, np.sqrt(error), doubt / np.sqrt(error), fmt="o-", lw=1, label=sampler)
        axes.plot(n, np.sqrt(error[0]) * (n / n[0]) ** -0.5, color="#999999", lw=0.8, ls="--")
        axes.set(xscale="log", yscale="log", title=scene.stem, xlabel="samples")
        rows.append((scene.stem, *(f"{slope:.3f} ± {error:.3f}".replace("-", "−") for slope, error in (found[-1] for found in slopes.values()))))
    every[0].set(ylabel="relative RMSE")
    every[0].legend(fontsize=7.5)
    slope, error = np.array(slopes["independent"]).T
    claim.agrees("1/N: slopes with independent samples", slope, -0.5, error, replicates - 1)
    # One number from five, for an error that all scenes share.
    claim.agrees("1/N: mean slope with independent samples", slope.mean(), -0.5, np.sqrt((error**2).sum()) / len(slope), replicates - 1)
    slope, error = np.array(slopes["sobol"]).T
    steep = np.all(slope + 3 * error < -0.6)
    found = f"flattest {slope.max():.2f}"
    claim.holds("steeper than −0.6 with the default sampler", steep, found, "below by 3 standard errors", f"{3 * error.max():.2f}")
    claim.table(("scene", *(f"slope, {sampler}" for sampler in slopes)), rows, "Slope of log RMSE on log samples and its standard error.")
    claim.figure("rates", figure, "Error against samples for single effects; the dashed line falls as independent samples do.")
