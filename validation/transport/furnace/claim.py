"""A furnace shows every surface at the brightness that its albedo says, per wavelength

Under a sky of the same radiance L(λ) from everywhere a plate is seen with the radiance a(λ, θ) L(λ), where a is its albedo for light seen at the
angle θ (transmitted light included), and a ball that absorbs nothing cannot be seen at all. That holds in each wavelength bin for every material,
integrator, sampler and number C of wavelengths a path.
"""

import numpy as np
import OpenEXR
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import bin_means, film, integrator, diffuse, over, pooled, scene, shape, spectrum

METHOD = """A plate seen at 50° by an orthographic camera, and a ball, under a constant sky with L rising linearly from 0.5 at 360 nm to 1.5 at 830
nm. All 256 pixels of a plate have the same expectation, so their spread is the error of their mean, whatever the sampler (blue noise makes it too
large, never too small). Albedos are computed here: Fresnel's equations for real and complex indices; for rough surfaces the integral of Walter et al.
(2007) over the visible facets with Smith's separable masking, ∫ F G₁ D dm for what is reflected and (1−F)/η² for what is refracted; for plastic F +
(1−F) ρ(1−R)/(1−ρR), where R is the coat's inner diffuse reflectance; for tilted normals (1 + cos τ)/2, the share of a tilted cosine lobe above the
surface. Rough plastic and the principled materials have no such form: there every combination is set against a random
walk of single wavelengths with independent samples, which shares nothing with light sampling and companions. Each combination is judged in ten bins;
then the means over all combinations, in which a common bias would show."""
DATA = """SF11 by SCHOTT's Sellmeier coefficients; the others are made up. Walter et al., Microfacet Models for Refraction through Rough Surfaces,
EGSR 2007."""

BINS = 10
VIEW = np.radians(50)
INTEGRATORS = ("path", "direct", "volpath", "volpathmis", "walk")
COUNTS = (1, 4, 8)
SAMPLERS = ("sobol", "independent", "jittered", "poisson", "bluenoise")
METAL = (0.9, 3.2)
SF11 = '<spectrum name="int_ior" type="measured"><string name="name" value="SF11"/></spectrum>'
BRIGHTER = "sky 1 % brighter"
INDEX = "index of the plate of flint glass off by 0.02"
PLANTED = [
    Planted(BRIGHTER, ("plates: mean over combinations and bins", "balls: mean over combinations and bins")),
    Planted(INDEX, ("plates: mean over combinations and bins",)),
    Planted("every companion brings all of the light (no 1/C)", ("plates: each", "balls: each"), "transport_missing_lane_count"),
    Planted("one bounce less", ("plates: each",), "transport_one_bounce_less"),
]


def sky(nm):
    return 0.5 + (nm - 360) / 470


def rho(nm):
    return 0.2 + 0.6 * (nm - 360) / 470


def sf11(nm):
    squared = (nm * 1e-3) ** 2
    terms = ((1.73848403, 0.0136068604), (0.311168974, 0.0615960463), (1.17490871, 121.922711))
    return np.sqrt(1 + sum(b * squared / (squared - c) for b, c in terms))


def fresnel(cosine, index):
    """Unpolarised reflectance for light from vacuum, of a real or complex index."""
    inside = np.sqrt(1 - (1 - cosine**2) / index**2 + 0j)
    s = (cosine - index * inside) / (cosine + index * inside)
    p = (index * cosine - inside) / (index * cosine + inside)
    return 0.5 * (abs(s) ** 2 + abs(p) ** 2)


