"""One scene through abbe and through Mitsuba 3: replicates of both, the tests of whether they have the same expectation, and how a claim shows them."""

import hashlib
import importlib.util
import os
import re
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import coverage
import welch
from harness import machine
from harness.abbe import ROOT
from harness.claim import Check
from harness.plots import plt

HERE = Path(__file__).resolve().parent
KEPT = ROOT / "target/validation/mitsuba-renders"
# Mitsuba integrates every fifth row of the CIE's table (FACTS.md, 51).
OBSERVER = ("--observer", "cie1931-5nm")


def with_mitsubas_tables():
    """What makes abbe take the colour-matching functions and the metals of the installed Mitsuba."""
    package = Path(importlib.util.find_spec("mitsuba").origin).parent
    return (*OBSERVER, "--ior-tables", str(package / "data/ior"))


def load_mitsuba(variant=None):
    """Mitsuba in the named variant, or in its fastest spectral one: with LLVM 19 if it is there (14 is refused, 15 aborts), else scalar."""
    machine.find_llvm()
    import mitsuba

    mitsuba.set_variant(variant or ("llvm_ad_spectral" if "DRJIT_LIBLLVM_PATH" in os.environ else "scalar_spectral"))
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    return mitsuba


@dataclass(frozen=True)
class Power:
    """How much is rendered for a comparison."""

    replicates: int  # renders of each program, with different seeds
    divisor: int  # of the samples per pixel that full power takes
    strict: bool = False  # whether the bounds of 0.5 % are judged; only at full power can they be


FULL, QUICK = Power(10, 1, True), Power(8, 4)


@dataclass
class Stack:
    """Renders of one scene with different seeds, and the standard errors that the program states where it does."""

    names: tuple  # of the channels
    pictures: np.ndarray  # replicates × height × width × channels
    errors: np.ndarray | None
    seconds: float  # of CPU time; 0 if the renders were kept


class Mitsuba:
    """Replicates from Mitsuba, kept on disk: a scene that did not change is not rendered again."""

    def __init__(self, variant=None):
        self.mitsuba = load_mitsuba(variant)
        self.variant = self.mitsuba.variant()
        KEPT.mkdir(parents=True, exist_ok=True)

    def stack(self, scene, spp, seeds, names=None, defines={}):
        digest = hashlib.sha256(coverage.fingerprint(scene))
        digest.update(repr((self.mitsuba.__version__, self.variant, spp, list(seeds), sorted(defines.items()))).encode())
        digest.update(repr(names).encode() if names else b"")
        kept = KEPT / f"{scene.stem}-{digest.hexdigest()[:16]}.npz"
        if kept.exists():
            stored = np.load(kept)
            return Stack(tuple(map(str, stored["names"])), stored["pictures"], None, 0.0)
        start = os.times()
        self.mitsuba.set_variant(self.variant)
        loaded = self.mitsuba.load_file(str(scene), **defines)
        pictures = np.stack([self._render(loaded, spp, s, names) for s in seeds])
        names = names or tuple(f.name for f in loaded.sensors()[0].film().bitmap(raw=False).struct_())
        # Whole or not at all: other claims may look for it meanwhile.
        whole = kept.with_suffix(f".{os.getpid()}.npz")
        np.savez(whole, pictures=pictures, names=np.array(names))
        whole.replace(kept)
        end = os.times()
        return Stack(names, pictures, None, end.user + end.system - start.user - start.system)


    def _render(self, loaded, spp, seed, names):
        """All channels, or those of some names: what Mitsuba hands back leaves out the colours where an `aov` holds no integrator."""
        picture = np.array(self.mitsuba.render(loaded, spp=spp, seed=seed))
        if names is None:
            return picture
        bitmap = loaded.sensors()[0].film().bitmap(raw=False)
        found = [f.name for f in bitmap.struct_()]
        return np.array(bitmap)[..., [found.index(n) for n in names]]


