"""Renders the scenes in scenes/ with abbe and with Mitsuba 3 and tests whether the pictures have the same expectation.

Run it through ./run, which prepares both programs. See ../README.md for what the columns mean.
"""

import argparse
import hashlib
import os
import shlex
import subprocess
import sys
import time
import tomllib
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import coverage
import welch

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
LLVM_NAMES = ("libLLVM.so.19.1", "libLLVM-19.so.1", "libLLVM-19.so")
LLVM_FOLDERS = ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib/llvm-19/lib", "/usr/lib64", "/usr/lib")


def load_mitsuba(variant):
    """Mitsuba in the named variant, or in its fastest spectral one: with LLVM 19 if it is there (14 is refused, 15 aborts), else scalar."""
    found = [Path(f, n) for f in LLVM_FOLDERS for n in LLVM_NAMES if Path(f, n).exists()]
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(found[0]))
    import mitsuba

    mitsuba.set_variant(variant or ("llvm_ad_spectral" if "DRJIT_LIBLLVM_PATH" in os.environ else "scalar_spectral"))
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


@dataclass
class Stack:
    """Renders of one scene with different seeds, and the standard errors that the program states where it does."""

    names: tuple  # of the channels
    pictures: np.ndarray  # replicates × height × width × channels
    errors: np.ndarray | None


class Mitsuba:
    """Replicates from Mitsuba, kept on disk: a scene that did not change is not rendered again."""

    name = "Mitsuba"

    def __init__(self, work, variant):
        self.mitsuba, self.work = load_mitsuba(variant), work

    def stack(self, scene, spp, seeds, defines, names=None):
        digest = hashlib.sha256(coverage.fingerprint(scene))
        digest.update(repr((self.mitsuba.__version__, self.mitsuba.variant(), spp, list(seeds), sorted(defines.items()))).encode())
        kept = self.work / f"{scene.stem}-{digest.hexdigest()[:16]}.npz"
        if kept.exists():
            stored = np.load(kept)
            return Stack(tuple(map(str, stored["names"])), stored["pictures"], None), 0.0
        start = time.process_time()
        loaded = self.mitsuba.load_file(str(scene), **defines)
        pictures = np.stack([np.array(self.mitsuba.render(loaded, spp=spp, seed=s)) for s in seeds])
        names = tuple(f.name for f in loaded.sensors()[0].film().bitmap(raw=False).struct_())
        np.savez(kept, pictures=pictures, names=np.array(names))
        return Stack(names, pictures, None), time.process_time() - start


class Abbe:
    """Replicates from abbe, with the standard errors that it states itself."""

    name = "abbe"

    def __init__(self, binary, work, extra):
        self.binary, self.work, self.extra = binary, work, extra

    def stack(self, scene, spp, seeds, defines, names=None):
        import OpenEXR

        pictures, errors = [], []
        output = self.work / f"{scene.stem}.exr"
        before = os.times()
        for seed in seeds:
            command = [self.binary, "render", scene, "-o", output, "--spp", str(spp), "--seed", str(seed), *self.extra]
            command += [word for k, v in defines.items() for word in ("-D", f"{k}={v}")]
            done = subprocess.run(command, capture_output=True, text=True)
            if done.returncode:
                raise RuntimeError(f"abbe exits with {done.returncode}: {(done.stderr or done.stdout).strip()[-800:]}")
            channels = {c: v.pixels for c, v in OpenEXR.File(str(output), separate_channels=True).channels().items()}
            names = names or tuple(c for c in ("X", "Y", "Z") if c in channels)
            if not set(names) <= channels.keys():
                raise RuntimeError(f"no channels {', '.join(sorted(set(names) - channels.keys()))} in {output.name} but {', '.join(sorted(channels))}")
            pictures.append(np.stack([channels[c] for c in names], -1))
            # A channel without a stated error (alpha) is not judged by it.
            unstated = np.zeros_like(pictures[-1][..., 0])
            errors.append(np.stack([channels.get("error." + c, unstated) for c in names], -1))
        after = os.times()
        cpu = after.children_user + after.children_system - before.children_user - before.children_system
        return Stack(names, np.stack(pictures), np.stack(errors)), cpu


def draw(mitsuba, work, name, ours, reference):
    """Picture of both means and of t in Y, G or the only channel (red: ours is brighter, blue: darker; full colour at 6), enlarged four times."""
    a, b = ours.pictures.mean(0).astype(np.float64), reference.pictures.mean(0).astype(np.float64)
    shown_channel = middle(ours.names)
    colour = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) if ours.names[:3] == ("X", "Y", "Z") else np.eye(3)
    seen = lambda m: m[..., :3] @ colour.T if m.shape[-1] >= 3 else m[..., :1].repeat(3, -1)
    white = max(np.quantile(b[..., shown_channel], 0.97), 1e-30)
    shown = [np.clip(seen(m) / white, 0, 1) ** (1 / 2.2) for m in (a, b)]
    test = welch.Welch.of(ours.pictures.astype(np.float64), reference.pictures.astype(np.float64))
    t = np.nan_to_num(test.t[..., shown_channel] / 6, posinf=1, neginf=-1).clip(-1, 1)
    shown.append(np.stack([1 - np.maximum(-t, 0), 1 - np.abs(t), 1 - np.maximum(t, 0)], -1))
    sheet = np.concatenate(shown, 1).repeat(4, 0).repeat(4, 1)
    path = work / f"{name}.png"
    mitsuba.Bitmap((sheet * 255).round().astype(np.uint8)).write(str(path))
    return path


