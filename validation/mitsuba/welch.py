"""Tests of whether two stacks of independent renders have the same expectation.

A stack is an array (replicates, height, width, channels): each entry a render with its own seed. Nothing is assumed of the
variance of either program; it is measured from the spread of its own replicates.
"""

import warnings
from dataclasses import dataclass, field

import numpy as np
from scipy import ndimage, stats

from harness.claim import sidak

# Probability of a false alarm in one scene of each corrected test (all channels and pixels or tiles of it together).
ALARM = 0.01
# The bounds for the mean of the whole picture.
STANDARD_ERRORS = 3.0
RELATIVE = 0.005
TILE = 8
# How well `error_channel` can tell the ratio of variances.
ERROR_RATIO = 0.03


@dataclass
class Welch:
    """Welch's t-test, element by element, of the means of two stacks."""

    difference: np.ndarray  # mean of the first minus mean of the second
    error: np.ndarray  # standard error of that difference
    t: np.ndarray  # nan where neither stack varies and the means agree
    freedom: np.ndarray  # Welch's and Satterthwaite's degrees of freedom
    p: np.ndarray  # two-sided; nan where nothing can be tested

    @classmethod
    def of(cls, a, b, known=0.0):
        """`known`: how well a mean is known at best, in its own unit."""
        mean_a, mean_b = a.mean(0), b.mean(0)
        # Variances of the means.
        va, vb = a.var(0, ddof=1) / len(a), b.var(0, ddof=1) / len(b)
        difference, error = mean_a - mean_b, np.sqrt(va + vb)
        # Float32 pixels: a mean is not known better than its own rounding, and what varies by less is constant (alpha inside a shape).
        rounding = np.maximum(2.0**-22 * np.maximum(np.abs(mean_a), np.abs(mean_b)), known)
        same = np.abs(difference) <= rounding
        error = np.where(error <= rounding, 0, error)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(error > 0, difference / error, np.where(same, np.nan, np.inf * np.sign(difference)))
            freedom = (va + vb) ** 2 / (va**2 / (len(a) - 1) + vb**2 / (len(b) - 1))
        freedom = np.where(error > 0, freedom, min(len(a), len(b)) - 1)
        return cls(difference, error, t, freedom, 2 * stats.t.sf(np.abs(t), freedom))


def tiles(stack, size=TILE):
    """Means over size×size tiles (smaller ones at the right and bottom edges)."""
    rows = [slice(y, y + size) for y in range(0, stack.shape[1], size)]
    columns = [slice(x, x + size) for x in range(0, stack.shape[2], size)]
    return np.stack([np.stack([stack[:, r, c].mean((1, 2)) for c in columns], 1) for r in rows], 1)


@dataclass
class Result:
    """What the tests found in one scene. `failures` holds (test, channel) pairs."""

    name: str
    channels: tuple = ()
    mean: np.ndarray = None  # of the reference, per channel
    bias: np.ndarray = None  # relative difference of the means
    sigma: np.ndarray = None  # the same in standard errors
    detectable: np.ndarray = None  # 3 standard errors over the mean
    tile_detectable: np.ndarray = None  # the same for the median tile
    pixel_t: np.ndarray = None  # largest |t| of a pixel
    tile_t: np.ndarray = None
    uniform_p: np.ndarray = None  # Kolmogorov-Smirnov on the p-values of all pixels
    noise: np.ndarray = None  # ratio of the variances (first / second)
    error_ratio: np.ndarray = None  # `error_channel`, where the first program states its error
    error_spread: np.ndarray = None
    pixel_detectable: float = None  # 3 standard errors over the mean, median pixel and channel
    means: tuple = None  # both pictures
    t: np.ndarray = None  # of all pixels
    signed: np.ndarray = None  # Student's distribution function at t, of the independent pixels
    tile_signed: np.ndarray = None  # the same of the tiles
    tests: dict = field(default_factory=dict)  # how many values each test judged
    seconds: tuple = (0.0, 0.0)  # of CPU time, of both programs
    redrawn: bool = False  # whether these are the figures of a second draw
    failures: list = field(default_factory=list)
    notes: list = field(default_factory=list)

    @property
    def passed(self):
        return not self.failures


def worst(test, level, where, channel, name):
    """Sentence for the elements that fail: how many, and the worst of them."""
    bad = np.argwhere(test.p[..., channel] < level)
    y, x = min(bad, key=lambda i: test.p[i[0], i[1], channel])
    return (
        f"{name}: {len(bad)} {where}; worst (x {x}, y {y}): difference {test.difference[y, x, channel]:+.4g}"
        f" ± {test.error[y, x, channel]:.2g}, t {test.t[y, x, channel]:+.1f}"
    )


