"""Write values of Mitsuba 3's hair BSDF, the witness of tests/statistical/bsdf/hair.rs.

Needs mitsuba (written with 3.9.1, variant scalar_spectral, single precision) and numpy. Directions are rounded to
single precision first, so that both programs are asked the same question.

    python validation/optics/make_hair_reference.py > tests/data/hair_reference.csv
"""

import random

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_spectral")
from mitsuba import BSDFContext, SurfaceInteraction3f  # noqa: E402

# Four wavelengths of one path (u = 0.1), and an absorption that falls linearly with wavelength.
WAVELENGTHS = [424.343, 507.333, 571.936, 657.501]
ABSORPTION = [0.9 - 0.8 * (w - 400.0) / 300.0 for w in WAVELENGTHS]
ABSORPTION_LIST = "400:0.9, 700:0.1"

# Index, roughness along and around the fibre, tilt of the scales in degrees.
FIBRES = [
    (1.55, 0.3, 0.3, 2.0),
    (1.55, 0.1, 0.2, 2.0),
    (1.55, 0.8, 0.9, -3.0),
    (1.3, 0.25, 0.6, 10.0),
    (2.0, 0.5, 0.15, 0.0),
    (0.8, 0.4, 0.4, 3.0),
    (1.55, 1.0, 1.0, 20.0),
]


def direction(side):
    """A direction at least a few degrees off the surface, above (1) or below (-1) it."""
    z = side * random.uniform(0.05, 1.0)
    phi = random.uniform(0.0, 2.0 * np.pi)
    radius = np.sqrt(1.0 - z * z)
    v = np.array([radius * np.cos(phi), radius * np.sin(phi), z])
    return [float(np.float32(x)) for x in v]


def main():
    random.seed(2016)
    print(f"# Mitsuba {mi.__version__} scalar_spectral, by validation/optics/make_hair_reference.py")
    print("# absorption " + " ".join(repr(float(a)) for a in ABSORPTION))
    print("eta,along,around,tilt,eye_x,eye_y,eye_z,light_x,light_y,light_z,f_cos_0,f_cos_1,f_cos_2,f_cos_3")
    for fibre in FIBRES:
        names = ["int_ior", "longitudinal_roughness", "azimuthal_roughness", "scale_tilt"]
        tags = "".join(f'<float name="{name}" value="{value}"/>' for name, value in zip(names, fibre))
        tags += f'<float name="ext_ior" value="1"/><spectrum name="sigma_a" value="{ABSORPTION_LIST}"/>'
        bsdf = mi.load_string(f'<bsdf type="hair" version="3.0.0">{tags}</bsdf>')
        rows = 0
        while rows < 24:
            si = SurfaceInteraction3f()
            eye = direction(1)
            si.wi, si.wavelengths = mi.Vector3f(eye), WAVELENGTHS
            if random.random() < 0.5:
                light = direction(random.choice([1, -1]))
            else:
                u = mi.Point2f(random.random(), random.random())
                sample, _ = bsdf.sample(BSDFContext(), si, random.random(), u, True)
                light = [float(x) for x in sample.wo]
            value = [float(v) for v in bsdf.eval(BSDFContext(), si, mi.Vector3f(light), True)]
            if not min(value) > 1e-3:
                continue
            rows += 1
            print(",".join([f"{x:.9g}" for x in [*fibre, *eye, *light, *value]]))


main()
