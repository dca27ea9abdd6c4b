"""Light between two facing planes is the geometric series of its bounces, per wavelength

Two endless parallel diffuse planes of reflectance ρ(λ) that both emit e(λ) are seen, by paths of N segments, with the radiance e (1 − ρᴺ)/(1 − ρ), and
with e/(1 − ρ) by endless paths. A ball that emits inside a large diffuse ball makes the same series with closed walls of finite size: the wall is lit by
π e A/A′ (1 + ρF + ρ²F² + …).
"""

import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import area, bin_means, film, integrator, diffuse, over, scene, shape

METHOD = """Planes 2·10⁴ across at distance 1, so that their ends take less than 10⁻⁷ of the light, seen at 30° by 256 pixels of one expectation. ρ
rises linearly from 0.2 at 360 nm to 0.9 at 830 nm, e from 1.5 to 0.5. Concentric balls of radii 1 and 3: the wall's irradiance is even, E = πe F/(1 −
ρ(1 − F)), where F = 1/9 of what leaves the wall meets the inner ball, which absorbs; so the wall's radiance is ρE/π, seen from between the balls. Ten
bins, integrators path, volpath, volpathmis and walk, C = 1, 4 and 8, two to eight segments and endless ones."""
DATA = "Both series follow from the rendering equation, since radiance is the same at all places of a wall and in all directions."

BINS = 10
BRIGHTER = "planes 1 % brighter"
PLANTED = [
    Planted(BRIGHTER, ("mean over the bins",)),
    Planted("one bounce less", ("planes, each",), "transport_one_bounce_less"),
    Planted("light samples by the balance, scattering by the power heuristic", ("mean over the bins",), "transport_mixed_heuristics"),
    Planted("Lambert without its cosine", ("planes, each",), "dropped_cosine"),
]


def rho(nm):
    return 0.2 + 0.7 * (nm - 360) / 470


def emitted(nm):
    return 1.5 - (nm - 360) / 470


def series(nm, segments):
    whole = emitted(nm) / (1 - rho(nm))
    return whole if segments is None else whole * (1 - rho(nm) ** segments)


def wall(nm):
    seen = 1 / 9
    return rho(nm) * emitted(nm) * seen / (1 - rho(nm) * (1 - seen))


def run(claim):
    scale = 1.01 if claim.planted == BRIGHTER else 1
    light = area(f"360:{1.5 * scale}, 830:{0.5 * scale}")
    paint = diffuse("360:0.2, 830:0.9")
    planes = shape("rectangle", '<scale value="10000"/>', light + paint) + shape(
        "rectangle", '<scale value="10000"/><rotate x="1" angle="180"/><translate z="1"/>', light + paint
    )

    def ball(radius, content, words=""):
        return f'<shape type="sphere"><float name="radius" value="{radius}"/>{words}{content}</shape>'

    balls = ball(1, light + diffuse(0)) + ball(3, paint, '<boolean name="flip_normals" value="true"/>')

    def camera(origin, target):
        look = f'<scale x="0.1" y="0.1"/><lookat origin="{origin}" target="{target}" up="0, 1, 0"/>'
        return f'<sensor type="orthographic"><transform name="to_world">{look}</transform>{film(16, 16)}</sensor>'

    kinds = [("path", 4)] if claim.quick else [(kind, count) for kind in ("path", "volpath", "volpathmis", "walk") for count in (1, 4, 8)]
    spp = 256 if claim.quick else 2048
    seed, profiles = iter(range(1, 10000)), {}
    results = {"planes": [], "balls": []}
    for what, content, view, depths in (
        ("planes", planes, camera("0, 0, 0.5", "0.5, 0, -0.366"), (2, 4, 8, None)),
        ("balls", balls, camera("0, 0, 2", "0.5, 0, 3"), (None,)),
    ):
        for kind, count in kinds:
            for depth in depths:
                file = scene(claim.work / f"{what}-{kind}-{depth}.xml", integrator(kind, depth), view, content)
                nm, radiance, _ = claim.abbe.render(file, spp, next(seed), ("--spectral", BINS, "--wavelengths", count)).spectrum()
                truth = bin_means(wall if what == "balls" else lambda nm: series(nm, depth), BINS)
                results[what].append((kind, count, depth, truth, radiance.reshape(-1, BINS)))
                if (kind, count) == ("path", 4):
                    profiles[what, depth] = truth, *over(radiance.reshape(-1, BINS))
    totals, rows = [], []
    for what, cases in results.items():
        stats = [(truth, *over(pixels)) for *_, truth, pixels in cases]
        truth, mean, error, freedom = (np.array(part) for part in zip(*stats))
        claim.agrees(f"{what}, each integrator, C and number of segments, in each bin", mean, truth, error, freedom[0])
        for kind, count, depth, truth, pixels in cases:
            totals.append(over((pixels / truth).mean(1)))
            rows.append((what, kind, count, depth or "endless", f"{truth[0]:.4f} to {truth[-1]:.4f}", f"{totals[-1][0]:.5f}", f"{totals[-1][1]:.1e}"))
    mean, error, freedom = zip(*totals)
    claim.agrees("mean over the bins, measured over expected", mean, 1, error, freedom)
    header = ("walls", "integrator", "C", "segments", "radiance expected (360 to 830 nm)", "measured / expected", "standard error")
    claim.table(header, rows, "Means over the ten bins.")
    figure, above, below = curves_and_residuals("wavelength (nm)", "radiance of the wall")
    at = np.linspace(360, 830, 300)
    for (what, depth), (truth, mean, error, _) in profiles.items():
        line = above.semilogy(at, wall(at) if what == "balls" else series(at, depth), lw=1)[0]
        name = "ball in a ball" if what == "balls" else f"planes, {depth or 'endless'} segments"
        above.errorbar(nm, mean, 2 * error, fmt="o", color=line.get_color(), label=name)
        below.plot(nm, (mean - truth) / error, "o", color=line.get_color())
    above.legend(fontsize=7.5)
    claim.figure("series", figure, "Lines: the series; dots: renders (path, C = 4) with two standard errors; below, what is left over.")