def largest(t):
    """Largest |t| of each channel; nan where nothing could be tested."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return np.nanmax(np.abs(t), (0, 1))


def compare(name, ours, reference, channels, correlated=False, rounding=0.0):
    """All tests of one scene: `ours` against `reference`. Single values of it are known up to `rounding` at best."""
    result = Result(name, channels)
    ours, reference = ours.astype(np.float64), reference.astype(np.float64)
    if ours.shape[1:] != reference.shape[1:]:
        result.failures.append(("shape", ""))
        result.notes.append(f"sizes differ: {ours.shape[2]}×{ours.shape[1]} and {reference.shape[2]}×{reference.shape[1]}")
        return result
    for stack, who in ((ours, "first"), (reference, "second")):
        if not np.isfinite(stack).all():
            result.failures.append(("finite", ""))
            result.notes.append(f"{(~np.isfinite(stack)).sum()} values of the {who} program are not finite")
            return result

    # Mean of the picture: replicate means are independent whatever pixels share.
    whole = Welch.of(ours.mean((1, 2)), reference.mean((1, 2)))
    result.mean = reference.mean((0, 1, 2))
    result.bias = whole.difference / result.mean
    result.sigma = whole.t
    result.detectable = STANDARD_ERRORS * whole.error / np.abs(result.mean)

    pixel = Welch.of(ours, reference, rounding)
    tile = Welch.of(tiles(ours), tiles(reference), rounding)
    result.pixel_t, result.tile_t = largest(pixel.t), largest(tile.t)
    with np.errstate(divide="ignore", invalid="ignore"):
        result.tile_detectable = np.nanmedian(STANDARD_ERRORS * tile.error / tiles(reference).mean(0), (0, 1))
        result.noise = ours.var(0, ddof=1).mean((0, 1)) / reference.var(0, ddof=1).mean((0, 1))
        result.pixel_detectable = float(np.nanmedian(STANDARD_ERRORS * pixel.error / reference.mean(0)))
    result.means, result.t = (ours.mean(0), reference.mean(0)), pixel.t
    result.tile_signed = stats.t.cdf(tile.t, tile.freedom)
    result.tests = {"pixel": int(np.isfinite(pixel.p).sum()), "tile": int(np.isfinite(tile.p).sum())}

    step = 5 if correlated else 1
    # The signed value of Student's distribution function is uniform on [0, 1] if the expectations agree: the two-sided p-value would not
    # notice that all pixels lean the same way.
    signed = stats.t.cdf(pixel.t, pixel.freedom)[::step, ::step]
    result.signed = signed
    result.uniform_p = np.ones(len(channels))
    for c, channel in enumerate(channels):
        if abs(result.sigma[c]) > STANDARD_ERRORS:
            result.failures.append(("mean", channel))
        if abs(result.bias[c]) > RELATIVE:
            result.failures.append(("0.5 %", channel))
        if result.detectable[c] > RELATIVE:
            result.failures.append(("noisy", channel))
            result.notes.append(f"{channel}: only {result.detectable[c]:.2%} could be detected: more samples are needed")
        for test, which in ((pixel, "pixel"), (tile, "tile")):
            level = sidak(np.isfinite(test.p).sum(), ALARM)
            if (test.p[..., c] < level).any():
                result.failures.append((which, channel))
                result.notes.append(worst(test, level, which + "s differ", c, channel))
        values = signed[..., c][np.isfinite(signed[..., c])]
        if len(values) >= 50:
            result.uniform_p[c] = stats.kstest(values, "uniform").pvalue
            if result.uniform_p[c] < sidak(len(channels), ALARM):
                result.failures.append(("uniform", channel))
                result.notes.append(
                    f"{channel}: p-values are not uniform (p {result.uniform_p[c]:.1e}; mean of the signed ones {values.mean():.3f}, should be 0.5)"
                )
    return result


def moderated(variance):
    """Variances (height, width, channels) as abbe states them: two thirds a pixel's own, one third the mean of its neighbours' (`src/output/error_bars.rs`)."""
    if min(variance.shape[:2]) < 3:
        return variance
    ring = np.ones((3, 3, 1))
    ring[1, 1] = 0
    count = ndimage.convolve(np.ones(variance.shape[:2] + (1,)), ring, mode="constant")
    return (2 * variance + ndimage.convolve(variance, ring, mode="constant") / count) / 3


def error_channel(stack, errors):
    """Ratio of the variance between renders to the mean square of the standard error that each render states, and that ratio's own
    standard error. It is 1 in expectation if the stated error is honest.

    It is the geometric mean over tiles: one bright rare sample would else decide for the whole picture, and hide how uncertain that makes the ratio.
    The price is a bias of the order of one over the tile's effective degrees of freedom, 1 to 2 % low where samples are rare and bright.
    """
    stack, errors = stack.astype(np.float64), errors.astype(np.float64)
    # Relative variances, so that a tile's bright pixels do not decide alone; black pixels say nothing.
    level = stack.mean(0) ** 2
    level[level == 0] = np.inf
    between = tiles((moderated(stack.var(0, ddof=1)) / level)[None])[0].reshape(-1, level.shape[-1])
    stated = tiles(((errors**2).mean(0) / level)[None])[0].reshape(-1, level.shape[-1])
    told = ((between > 0) & (stated > 0)).all(1)
    ratios = np.log(between[told] / stated[told])
    ratio = np.exp(ratios.mean(0))
    return ratio, ratio * ratios.std(0, ddof=1) / np.sqrt(len(ratios))
