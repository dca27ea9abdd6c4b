"""Write Fresnel reflectances with 20 digits, the reference of src/bsdf/fresnel.rs.

Needs mpmath. The textbook forms (exact_fresnel.py) are evaluated with 60 digits.
Inputs are doubles, printed so that they read back exactly.

    python validation/optics/make_fresnel_reference.py > tests/data/fresnel_reference.csv
"""

import math
import random

from exact_fresnel import exact_fresnel
from mpmath import mp, nstr

mp.dps = 60


def cosines():
    """Angles over the whole quarter turn, crowded towards normal and grazing incidence."""
    degrees = [0, 1e-6, 1e-3, 0.1, 1, 10, 20, 30, 40, 45, 50, 60, 70, 75, 80, 85, 88, 89, 89.9, 89.99, 89.9999]
    values = [1.0] + [math.cos(math.radians(angle)) for angle in degrees[1:]]
    return values + [1e-7, 1e-9, 1e-12]


def main():
    random.seed(1969)
    indices = [0.05, 0.1, 0.2, 0.5, 0.66, 0.9, 0.999, 1 - 1e-6, 1 - 1e-10, 1.0, 1 + 2**-52, 1 + 1e-10]
    indices += [1 + 1e-6, 1.000277, 1.001, 1.1, 1.33, 1.5, 1.5046, 1.7, 2.0, 2.42, 4.0, 10.0]
    extinctions = [0.0, 1e-12, 1e-6, 1e-3, 0.1, 1.0, 3.0, 10.0]
    rows = []
    for n in indices:
        for k in extinctions:
            for cosine in cosines():
                if k == 0 or random.random() < 0.2:
                    rows.append((cosine, n, k))
    for _ in range(600):
        n = 0.05 * 200 ** random.random()
        k = random.choice([0.0, 10 ** random.uniform(-8, 1), random.uniform(0, 10)])
        rows.append((math.cos(0.5 * math.pi * random.random()), n, k))
    print("# Unpolarised Fresnel reflectance, by validation/optics/make_fresnel_reference.py")
    print("cosine,n,k,reflectance")
    for cosine, n, k in rows:
        print(f"{cosine!r},{n!r},{k!r},{nstr(exact_fresnel(cosine, n, k), 20)}")


main()
