"""Write values and densities of Mitsuba 3's rough BSDFs, the witness of tests/statistical/bsdf/mod.rs.

Needs mitsuba (written with 3.9.1, variant scalar_rgb, single precision). Directions are rounded to
single precision first, so that both programs are asked the same question.

    python validation/optics/make_bsdf_reference.py > tests/data/bsdf_reference.csv
"""

import random

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")
from mitsuba import BSDFContext, SurfaceInteraction3f  # noqa: E402


def direction(side):
    """A direction at least a few degrees off the surface, above (1) or below (-1) it."""
    z = side * random.uniform(0.05, 1.0)
    phi = random.uniform(0.0, 2.0 * np.pi)
    radius = np.sqrt(1.0 - z * z)
    v = np.array([radius * np.cos(phi), radius * np.sin(phi), z])
    return [float(np.float32(x)) for x in v]


def materials():
    for name in ["beckmann", "ggx"]:
        for u, v in [(0.1, 0.1), (0.3, 0.3), (0.6, 0.2), (1.0, 1.0)]:
            rough = {"distribution": name, "alpha_u": u, "alpha_v": v}
            metal = {"type": "roughconductor", "eta": 0.2, "k": 3.0, **rough}
            yield "conductor", name, u, v, 0.2, 3.0, metal
            for eta in [1.5, 1.1, 1 / 1.33]:
                glass = {"type": "roughdielectric", "int_ior": eta, "ext_ior": 1.0, **rough}
                yield "dielectric", name, u, v, eta, 0.0, glass


def main():
    random.seed(1986)
    print(f"# Mitsuba {mi.__version__} scalar_rgb, by validation/optics/make_bsdf_reference.py")
    print("material,distribution,alpha_u,alpha_v,eta,k,eye_x,eye_y,eye_z,light_x,light_y,light_z,f_cos,density")
    for kind, name, u, v, eta, k, description in materials():
        bsdf = mi.load_dict(description)
        rows = 0
        while rows < 24:
            from_above = kind == "conductor" or random.random() < 0.5
            si = SurfaceInteraction3f()
            eye = direction(1 if from_above else -1)
            si.wi = mi.Vector3f(eye)
            if random.random() < 0.5:
                light = direction(1 if kind == "conductor" else random.choice([1, -1]))
            else:
                sample, _ = bsdf.sample(
                    BSDFContext(), si, random.random(), mi.Point2f(random.random(), random.random()), True
                )
                light = [float(x) for x in sample.wo]
            if abs(light[2]) < 0.05:
                continue
            value, density = bsdf.eval_pdf(BSDFContext(), si, mi.Vector3f(light), True)
            if density < 1e-4:
                continue
            rows += 1
            numbers = [u, v, eta, k, *eye, *light, float(value[0]), float(density)]
            print(",".join([kind, name] + [repr(float(x)) for x in numbers]))


main()
