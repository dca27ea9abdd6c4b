"""A claim: what it asserts, the checks it made, and how small an error each would have seen.

A claim is a folder with a `claim.py`: its docstring is a title (first line) and the hypothesis; `METHOD` and `DATA` are paragraphs for the report;
`run(claim)` makes the checks, figures and tables; `PLANTED` lists the errors that its checks must catch.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy import stats

from harness.abbe import Abbe

# Probability that a check (all its tests together) fails although nothing is wrong. Some hundred checks make a false alarm in a hundred runs;
# seeds are fixed, so a passing build passes again.
ALARM = 1e-4
# The detectable bias of a check is the one that it would have seen with this probability.
POWER = 0.9
# Pixels are stored in single precision: a mean is not known better.
ROUNDING = 2.0**-22


@dataclass
class Check:
    """One verdict, in words and numbers for the report."""

    what: str
    tests: int  # how many values were judged together
    found: str
    allowed: str
    detectable: str  # the smallest error that would have been seen
    strength: float  # what was found in units of what is allowed; above 1 the check fails

    @property
    def passed(self):
        return bool(self.strength <= 1)


@dataclass
class Figure:
    path: Path
    caption: str


@dataclass
class Table:
    header: list
    rows: list
    caption: str


@dataclass(frozen=True)
class Planted:
    """An error of known size that a claim must catch.

    `mutant` names an entry of a file in `controls/`: a fault in abbe's source. Without it the claim itself plants the error: its `run` asks
    `claim.planted == what` and gives abbe, or the reference, a wrong value. `caught_by` names (the beginnings of) checks of which each must fail.
    """

    what: str
    caught_by: tuple
    mutant: str | None = None


@dataclass
class Claim:
    """The running of one claim. Lengths, radiances and so on are in the units that each check states."""

    name: str
    abbe: Abbe
    work: Path  # for files; empty at the start
    quick: bool = False
    planted: str | None = None
    only: tuple = ()  # parts of the claim that are asked for, where it has such (scenes); empty for all
    checks: list = field(default_factory=list)
    shown: list = field(default_factory=list)  # figures and tables, in order

    @property
    def passed(self):
        return bool(self.checks) and all(check.passed for check in self.checks)

    def bounded(self, what, deviation, bound, unit=""):
        """Nothing is random: the largest of the deviations is at most `bound`. What is larger would be seen."""
        deviation = np.abs(np.atleast_1d(np.asarray(deviation, dtype=float)))
        largest = np.nan if np.isnan(deviation).any() else deviation.max()
        strength = largest / bound if np.isfinite(largest) else np.inf
        self._add(Check(what, deviation.size, number(largest, unit), f"≤ {number(bound, unit)}", number(bound, unit), strength))

    def agrees(self, what, measured, expected, error, freedom=np.inf, unit="", expected_error=0.0):
        """The measured values have the expected ones as their expectation, by a two-sided t-test of all of them together (Šidák).

        `error` is the standard error of each with `freedom` degrees; `expected_error` that of the expectation, if it was measured too (normal).
        A film holds single precision, so that what it rounds off is taken from each difference; what has no variance must be equal but for that.
        """
        measured, expected, error, freedom, more = (
            np.ravel(a).astype(float) for a in np.broadcast_arrays(measured, expected, error, freedom, expected_error)
        )
        difference = measured - expected
        # Welch and Satterthwaite, with an expectation of many degrees.
        total = np.hypot(error, more)
        with np.errstate(divide="ignore", invalid="ignore"):
            freedom = np.where(more > 0, freedom * (total / error) ** 4, freedom)
        rounding = ROUNDING * np.maximum(np.abs(measured), np.abs(expected))
        beyond = np.sign(difference) * np.maximum(np.abs(difference) - rounding, 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            t = np.where(beyond == 0.0, 0.0, beyond / total)
        level = sidak(len(t), ALARM)
        allowed = stats.t.isf(level / 2, freedom)
        seen = detectable(allowed, freedom) * total + rounding
        with np.errstate(divide="ignore", invalid="ignore"):
            strengths = np.abs(t) / allowed
            relative = seen / np.abs(expected)
        strength = np.inf if np.isnan(strengths).any() else strengths.max()
        worst = int(np.argmax(np.nan_to_num(strengths, nan=np.inf)))
        found = f"largest |t| {abs(t[worst]):.1f}: {number(measured[worst], unit)} for {number(expected[worst], unit)}"
        smallest = f"{np.median(relative):.2g} of the value" if np.isfinite(relative).all() else number(np.median(seen), unit)
        self._add(Check(what, len(t), found, f"|t| ≤ {allowed[worst]:.1f}", smallest, strength))

    def holds(self, what, condition, found="", allowed="", detectable=""):
        """Something that is true or false. Say what it would have seen."""
        self._add(Check(what, 1, found, allowed, detectable, 0.0 if condition else np.inf))

    def table(self, header, rows, caption):
        """Rows of text for the report."""
        self.shown.append(Table(list(header), [[str(cell) for cell in row] for row in rows], caption))

    def figure(self, name, figure, caption):
        """A matplotlib figure for the report, kept as SVG, or the path of a PNG."""
        if isinstance(figure, Path):
            self.shown.append(Figure(figure, caption))
            return
        path = self.work / f"{name}.svg"
        figure.savefig(path)
        import matplotlib.pyplot

        matplotlib.pyplot.close(figure)
        self.shown.append(Figure(path, caption))

    def _add(self, check):
        self.checks.append(check)
        if self.planted is None:
            print(f"    {'pass' if check.passed else 'FAIL'}  {check.what}: {check.found} ({check.allowed}; sees {check.detectable})", flush=True)


def detectable(allowed, freedom):
    """The bias, in standard errors, that a t-test with that bound sees with the probability POWER: the normal approximation of the noncentral t
    distribution (Abramowitz and Stegun 26.7.10), right to 0.2 % in probability from 3 degrees of freedom on."""
    with np.errstate(divide="ignore"):
        return allowed * (1 - 1 / (4 * freedom)) + stats.norm.isf(1 - POWER) * np.sqrt(1 + allowed**2 / (2 * freedom))


def sidak(tests, family):
    """Level of one of `tests` independent tests that together raise a false alarm with probability `family`."""
    return -np.expm1(np.log1p(-family) / tests)


def number(value, unit=""):
    """A number as the report shows it."""
    text = f"{value:.3g}" if value == 0 or not np.isfinite(value) or abs(value) < 1e5 else f"{value:.2e}"
    return f"{text} {unit}".strip()
