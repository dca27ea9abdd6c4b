"""Write values of Mitsuba 3's plastic and principled BSDFs, the witness of tests/statistical/bsdf/layered.rs.

Needs mitsuba (written with 3.9.1, variant scalar_spectral, single precision) and numpy. Directions are rounded to
single precision first, so that both programs are asked the same question. The tint that Mitsuba gives to sheen and
reflection is the colour over its mean product with y-bar at the four wavelengths of a path; it is written as found.

    python validation/optics/make_layered_reference.py > tests/data/layered_reference.csv
"""

import random

import mitsuba as mi
import numpy as np

mi.set_variant("scalar_spectral")
from mitsuba import BSDFContext, SurfaceInteraction3f  # noqa: E402

# Four wavelengths of one path (u = 0.1), and a colour that rises linearly with wavelength.
WAVELENGTHS = [424.343, 507.333, 571.936, 657.501]
COLOR = [0.2 + 0.6 * (w - 400.0) / 300.0 for w in WAVELENGTHS]
COLOR_LIST = "400:0.2, 700:0.8"

PLASTIC = [
    ("plastic", {"int_ior": 1.5}),
    ("plastic", {"int_ior": 1.5, "nonlinear": True}),
    ("plastic", {"int_ior": 0.8}),
    ("plastic", {"int_ior": 2.4, "nonlinear": True}),
    ("roughplastic", {"int_ior": 1.5, "alpha": 0.05, "distribution": "beckmann"}),
    ("roughplastic", {"int_ior": 1.5, "alpha": 0.3, "distribution": "beckmann", "nonlinear": True}),
    ("roughplastic", {"int_ior": 1.9, "alpha": 0.7, "distribution": "beckmann"}),
    ("roughplastic", {"int_ior": 1.5, "alpha": 0.1, "distribution": "ggx"}),
    ("roughplastic", {"int_ior": 1.3, "alpha": 0.4, "distribution": "ggx", "nonlinear": True}),
    ("roughplastic", {"int_ior": 1.5, "alpha": 0.9, "distribution": "ggx"}),
    ("roughplastic", {"int_ior": 0.8, "alpha": 0.2, "distribution": "ggx"}),
]

# One parameter at a time, then together.
SOLID = [
    {},
    {"roughness": 0.15},
    {"roughness": 1.0},
    {"metallic": 0.6},
    {"metallic": 1.0, "anisotropic": 0.7},
    {"anisotropic": 1.0},
    {"spec_tint": 0.6},
    {"sheen": 0.7},
    {"sheen": 0.7, "sheen_tint": 0.6, "metallic": 0.5},
    {"flatness": 0.6},
    {"clearcoat": 0.7},
    {"clearcoat": 1.0, "clearcoat_gloss": 0.6},
    {"spec_trans": 0.6},
    {"spec_trans": 1.0, "eta": 1.3, "roughness": 0.3},
    {"spec_trans": 0.5, "eta": 0.8},
    {"eta": 0.8, "metallic": 0.5, "spec_tint": 0.5, "clearcoat": 0.5},
    {"eta": 1.0, "metallic": 0.5},
    {
        "spec_trans": 0.6,
        "metallic": 0.5,
        "spec_tint": 0.5,
        "flatness": 0.5,
        "sheen": 0.5,
        "sheen_tint": 0.3,
        "clearcoat": 0.4,
        "clearcoat_gloss": 0.3,
        "anisotropic": 0.5,
        "eta": 1.7,
        "roughness": 0.4,
    },
]

THIN = [
    {},
    {"diff_trans": 0.6},
    {"diff_trans": 2.0, "flatness": 0.5},
    {"sheen": 0.7, "sheen_tint": 0.4, "diff_trans": 0.6, "spec_trans": 0.3},
    {"spec_trans": 0.6},
    {"spec_trans": 1.0, "roughness": 0.3, "eta": 1.3},
    {"spec_trans": 1.0, "spec_tint": 0.6, "anisotropic": 0.5},
    {"spec_trans": 0.5, "eta": 0.8, "spec_tint": 0.5},
    {"spec_trans": 0.4, "flatness": 0.6, "diff_trans": 1.2, "sheen": 0.3, "roughness": 0.7, "eta": 1.8},
]


def direction(side):
    """A direction at least a few degrees off the surface, above (1) or below (-1) it."""
    z = side * random.uniform(0.05, 1.0)
    phi = random.uniform(0.0, 2.0 * np.pi)
    radius = np.sqrt(1.0 - z * z)
    v = np.array([radius * np.cos(phi), radius * np.sin(phi), z])
    return [float(np.float32(x)) for x in v]


def tag(name, value):
    if isinstance(value, bool):
        return f'<boolean name="{name}" value="{str(value).lower()}"/>'
    if isinstance(value, str):
        return f'<string name="{name}" value="{value}"/>'
    return f'<float name="{name}" value="{value}"/>'


def cases():
    for plugin, parameters in PLASTIC:
        yield plugin, parameters, "diffuse_reflectance", '<float name="ext_ior" value="1"/>'
    for plugin, table in [("principled", SOLID), ("principledthin", THIN)]:
        for parameters in table:
            yield plugin, {"eta": 1.5, **parameters}, "base_color", ""


def main():
    random.seed(2012)
    luminance = np.mean([mi.cie1931_y(w) * c for w, c in zip(WAVELENGTHS, COLOR)])
    print(f"# Mitsuba {mi.__version__} scalar_spectral, by validation/optics/make_layered_reference.py")
    print("# colour " + " ".join(repr(float(c)) for c in COLOR))
    print("# tint " + " ".join(repr(float(c / luminance)) for c in COLOR))
    print("plugin,parameters,eye_x,eye_y,eye_z,light_x,light_y,light_z,f_cos_0,f_cos_1,f_cos_2,f_cos_3")
    for plugin, parameters, color, more in cases():
        tags = "".join(tag(name, value) for name, value in parameters.items()) + more
        tags += f'<spectrum name="{color}" value="{COLOR_LIST}"/>'
        bsdf = mi.load_string(f'<bsdf type="{plugin}" version="3.0.0">{tags}</bsdf>')
        words = " ".join(f"{name}={float(v) if isinstance(v, bool) else v}" for name, v in parameters.items())
        both = plugin == "principledthin" or parameters.get("spec_trans", 0.0) > 0.0
        rows = 0
        while rows < 12:
            si = SurfaceInteraction3f()
            eye = direction(random.choice([1, -1]) if both else 1)
            si.wi, si.wavelengths = mi.Vector3f(eye), WAVELENGTHS
            if random.random() < 0.4:
                light = direction(random.choice([1, -1]) if both else 1)
            else:
                u = mi.Point2f(random.random(), random.random())
                sample, _ = bsdf.sample(BSDFContext(), si, random.random(), u, True)
                light = [float(x) for x in sample.wo]
            if not abs(light[2]) > 0.05:
                continue
            value = [float(v) for v in bsdf.eval(BSDFContext(), si, mi.Vector3f(light), True)]
            if not min(value) > 1e-4:
                continue
            rows += 1
            print(",".join([plugin, words] + [f"{x:.9g}" for x in [*eye, *light, *value]]))


main()