class Abbe:
    """Replicates from abbe, with the standard errors that it states itself."""

    def __init__(self, abbe, options=None):
        self.abbe, self.options = abbe, with_mitsubas_tables() if options is None else options

    def stack(self, scene, spp, seeds, names=None, defines={}):
        pictures, errors, before = [], [], self.abbe.cpu
        for seed in seeds:
            picture = self.abbe.render(scene, spp, seed, (*self.options, *sampler_of(scene)), defines)
            names = names or tuple(c for c in ("X", "Y", "Z") if c in picture.channels)
            if not set(names) <= picture.channels.keys():
                raise RuntimeError(f"{scene.stem}: no channels {', '.join(sorted(set(names) - picture.channels.keys()))} but {', '.join(sorted(picture.channels))}")
            pictures.append(picture.stack(names))
            # A channel without a stated error (alpha) is not judged by it.
            unstated = np.zeros_like(pictures[-1][..., 0])
            errors.append(np.stack([picture.channels.get("error." + c, unstated) for c in names], -1))
        return Stack(names, np.stack(pictures), np.stack(errors), self.abbe.cpu - before)


# What abbe is to take for a sampler that a file names: its own choice for all of them makes replicates that are less normal.
SAMPLERS = {"independent": "independent", "stratified": "jittered"}


def sampler_of(scene):
    """The option that forces the sampler that is like the file's. One that an included file names is `independent` in all scenes."""
    named = re.search(r'<sampler type="(\w+)"', Path(scene).read_text())
    own = SAMPLERS.get(named[1]) if named else "independent"
    return ("--sampler", own) if own else ()