def middle(names):
    """Index of the channel that says how bright a pixel is: Y, G or the first."""
    return next((names.index(n) for n in "YG" if n in names), 0)


HEADER = (
    "| scene | mean | difference per channel, % | in standard errors | detectable, % | median tile, % |"
    " max abs t: pixel, tile | uniform p | variance ratio | CPU s | verdict |\n" + "|---" * 11 + "|"
)


def row(result, seconds):
    if result.mean is None:
        return f"| {result.name} |" + " |" * 9 + " **FAIL** |"
    triple = lambda values, form, scale=1.0: " / ".join(format(v * scale, form) for v in values)
    failures = ", ".join(sorted({test for test, _ in result.failures}))
    return (
        f"| {result.name} | {result.mean[middle(result.channels)]:.4g} | {triple(result.bias, '+.3f', 100)} | {triple(result.sigma, '+.1f')} |"
        f" {result.detectable.max():.3%} | {np.nanmax(result.tile_detectable):.2%} | {np.nanmax(result.pixel_t):.1f}, {np.nanmax(result.tile_t):.1f} |"
        f" {result.uniform_p.min():.2g} | {triple(result.noise, '.2f')} | {seconds[0]:.1f}, {seconds[1]:.1f} |"
        f" {'pass' if result.passed else '**FAIL**: ' + failures} |"
    ).replace("%", "")


# The programs have different seeds because in the controls both are the same program.
REFERENCE = 500_000


def own_seed(name, seed):
    """Every scene has its own seeds: with common ones all scenes share their film positions and wavelengths, and one unlucky draw
    shows in all of them at once."""
    return seed + zlib.crc32(name.encode()) % 1000 * 1_000_000


def scene_file(name, settings):
    return (HERE / settings.get("file", f"scenes/{name}.xml")).resolve()


def samples(settings, options):
    return settings["spp"] // (4 if options.quick else 1)


def first_draw(name, settings, reference, options):
    """Mitsuba's renders for the first comparison of a scene."""
    seed = own_seed(name, options.seed) + REFERENCE
    seeds = range(seed, seed + replicates(options))
    return reference.stack(scene_file(name, settings), samples(settings, options), seeds, settings.get("defines", {}))


def replicates(options):
    return options.replicates // (2 if options.quick else 1)


def pair(name, settings, ours, reference, options, work, ours_defines={}, seed=1, repeats=1):
    """One scene through both programs: the result, and the CPU seconds of each."""
    scene, defines = scene_file(name, settings), settings.get("defines", {})
    spp, count = samples(settings, options), replicates(options) * repeats
    seed = own_seed(name, seed)
    b, seconds_b = reference.stack(scene, spp, range(seed + REFERENCE, seed + REFERENCE + count), defines)
    a, seconds_a = ours.stack(scene, spp, range(seed, seed + count), defines | ours_defines, b.names)
    result = welch.compare(name, a.pictures, b.pictures, b.names, settings.get("correlated", False))
    if options.quick or options.calibrate or options.controls:
        result.failures = [f for f in result.failures if f[0] not in ("noisy", "0.3 %")]
    if a.errors is not None and a.errors.any():
        judged = a.errors.any((0, 1, 2))
        ratio, spread = welch.error_channel(a.pictures[..., judged], a.errors[..., judged])
        if np.isfinite(spread).all():
            text = " / ".join(f"{r:.3f} ± {s:.3f}" for r, s in zip(ratio, spread))
            result.notes.append(f"variance between renders over stated error squared: {text}")
            stated = [c for c, j in zip(b.names, judged) if j]
            wrong = [c for c, r, s in zip(stated, ratio, spread) if not abs(r - 1) <= max(welch.STANDARD_ERRORS * s, welch.ERROR_RATIO)]
            result.failures += [("error", c) for c in wrong]
    if a.pictures.shape == b.pictures.shape and min(a.pictures.shape[1:3]) > 1:
        result.notes.append(f"picture: {draw(reference.mitsuba, work, name, a, b)}")
    return result, (seconds_a, seconds_b)