def rough(kind, alpha, index, refracts=False):
    """Albedo of a rough interface at the angle of view: the integral over the visible facets. `alpha`: along x and y; the eye is in the xz plane."""
    steps, turns = 1000, 360
    # In w the integrand stays finite at grazing facets, of which a GGX distribution has many.
    w = (np.arange(steps) + 0.5) / steps
    u = 1 - w * w
    phi = 2 * np.pi * (np.arange(turns) + 0.5) / turns
    # Slopes over α with the density of the distribution of projected facets, D cos θ.
    radius = np.sqrt(u / (1 - u)) if kind == "ggx" else np.sqrt(-np.log1p(-u))
    x, y = alpha[0] * radius[:, None] * np.cos(phi), alpha[1] * radius[:, None] * np.sin(phi)
    eye = np.array([np.sin(VIEW), 0, np.cos(VIEW)])
    length = np.sqrt(1 + x**2 + y**2)
    facet = np.stack([-x, -y, np.ones_like(x)], -1) / length[..., None]
    seen = facet @ eye
    # Visible facets: G₁(eye) (eye·m) D dm / cos θ_eye, and D dm = (1/cos θ_m) × what the slopes are spread by.
    visible = smith(kind, alpha, eye[0], eye[1], eye[2]) * np.maximum(seen, 0) * length / eye[2]
    cosine = np.clip(seen, 1e-9, 1)
    reflectance = fresnel(cosine, index)
    light = 2 * seen[..., None] * facet - eye
    total = visible * reflectance * np.where(light[..., 2] > 0, smith(kind, alpha, *np.moveaxis(light, -1, 0)), 0)
    if refracts:
        inside = np.sqrt(1 - (1 - cosine**2) / index**2)
        below = (cosine / index - inside)[..., None] * facet - eye / index
        passed = np.where(below[..., 2] < 0, smith(kind, alpha, *np.moveaxis(below, -1, 0)), 0)
        total = total + visible * (1 - reflectance) * passed / index**2
    return np.mean(total * 2 * w[:, None])


def smith(kind, alpha, x, y, z):
    """Smith's masking G₁ of a direction."""
    with np.errstate(divide="ignore", invalid="ignore"):
        squared = ((alpha[0] * x) ** 2 + (alpha[1] * y) ** 2) / z**2
        if kind == "ggx":
            return 2 / (1 + np.sqrt(1 + squared))
        from scipy.special import erf

        a = 1 / np.sqrt(squared)
        return np.where(squared > 0, 2 / (1 + erf(a) + np.exp(-(a**2)) / (a * np.sqrt(np.pi))), 1.0)


