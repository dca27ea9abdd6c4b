"""Means over spectral bins, as truths for what a film measures in them."""

import numpy as np


def over_bins(centres, function, nodes=8):
    """Mean of a function of wavelength (nm, array; the result's last axis is the bins') over each of equal bins, by Gauss and Legendre's rule."""
    half = (centres[1] - centres[0]) / 2
    x, w = np.polynomial.legendre.leggauss(nodes)
    return sum(weight / 2 * np.asarray(function(centres + half * at)) for at, weight in zip(x, w))