class Fewer:
    """A program at a quarter of the samples: a calibration compares stacks of unequal variance, as two programs have."""

    def __init__(self, inner):
        self.inner = inner

    def stack(self, scene, spp, *rest):
        return self.inner.stack(scene, max(spp // 4, 1), *rest)


class Given:
    """A program that is given other values for a scene's parameters."""

    def __init__(self, inner, values):
        self.inner, self.values = inner, values

    def stack(self, scene, spp, seeds, names=None, defines={}):
        return self.inner.stack(scene, spp, seeds, names, defines | self.values)


# The programs have different seeds because in the calibration both are the same program.
REFERENCE = 500_000


def own_seed(name, seed):
    """Every scene has its own seeds: with common ones all scenes share their film positions and wavelengths, and one unlucky draw
    shows in all of them at once."""
    return seed + zlib.crc32(name.encode()) % 1000 * 1_000_000


@dataclass
class Pair:
    """What one scene is rendered from in each program, and how."""

    name: str
    scene: Path  # what abbe reads
    witness: Path  # what Mitsuba reads
    spp: int  # at full power
    correlated: bool = False  # neighbouring pixels share samples
    defines: dict = None
    channels: tuple = None  # all if there are none
    rounding: float = 0.0  # how well values are known at best

    @classmethod
    def of(cls, name, settings):
        file = (HERE / settings.get("file", f"scenes/{name}.xml")).resolve()
        return cls(name, file, file, settings["spp"], settings.get("correlated", False), settings.get("defines"), tuple(settings.get("channels", ())) or None, settings.get("rounding", 0.0))


def draw(pair, ours, reference, power, seed, repeats=1):
    """Renders a pair once and tests it."""
    spp, count = max(pair.spp // power.divisor, 1), power.replicates * repeats
    seed = own_seed(pair.name, seed)
    b = reference.stack(pair.witness, spp, range(seed + REFERENCE, seed + REFERENCE + count), pair.channels, pair.defines or {})
    a = ours.stack(pair.scene, spp, range(seed, seed + count), b.names, pair.defines or {})
    result = welch.compare(pair.name, a.pictures, b.pictures, b.names, pair.correlated, pair.rounding)
    if not power.strict:
        result.failures = [f for f in result.failures if f[0] not in ("noisy", "0.5 %")]
    if a.errors is not None and a.errors.any():
        judged = a.errors.any((0, 1, 2))
        ratio, spread = welch.error_channel(a.pictures[..., judged], a.errors[..., judged])
        if np.isfinite(spread).all():
            result.error_ratio, result.error_spread = ratio, spread
            stated = [c for c, j in zip(b.names, judged) if j]
            wrong = [c for c, r, s in zip(stated, ratio, spread) if not abs(r - 1) <= max(welch.STANDARD_ERRORS * s, welch.ERROR_RATIO)]
            result.failures += [("error", c) for c in wrong]
    result.seconds = np.array([a.seconds, b.seconds])
    return result


def judge(pair, ours, reference, power, seed=1):
    """A scene that fails is rendered anew with other seeds and twice the replicates, and fails only by what fails in both:
    chance does not come back, a bias does. What is shown of all pixels is the first draw's, whatever it was."""
    try:
        first = draw(pair, ours, reference, power, seed)
        if first.passed or first.mean is None:
            return first
        again = draw(pair, ours, reference, power, seed + 100_000, repeats=2)
    except RuntimeError as error:
        return welch.Result(pair.name, failures=[("ran", "")], notes=[str(error)])
    told = ", ".join(f"{t} {c}".strip() for t, c in first.failures)
    again.failures = [f for f in again.failures if f in first.failures]
    again.notes = [f"the first draw failed by {told}; the figures are those of the second"] + [f"first draw: {n}" for n in first.notes] + again.notes
    again.signed, again.tile_signed, again.seconds = first.signed, first.tile_signed, first.seconds + again.seconds
    again.redrawn = True
    return again


HEADER = ("scene", "mean", "difference, %", "in standard errors", "3 σ, %", "3 σ of a tile, %", "largest |t|: pixel, tile", "uniform p", "error²", "variance ratio", "CPU s", "")


def row(result):
    """A line of the table; channels are separated by blanks."""
    if result.mean is None:
        return [result.name] + [""] * (len(HEADER) - 2) + ["FAILS: " + "; ".join(result.notes)]
    several = lambda values, form: " ".join(format(v, form) for v in values)
    failures = ", ".join(sorted({test for test, _ in result.failures}))
    return [
        result.name,
        f"{result.mean[middle(result.channels)]:.4g}",
        several(result.bias * 100, "+.3f"),
        several(result.sigma, "+.1f"),
        f"{result.detectable.max() * 100:.3f}",
        f"{np.nanmax(result.tile_detectable) * 100:.2f}",
        f"{np.nanmax(result.pixel_t):.1f}, {np.nanmax(result.tile_t):.1f}",
        f"{result.uniform_p.min():.2g}",
        "" if result.error_ratio is None else several(result.error_ratio, ".2f"),
        several(result.noise, ".2f"),
        several(result.seconds, ".1f"),
        ("FAILS: " + failures if failures else "agrees") + (" (2nd draw)" if result.redrawn else ""),
    ]


def middle(names):
    """Index of the channel that says how bright a pixel is: Y, G or the first."""
    return next((names.index(n) for n in "YG" if n in names), 0)


# What each test says, and what in a result it judges: a value per scene whose largest is told.
TESTS = {
    "mean": ("the means of the whole pictures agree within 3 standard errors", lambda r: np.nanmax(np.abs(r.sigma)), "standard errors", 3.0),
    "0.5 %": ("and within 0.5 %", lambda r: np.nanmax(np.abs(r.bias)) * 100, "%", 100 * welch.RELATIVE),
    "noisy": ("three standard errors are less than 0.5 %, so that the former two mean something", lambda r: r.detectable.max() * 100, "%", 100 * welch.RELATIVE),
    "tile": ("no tile of 8×8 pixels differs, by Welch's t-test of all of them together", lambda r: np.nanmax(r.tile_t), "standard errors", None),
    "pixel": ("no pixel differs, likewise", lambda r: np.nanmax(r.pixel_t), "standard errors", None),
    "uniform": ("the pixels' t values follow Student's distribution (Kolmogorov and Smirnov)", lambda r: -np.log10(max(r.uniform_p.min(), 1e-300)), "= largest −lg p", None),
    "error": (
        "the variance between abbe's renders is the square of the error that each states",
        lambda r: 0 if r.error_ratio is None else np.abs(r.error_ratio - 1).max() * 100,
        "% off",
        None,
    ),
}


def report(claim, results, power):
    """One check for each kind of test, over all scenes."""
    seen = [r for r in results if r.mean is not None]
    broken = [f"{r.name}: {'; '.join(r.notes)}" for r in results if r.mean is None]
    claim.holds("ran: both programs render all scenes, in one size, and no value is NaN or infinite", not broken, "; ".join(broken) or f"{len(seen)} scenes", "all", "one value")
    if not seen:
        return
    detectable = np.array([r.detectable.max() for r in seen])
    tiles = np.array([np.nanmax(r.tile_detectable) for r in seen])
    pixels = np.array([r.pixel_detectable for r in seen])
    spreads = np.array([3 * r.error_spread.max() for r in seen if r.error_spread is not None])
    power_of = {
        "mean": f"{np.median(detectable):.2%} of the mean (median scene), {detectable.max():.2%} (worst)",
        "0.5 %": "0.5 %",
        "noisy": f"{detectable.max():.2%}",
        "tile": f"{np.median(tiles):.2%} of a tile's mean (median scene) at 3 standard errors",
        "pixel": f"{np.median(pixels):.1%} of a pixel's mean (median scene) at 3 standard errors",
        "uniform": "all pixels off by some 4 % of their own standard error",
        "error": f"{np.median(spreads):.1%} of the variance (median scene)" if len(spreads) else "",
    }
    for name, (what, value, unit, bound) in TESTS.items():
        if name in ("0.5 %", "noisy") and not power.strict:
            continue
        values = [value(r) for r in seen]
        tests = sum(r.tests.get(name, len(r.channels)) for r in seen)
        fallen = [r.name for r in seen if name in {test for test, _ in r.failures}]
        worst = int(np.argmax(values))
        found = f"fails in {', '.join(fallen)}; " if fallen else ""
        found += f"largest {values[worst]:.2g} {unit} ({seen[worst].name})"
        ratio = min(values[worst] / bound, 1.0) if bound else 0.0
        allowed = f"≤ {bound:g} {unit}" if bound else {"error": "3 standard errors or 3 %"}.get(name, "false alarm 1 % a scene, twice in a row")
        # Seen twice or not at all: see `judge`.
        claim._add(Check(f"{name}: {what}", tests, found, allowed, power_of[name], np.inf if fallen else ratio))


def picture(values, names, white):
    """Height × width × RGB for the eye."""
    colour = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]) if names[:3] == ("X", "Y", "Z") else np.eye(3)
    seen = values[..., :3] @ colour.T if values.shape[-1] >= 3 else values[..., :1].repeat(3, -1)
    return np.clip(seen / white, 0, 1) ** (1 / 2.2)


def triptych(result):
    """abbe, Mitsuba, and t of the middle channel: red where abbe is brighter, blue where it is darker, full colour at 6."""
    channel = middle(result.channels)
    a, b = result.means
    white = max(np.quantile(b[..., channel], 0.97), 1e-30)
    t = np.nan_to_num(result.t[..., channel] / 6, posinf=1, neginf=-1).clip(-1, 1)
    gap = np.ones((a.shape[0], 1, 3))
    return np.concatenate([picture(a, result.channels, white), gap, picture(b, result.channels, white), gap, np.stack([1 - np.maximum(-t, 0), 1 - np.abs(t), 1 - np.maximum(t, 0)], -1)], 1)


def sheets(claim, results, per_page=12, columns=2):
    """Pages of pictures: abbe, Mitsuba and t of each scene."""
    shown = [r for r in results if r.means is not None and min(r.t.shape[:2]) > 1]
    for page, start in enumerate(range(0, len(shown), per_page)):
        part = shown[start : start + per_page]
        lines = -(-len(part) // columns)
        figure, axes = plt.subplots(lines, columns, figsize=(10.8, 1.5 * lines + 0.2), squeeze=False)
        for axis in axes.flat:
            axis.axis("off")
        for axis, result in zip(axes.flat, part):
            axis.imshow(triptych(result), interpolation="nearest", aspect="equal")
            axis.set_title(result.name + ("" if result.passed else ": FAILS"), fontsize=8, pad=2)
        path = claim.work / f"sheet-{page}.png"
        figure.savefig(path, dpi=120)
        plt.close(figure)
        told = "Left abbe, middle Mitsuba, right t of Y: red where abbe is brighter, blue where it is darker, full colour at |t| = 6." if page == 0 else "Continued."
        claim.figure("", path, f"{told} {part[0].name} to {part[-1].name}.")