def inner_reflectance(index):
    """Of diffuse light inside a coat of this index, from that outside: 1 − (1 − R_out)/n²."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    cosine = 0.5 * (nodes + 1)
    outer = np.sum(weights * cosine * fresnel(cosine, index))
    return 1 - (1 - outer) / index**2


def plates(work):
    """name -> (element, albedo of wavelength or None, degrees by which the plate is turned more)."""
    linear = "360:0.2, 830:0.8"
    metal = f'{spectrum("eta", METAL[0])}{spectrum("k", METAL[1])}'
    tilt = np.arctan(0.5)
    normals = np.zeros((4, 4, 3), np.float32) + np.array([0.5 + 0.5 * np.sin(tilt), 0.5, 0.5 + 0.5 * np.cos(tilt)], np.float32)
    heights = np.repeat(np.broadcast_to((np.arange(64, dtype=np.float32) + 0.5) / 64, (64, 64))[..., None], 3, -1)
    for name, texture in (("normals", normals), ("heights", heights)):
        header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"RGB": np.ascontiguousarray(texture)}).write(str(work / f"{name}.exr"))
    bitmap = '<texture name="{0}" type="bitmap"><string name="filename" value="{1}.exr"/><boolean name="raw" value="true"/></texture>'
    hard = '<boolean name="use_shadowing_function" value="false"/>'
    mirror = '<bsdf type="conductor"/>'
    cos = np.cos(VIEW)
    above = (1 + np.cos(tilt)) / 2
    thin = fresnel(cos, 1.5)
    coat, inner = fresnel(cos, 1.5), inner_reflectance(1.5)

    def bsdf(kind, content):
        return f'<bsdf type="{kind}">{content}</bsdf>'

    def facets(kind, alpha, content):
        words = f'<string name="distribution" value="{kind}"/>'
        names = (("alpha_u", alpha[0]), ("alpha_v", alpha[1])) if alpha[0] != alpha[1] else (("alpha", alpha[0]),)
        return words + "".join(f'<float name="{name}" value="{value}"/>' for name, value in names) + content

    def flint(nm):
        f = fresnel(cos, sf11(nm))
        return f + (1 - f) / sf11(nm) ** 2

    def plate_of_rough(kind, alpha, index, refracts=False):
        albedo = rough(kind, alpha, index, refracts)
        return lambda nm: albedo

    glass = '<float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/>'
    sellmeier = SF11 + '<float name="ext_ior" value="1"/>'
    principled = f'{spectrum("base_color", linear)}<float name="roughness" value="0.4"/><float name="spec_trans" value="0.3"/>'
    return {
        "diffuse": (diffuse(linear), rho, 0),
        "twosided, from behind": (bsdf("twosided", diffuse(linear)), rho, 180),
        "diffusetransmitter": (
            bsdf("diffusetransmitter", spectrum("reflectance", linear) + spectrum("transmittance", "360:0.7, 830:0.1")), lambda nm: 0.9, 0
        ),
        "conductor": (bsdf("conductor", metal), lambda nm: fresnel(cos, complex(*METAL)), 0),
        "roughconductor, GGX 0.3": (bsdf("roughconductor", facets("ggx", (0.3, 0.3), metal)), plate_of_rough("ggx", (0.3, 0.3), complex(*METAL)), 0),
        "roughconductor, Beckmann 0.1, 0.5": (
            bsdf("roughconductor", facets("beckmann", (0.1, 0.5), metal)), plate_of_rough("beckmann", (0.1, 0.5), complex(*METAL)), 0
        ),
        "dielectric, SF11": (bsdf("dielectric", sellmeier), flint, 0),
        "roughdielectric, GGX 0.4": (bsdf("roughdielectric", facets("ggx", (0.4, 0.4), glass)), plate_of_rough("ggx", (0.4, 0.4), 1.5, True), 0),
        "thindielectric": (
            bsdf("thindielectric", glass + spectrum("specular_transmittance", linear)), lambda nm: (2 * thin + rho(nm) * (1 - thin)) / (1 + thin), 0
        ),
        "plastic": (
            bsdf("plastic", f'{spectrum("diffuse_reflectance", linear)}{glass}<boolean name="nonlinear" value="true"/>'),
            lambda nm: coat + (1 - coat) * rho(nm) * (1 - inner) / (1 - rho(nm) * inner), 0,
        ),
        "roughplastic": (bsdf("roughplastic", f'{spectrum("diffuse_reflectance", linear)}{glass}<float name="alpha" value="0.2"/>'), None, 0),
        "principled": (bsdf("principled", principled + '<float name="metallic" value="0.3"/><float name="clearcoat" value="0.5"/>'), None, 0),
        "principledthin": (bsdf("principledthin", principled + '<float name="diff_trans" value="0.6"/>'), None, 0),
        "mask": (bsdf("mask", '<float name="opacity" value="0.4"/>' + diffuse(linear)), lambda nm: 0.6 + 0.4 * rho(nm), 0),
        "blendbsdf": (bsdf("blendbsdf", '<float name="weight" value="0.25"/>' + diffuse(linear) + mirror), lambda nm: 0.25 + 0.75 * rho(nm), 0),
        "normalmap": (bsdf("normalmap", bitmap.format("normalmap", "normals") + hard + diffuse(linear)), lambda nm: above * rho(nm), 0),
        "bumpmap": (bsdf("bumpmap", bitmap.format("height", "heights") + hard + diffuse(linear)), lambda nm: above * rho(nm), 0),
        "null": (bsdf("null", ""), lambda nm: 1.0, 0),
    }


def balls():
    halves = spectrum("reflectance", "360:0.1, 830:0.9") + spectrum("transmittance", "360:0.9, 830:0.1")
    return {
        "diffuse": diffuse(1),
        "diffusetransmitter": f'<bsdf type="diffusetransmitter">{halves}</bsdf>',
        "dielectric, SF11": f'<bsdf type="dielectric">{SF11}</bsdf>',
        "thindielectric": '<bsdf type="thindielectric"/>',
        "plastic": f'<bsdf type="plastic">{spectrum("diffuse_reflectance", 1)}</bsdf>',
    }


def furnace(claim, name, kind, content):
    """A scene file; `kind`: the integrator."""
    scale = 1.01 if claim.planted == BRIGHTER else 1
    if claim.planted == INDEX and name.startswith("plate") and "SF11" in content:
        values = ", ".join(f"{nm}:{sf11(nm) + 0.02}" for nm in range(360, 831, 2))
        content = content.replace(SF11, spectrum("int_ior", values))
    # Half as wide as the square inside the ball's outline.
    look = '<scale x="0.4" y="0.4"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/>'
    camera = f'<sensor type="orthographic"><transform name="to_world">{look}</transform>{film(16, 16)}</sensor>'
    light = f'<emitter type="constant">{spectrum("radiance", f"360:{0.5 * scale}, 830:{1.5 * scale}")}</emitter>'
    return scene(claim.work / f"{name}.xml", integrator(kind), camera, light, content)


def combinations(quick, number, kinds):
    """(integrator, C, sampler): all of them, or a few in which each stands beside each."""
    if not quick:
        return [(kind, count, sampler) for kind in kinds for count in COUNTS for sampler in SAMPLERS]
    return [(kind, COUNTS[(i + number) % 3], SAMPLERS[(2 * i + number) % 5]) for i, kind in enumerate(kinds)]


def run(claim):
    seed = iter(range(1, 1 << 20))

    def measure(file, spp, count, sampler):
        words = ("--spectral", BINS, "--wavelengths", count, "--sampler", sampler)
        nm, radiance, _ = claim.abbe.render(file, spp, next(seed), words).spectrum()
        return nm, over((radiance / bin_means(sky, BINS)).reshape(-1, BINS))

    def judge(what, cases, kinds, contents):
        found, rows, profiles = [], [], {}
        for number, (name, expected) in enumerate(cases.items()):
            def file(kind):
                return furnace(claim, f"{what[:-1]}-{number}-{kind}", kind, contents[name])

            truth, doubt = np.zeros(BINS), np.zeros(BINS)
            if expected is None:
                _, (truth, doubt, _) = measure(file("walk"), 512 if claim.quick else 8192, 1, "independent")
            else:
                truth = bin_means(lambda nm: expected(nm) * sky(nm), BINS) / bin_means(sky, BINS)
            own = []
            for kind, count, sampler in combinations(claim.quick, number, kinds):
                nm, (mean, error, freedom) = measure(file(kind), 256, count, sampler)
                own.append((mean, error))
                found.append((mean, truth, error, doubt))
            mean, error = pooled([m for m, _ in own], [e for _, e in own])
            profiles[name] = (mean, truth, error, doubt)
            worst = np.argmax(np.abs(mean - truth) / np.hypot(error, doubt))
            rows.append((name, "closed form" if expected else "walk", len(own), f"{truth.mean():.5f}", f"{mean.mean():.5f}",
                         f"{np.hypot(error, doubt).mean():.1e}", f"{abs(mean - truth)[worst] / np.hypot(error, doubt)[worst]:.1f}"))
        mean, truth, error, doubt = (np.array(part) for part in zip(*found))
        claim.agrees(f"{what}: each combination of material, integrator, C, sampler and bin", mean, truth, error, freedom, expected_error=doubt)
        mean, truth, error, doubt = (np.array(part) for part in zip(*profiles.values()))
        claim.agrees(f"{what}: mean over combinations, each material and bin", mean, truth, error, 1000, expected_error=doubt)
        # What is off by the same factor everywhere.
        (mean, error), (truth, doubt) = pooled((mean / truth).T, (error / truth).T), pooled(np.ones_like(truth).T, (doubt / truth).T)
        claim.agrees(f"{what}: mean over combinations and bins over what is expected, each material", mean, truth, error, 1000, expected_error=doubt)
        claim.table(("material", "expected by", "combinations", "expected", "measured", "standard error of a bin", "largest |t| of the bins"), rows,
                    f"{what.capitalize()}: radiance over that of the sky, mean over the bins and over all combinations of integrator, C and sampler.")
        return nm, profiles

    chosen = plates(claim.work)
    turned = {name: f'<scale value="1"/><rotate y="1" angle="{np.degrees(VIEW) + turn}"/>' for name, (_, _, turn) in chosen.items()}
    contents = {name: shape("rectangle", turned[name], element) for name, (element, _, _) in chosen.items()}
    nm, profiles = judge("plates", {name: albedo for name, (_, albedo, _) in chosen.items()}, INTEGRATORS, contents)
    solid = {name: f'<shape type="sphere">{element}</shape>' for name, element in balls().items()}
    judge("balls", {name: (lambda nm: 1.0) for name in solid}, [kind for kind in INTEGRATORS if kind != "direct"], solid)

    figure, above, below = curves_and_residuals("wavelength (nm)", "radiance / sky's", "off by (‰)", height=5)
    for name in ("diffuse", "dielectric, SF11", "roughconductor, GGX 0.3", "roughdielectric, GGX 0.4", "plastic", "thindielectric", "mask"):
        mean, truth, error, _ = profiles[name]
        line = above.plot(nm, truth, label=name)[0]
        above.errorbar(nm, mean, 2 * error, fmt="o", color=line.get_color())
        below.errorbar(nm, (mean / truth - 1) * 1e3, 2 * error / truth * 1e3, fmt="o", color=line.get_color())
    above.legend(ncols=2, fontsize=7.5)
    above.set(ylim=(0, 1))
    claim.figure("plates", figure, "Lines: albedos computed here; dots with two standard errors: renders of plates, means over all combinations.")
