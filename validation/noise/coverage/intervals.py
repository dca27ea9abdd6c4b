"""How often the error bars of one EXR hold the truth.

For each scene, sampler and number of samples, pictures of several seeds are rendered small. In each pixel and channel the interval
mean ± t(0.975, degrees of freedom)·error is asked whether it holds the value of a reference: a far longer render with another seed, whose own
error is added in quadrature. It should in 95 % of pixels. Pixels without any noise (error 0 and the reference's value) are counted apart.

    python validation/noise/coverage/intervals.py [--scenes scenes/*/scene.xml ...] [--samplers sobol independent]
"""

import argparse
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
from scipy import stats

ROOT = Path(__file__).resolve().parents[3]
HEADER = "| scene | sampler | samples | degrees of freedom | coverage % | ± | too low % | too high % | agree by chance % | without noise % |\n" + "|---" * 10 + "|"


def render(binary, scene, output, spp, seed, sampler, size):
    import OpenEXR

    if not output.exists():
        command = [binary, "render", scene, "-q", "-o", output, "--spp", str(spp), "--seed", str(seed), "--sampler", sampler, "--size", size]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"abbe exits with {done.returncode}: {done.stderr.strip()}")
    file = OpenEXR.File(str(output), separate_channels=True)
    channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
    names = [name for name in channels if "error." + name in channels]
    stack = lambda prefix: np.stack([channels[prefix + name] for name in names], -1)
    return stack(""), stack("error."), float(file.header()["abbe.degreesOfFreedom"])


def covered(mean, error, degrees, truth, truth_error, truth_degrees):
    """Whether each interval holds the truth, on which side it misses, where replicates agree although there is noise, and where there is none."""
    # A mean is stored in single precision.
    rounding = 2.0**-23 * np.abs(truth)
    same = np.abs(mean - truth) <= 4 * rounding
    noiseless = (error <= rounding) & same & (truth_error <= rounding)
    variance = error**2 + truth_error**2
    with np.errstate(divide="ignore", invalid="ignore"):
        freedom = variance**2 / (error**4 / degrees + truth_error**4 / truth_degrees)
    freedom = np.where(variance > 0, freedom, 1)
    half = stats.t.ppf(0.975, freedom) * np.sqrt(variance)
    return np.abs(mean - truth) <= half + rounding, mean < truth, (error <= rounding) & ~noiseless, noiseless


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary to test")
    parser.add_argument("--scenes", type=Path, nargs="+", default=sorted(ROOT.glob("scenes/*/scene.xml")) + sorted(ROOT.glob("scenes/effects/*/scene.xml")))
    parser.add_argument("--samplers", nargs="+", default=["sobol", "independent"])
    parser.add_argument("--spp", type=int, nargs="+", default=[16, 64, 256, 1024, 4096], help="samples per pixel")
    parser.add_argument("--reference", type=int, default=1 << 15, help="samples of the reference (default 32768)")
    parser.add_argument("--size", default="24x24")
    parser.add_argument("--seeds", type=int, default=8, help="most pictures of each kind; long ones are fewer")
    parser.add_argument("--work", type=Path, default=ROOT / "target/validation/coverage")
    options = parser.parse_args()
    options.work.mkdir(parents=True, exist_ok=True)
    print(HEADER)
    totals = {}
    for scene in options.scenes:
        name = scene.parent.name if scene.stem == "scene" else scene.stem
        # Own seeds for every scene: else one unlucky draw shows in all.
        first = zlib.crc32(name.encode()) % 1_000_000
        picture = lambda spp, seed, sampler: render(
            options.abbe, scene, options.work / f"{name}-{sampler}-{spp}-{seed}-{options.size}.exr", spp, seed, sampler, options.size
        )
        truth = picture(options.reference, first + 999_999, "sobol")
        for sampler in options.samplers:
            for spp in options.spp:
                shares = []
                for seed in range(min(options.seeds, max(1, 4096 // spp))):
                    mean, error, degrees = picture(spp, first + seed, sampler)
                    held, low, chance, noiseless = covered(mean, error, degrees, *truth)
                    noisy = ~noiseless
                    count = max(noisy.sum(), 1)
                    shares.append([(held & noisy).sum() / count, (~held & low & noisy).sum() / count, (~held & ~low & noisy).sum() / count, chance.sum() / count, noiseless.mean()])
                coverage, low, high, chance, noiseless = 100 * np.mean(shares, 0)
                # Channels of a pixel share their samples: they count as one.
                spread = 100 * np.sqrt(coverage / 100 * (1 - coverage / 100) / (len(shares) * mean.shape[0] * mean.shape[1]))
                print(f"| {name} | {sampler} | {spp} | {degrees:.0f} | {coverage:.2f} | {spread:.2f} | {low:.2f} | {high:.2f} | {chance:.2f} | {noiseless:.1f} |", flush=True)
                totals.setdefault((sampler, spp), []).append(coverage)
    for (sampler, spp), values in totals.items():
        print(f"| all | {sampler} | {spp} | | {np.mean(values):.2f} | | | | | |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
