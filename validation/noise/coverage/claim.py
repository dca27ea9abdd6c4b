"""The error bars of one picture hold the truth in 95 % of its pixels

The interval mean ± t(0.975, ν)·error of a pixel, from the `error.*` channels of one EXR with ν = `abbe.degreesOfFreedom`, holds the true value in 95
± 1.5 % of all pixels and channels.
"""

import zlib

import numpy as np
from harness.abbe import ROOT
from harness.claim import Planted
from harness.plots import plt
from intervals import covered

METHOD = """Pictures of 24 × 24 pixels of scenes with soft and hard light, gloss, lenses and motion; the truth is a render of many more samples with
another seed, whose own error is added in quadrature (Welch and Satterthwaite). Pixels without any noise are left out. The channels of a pixel share
its samples, so a cell's error is that of its pixels. Rare bright samples cannot be in the error bars of a picture that has met none: a single scene
may hold less (caustics at 16 samples: 92 %). RESULTS.md beside this file has the table of all scenes, samplers and 16 to 4096 samples
(`intervals.py`)."""
DATA = "The scenes of the repository."

SMALLER = "error bars a sixth too short"
PLANTED = [Planted(SMALLER, ("share of all intervals",))]
SCENES = ("box", "metals", "coloured-glass", "effects/penumbra", "effects/gloss", "effects/defocus", "effects/diagonal-mover", "effects/zone-plate")
QUICK = ("box", "effects/penumbra", "effects/gloss", "effects/diagonal-mover")


def run(claim):
    scenes = QUICK if claim.quick else SCENES
    counts = (16, 64) if claim.quick else (16, 64, 256)
    samplers = ("sobol",) if claim.quick else ("sobol", "independent")
    cells, rows = {}, []

    def picture(name, spp, seed, sampler):
        found = claim.abbe.render(ROOT / "scenes" / name / "scene.xml", spp, seed, ("--sampler", sampler, "--size", "24x24"))
        names = [channel for channel in found.channels if "error." + channel in found.channels]
        return found.stack(names), found.errors(names), found.degrees

    for name in scenes:
        first = zlib.crc32(name.encode()) % 1_000_000
        truth = picture(name, 2048 if claim.quick else 16384, first + 999_999, "sobol")
        for sampler in samplers:
            for spp in counts:
                held, pixels = [], 0
                for seed in range(1 if claim.quick else 2):
                    mean, error, degrees = picture(name, spp, first + seed, sampler)
                    error = error * 5 / 6 if claim.planted == SMALLER else error
                    inside, _, _, noiseless = covered(mean, error, degrees, *truth)
                    held.append(inside[~noiseless])
                    pixels += np.sum(~noiseless.all(-1))
                cells[name, sampler, spp] = np.concatenate(held).mean(), pixels
    share, pixels = (np.array(part) for part in zip(*cells.values()))
    doubt = np.sqrt(share * (1 - share) / pixels)
    total, error = share.mean(), np.sqrt((doubt**2).sum()) / len(share)
    claim.bounded("share of all intervals that hold the truth, off 95 %", total - 0.95, 0.015)
    # Pictures of a few hundred pixels each.
    claim.bounded("share of single scenes, off 95 % beyond three of their standard errors", np.maximum(np.abs(share - 0.95) - 3 * doubt, 0), 0.03)
    for name in scenes:
        rows.append((name, *(f"{100 * cells[name, sampler, spp][0]:.1f}" for sampler in samplers for spp in counts)))
    claim.table(("scene", *(f"{sampler}, {spp}" for sampler in samplers for spp in counts)), rows,
                f"Percent of the intervals that hold the truth, by sampler and samples per pixel; in all {100 * total:.2f} ± {100 * error:.2f}.")
    figure, axes = plt.subplots(figsize=(7.2, 3.2))
    axes.axvspan(93.5, 96.5, color="#eeeeee")
    axes.axvline(95, color="black", lw=0.8)
    for i, (sampler, spp) in enumerate((sampler, spp) for sampler in samplers for spp in counts):
        found = np.array([cells[name, sampler, spp] for name in scenes])
        place = np.arange(len(scenes)) + 0.12 * (i - len(samplers) * len(counts) / 2 + 0.5)
        spread = np.sqrt(found[:, 0] * (1 - found[:, 0]) / found[:, 1])
        axes.errorbar(100 * found[:, 0], place, xerr=200 * spread, fmt="o", label=f"{sampler}, {spp} samples")
    axes.set_yticks(np.arange(len(scenes)), scenes)
    axes.invert_yaxis()
    axes.set(xlabel="intervals that hold the truth (%), with two standard errors")
    axes.legend(fontsize=7.5, loc="center left", bbox_to_anchor=(1, 0.5))
    claim.figure("coverage", figure, "Coverage of nominal 95 % intervals. The mean of all lies in the grey band; single scenes need not.")
