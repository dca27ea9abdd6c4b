"""The checks raise false alarms, and see small errors, as often as they say

A check that all others rest on, `agrees`, fails with the stated probability if nothing is wrong, and with a probability of 90 % if the one value that it
judges is off by what it states as its detectable error; among many values together it does so too.
"""

import numpy as np
from scipy import stats

from harness import claim as judged
from harness.claim import Claim, Planted
from harness.plots import plt

METHOD = """
Numbers with known expectation and variance are drawn, their mean and standard error are taken from R replicates as the other claims take theirs, and are handed
to the very same code. How often it fails is a binomial count. The false alarms are counted at a level of 1 % instead of 0.01 %, so that there are any.
"""
# At which the checks are made here.
LEVEL = 0.01
DATA = "Normal deviates of numpy's PCG64."
PLANTED = [Planted("standard errors 10 % too small", caught_by=("false alarms",))]


def share_failing(claim, draws, values, replicates, shift, rng):
    """How many of the draws `agrees` fails: values with a true mean of 100 and replicates of variance 1, the first value off by `shift` standard errors."""
    failures = 0
    before, judged.ALARM = judged.ALARM, LEVEL
    scale = 0.9 if claim.planted else 1.0
    for _ in range(draws):
        sample = rng.standard_normal((replicates, values)) + 100.0
        sample[:, 0] += shift / np.sqrt(replicates)
        trial = Claim("trial", None, None, planted="quiet")
        trial.agrees("trial", sample.mean(0), 100.0, scale * sample.std(0, ddof=1) / np.sqrt(replicates), freedom=replicates - 1)
        failures += not trial.passed
    judged.ALARM = before
    return failures


def run(claim):
    rng = np.random.default_rng(20)
    draws = 1000 if claim.quick else 10000
    figure, axes = plt.subplots()
    rows = []
    for values, replicates in ((1, 8), (64, 8), (1, 64), (64, 64)):
        level = judged.sidak(values, LEVEL)
        false = share_failing(claim, draws, values, replicates, 0.0, rng)
        spread = np.sqrt(LEVEL * (1 - LEVEL) / draws)
        claim.agrees(f"false alarms of {values} values, {replicates} replicates", false / draws, LEVEL, spread)
        # The bias in standard errors that a t-test of the level sees with a probability of 90 %, from the noncentral distribution.
        allowed = stats.t.isf(level / 2, replicates - 1)
        shifts = np.linspace(0, 1.6, 9) * judged.detectable(allowed, replicates - 1)
        few = draws // 10
        seen = [share_failing(claim, few, values, replicates, shift, rng) / few for shift in shifts]
        # The other tail is lost below the noise of the simulation; scipy gives nan there.
        exact = stats.nct.sf(allowed, replicates - 1, shifts) + np.nan_to_num(stats.nct.cdf(-allowed, replicates - 1, shifts))
        # The other values of the family may fail too.
        exact = 1 - (1 - exact) * (1 - level) ** (values - 1)
        axes.errorbar(shifts, seen, np.sqrt(exact * (1 - exact) / few), fmt="o", capsize=2, label=f"{values} values, {replicates} replicates")
        axes.plot(shifts, exact, color=axes.lines[-1].get_color(), linewidth=0.8)
        claim.agrees(f"power over the size of the error, {values} values, {replicates} replicates", seen, exact, np.sqrt(np.maximum(exact * (1 - exact), 1 / few) / few))
        stated = judged.detectable(allowed, replicates - 1)
        truly = stats.nct.sf(allowed, replicates - 1, stated)
        claim.bounded(f"power at the stated detectable error, {values} values, {replicates} replicates", truly - judged.POWER, 0.005)
        rows.append((values, replicates, f"{false / draws:.4f} ± {spread:.4f}", f"{stated:.2f}", f"{truly:.3f}"))
    axes.axhline(judged.POWER, color="#888", linewidth=0.8)
    axes.set_xlabel("error of the first value, standard errors")
    axes.set_ylabel("share of the checks that fail")
    axes.legend()
    claim.figure("power", figure, "How often a check fails over the size of an error in one value: simulated (points, one standard error) and by the noncentral t distribution (lines). Level 1 %; the grey line is the power at which the detectable error is stated.")
    claim.table(("values", "replicates", "false alarms (should be 0.01)", "stated detectable error, standard errors", "is seen with probability"), rows, "The stated detectable error is an approximation; the last column is by the noncentral t distribution itself.")
