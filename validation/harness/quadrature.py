"""Means over spectral bins, as truths for what a film measures in them."""

import numpy as np


def over_band(centre, width, function, nodes=8):
    """Mean of a function of wavelength (nm) over a band, or over each of several of one width, by Gauss and Legendre's rule."""
    x, w = np.polynomial.legendre.leggauss(nodes)
    return sum(weight / 2 * np.asarray(function(centre + width / 2 * at)) for at, weight in zip(x, w))


def over_bins(centres, function, nodes=8):
    """Mean of a function of wavelength (nm, array; the result's last axis is the bins') over each of equal bins that lie side by side."""
    return over_band(centres, centres[1] - centres[0], function, nodes)