def judged(name, settings, ours, reference, options, work, ours_defines={}):
    """A scene that fails is rendered anew with other seeds and twice the replicates, and fails only by what fails in both:
    chance does not come back, a bias does."""
    result, seconds = pair(name, settings, ours, reference, options, work, ours_defines, options.seed)
    if result.passed or result.mean is None:
        return result, seconds
    again, more = pair(name, settings, ours, reference, options, work, ours_defines, options.seed + 100_000, repeats=2)
    first = ", ".join(f"{t} {c}".strip() for t, c in result.failures)
    again.failures = [f for f in again.failures if f in result.failures]
    again.notes.insert(0, f"first draw failed by: {first}; the figures are those of the second")
    again.notes[1:1] = [f"first draw: {n}" for n in result.notes if not n.startswith("picture")]
    return again, (seconds[0] + more[0], seconds[1] + more[1])


def show(result, seconds, good):
    print(row(result, seconds), flush=True)
    for note in result.notes:
        if not good or not note.startswith("picture"):
            print(f"    {result.name}: {note}", file=sys.stderr)


def controls(reference, settings, options, work):
    """Mitsuba against Mitsuba: what must pass passes, what must fail fails."""
    cases = [
        ("the same scene, other seeds", {}, True),
        ("light 1 % brighter", {"power": "5.05"}, False),
        ("one bounce less", {"depth": "7"}, False),
    ]
    print(HEADER)
    wrong = 0
    for what, defines, should_pass in cases:
        result, seconds = judged("cornell", {"spp": settings["cornell"]["spp"] // 4}, reference, reference, options, work, defines)
        result.name = f"cornell, {what}"
        show(result, seconds, True)
        wrong += result.passed != should_pass
    print(f"{len(cases) - wrong} of {len(cases)} controls behave as they must")
    return wrong


class Louder:
    """Mitsuba at another number of samples: the calibration compares stacks of unequal variance, as two programs have."""

    name = "Mitsuba, a quarter of the samples"

    def __init__(self, inner):
        self.inner = inner

    def stack(self, scene, spp, seeds, defines, names=None):
        return self.inner.stack(scene, max(spp // 4, 1), seeds, defines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="scenes to compare (default: all)")
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary to test")
    parser.add_argument("--abbe-options", default="--observer cie1931-5nm", metavar="WORDS", help="words for abbe render, such as '--wavelengths 1' or '--sampler sobol'")
    parser.add_argument("--quick", action="store_true", help="half the replicates of a quarter of the samples; the 0.3 %% bounds are then not judged")
    parser.add_argument("--replicates", type=int, default=16, help="renders of each program (default 16)")
    parser.add_argument("--seed", type=int, default=1, help="first seed")
    parser.add_argument("--variant", help="Mitsuba's variant (default: llvm_ad_spectral if LLVM 19 is found, else scalar_spectral)")
    parser.add_argument("--controls", action="store_true", help="Mitsuba against Mitsuba on one scene: equal, brighter, a bounce less")
    parser.add_argument("--calibrate", action="store_true", help="Mitsuba with a quarter of the samples against Mitsuba, every scene: must pass")
    parser.add_argument("--prepare", action="store_true", help="render Mitsuba's side only, to be kept for later")
    options = parser.parse_args()
    with open(HERE / "pairs.toml", "rb") as file:
        settings = tomllib.load(file)
    unknown = set(options.names) - settings.keys()
    if unknown:
        parser.error(f"no such scene: {', '.join(sorted(unknown))}; there are {', '.join(settings)}")
    work = ROOT / "target/validation/mitsuba"
    work.mkdir(parents=True, exist_ok=True)
    reference = Mitsuba(work, options.variant)
    if options.controls:
        return controls(reference, settings, options, work)
    ours = Louder(reference) if options.calibrate else Abbe(options.abbe, work, shlex.split(options.abbe_options))
    print(f"{ours.name} against Mitsuba {reference.mitsuba.__version__} ({reference.mitsuba.variant()}), {replicates(options)} replicates\n\n{HEADER}")
    names = options.names or list(settings)
    if reference.mitsuba.variant().startswith("scalar"):
        for name in [n for n in names if settings[n].get("exact_filter")]:
            print(f"    {name}: left out, the scalar variants do not evaluate its filter exactly; LLVM 19 is needed", file=sys.stderr)
            names.remove(name)
    if options.prepare:
        for name in names:
            print(f"{name}: {first_draw(name, settings[name], reference, options)[1]:.1f} CPU s", flush=True)
        return 0
    failed = []
    if not options.names and (lacking := coverage.missing()):
        print(f"words of the scene language that no scene uses: {', '.join(lacking)}", file=sys.stderr)
        failed.append("coverage")
    for name in names:
        try:
            result, seconds = judged(name, settings[name], ours, reference, options, work)
        except RuntimeError as error:
            result, seconds = welch.Result(name, failures=[("ran", "")], notes=[str(error)]), (0, 0)
        show(result, seconds, result.passed)
        failed += [] if result.passed else [name]
    agreeing = len(set(names) - set(failed))
    print(f"\n{agreeing} of {len(names)} pairs agree" + (f"; failed: {', '.join(failed)}" if failed else ""))
    return len(failed)


if __name__ == "__main__":
    sys.exit(min(main(), 1))
