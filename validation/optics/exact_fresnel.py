"""Fresnel's equations by mpmath, in the textbook form (Born and Wolf, "Principles of Optics", sections 1.5.2 and 14.2).

No rearrangement against rounding is shared with the program: digits make up for it."""

from mpmath import mpc, mpf, sqrt


def exact_fresnel(cosine, n, k=0.0):
    """Unpolarised reflectance of the relative index n + ik at mpmath's present precision. The arguments are taken as exact."""
    c, m = mpf(cosine), mpc(n, k)
    s2 = 1 - c * c
    if k == 0 and mpf(n) ** 2 <= s2:
        return mpf(1)
    q = sqrt(m * m - s2)
    if q.imag < 0:
        q = -q
    rs, rp = (c - q) / (c + q), (m * m * c - q) / (m * m * c + q)
    return (abs(rs) ** 2 + abs(rp) ** 2) / 2
