"""The zenith of a simulated atmosphere has the radiance of a molecular sky, and nearly the colour of the sky model

Air alone, its molecules' cross-sections computed, makes a sky. Its zenith agrees wavelength by wavelength with the equation of transfer of a flat
atmosphere, solved by orders of scattering, and its colour with the clear sky of Hosek and Wilkie but for what that sky holds beside air.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import curves_and_residuals

METHOD = """A ball of air around a ground of reflectance 0.1, with an exponential density of scale height 8434 m, under parallel light of the same
irradiance at all wavelengths. The zenith is seen from the ground by a narrow camera, with light scattered up to 24 times. The reference is computed here: a
plane atmosphere of the same optical depths, 24 Gauss nodes in each half of the directions, 300 layers, orders of scattering summed until they no longer
matter. Neither has polarisation, which would change the radiance by some per cent. Compared is a planet of a hundred times the earth's radius, which is flat
enough; the earth itself has a zenith that is darker by up to 1 %, for its horizon, which scatters light up there, is less bright.

For the colour both are lit by a black body of 5778 K, and the sky of Hosek and Wilkie (`sunsky`, turbidity 1, 2 and 3, without the sun) is looked at in
the same direction."""
DATA = """Bucholtz, Rayleigh-scattering calculations for the terrestrial atmosphere, Applied Optics 34(15), 1995, equations 8 and 9. Hosek and Wilkie, An
Analytic Model for Full Spectral Sky-Dome Radiance, ACM TOG 31(4), 2012. CIE 1931 observer by colour-science."""

DENSER = "5 % more air"
PLANTED = [Planted(DENSER, ("zenith, sun 60° high", "zenith, sun 30° high"))]
EARTH = 6_371_000
BINS = 12
ELEVATIONS = (60, 30)
SCALE_HEIGHT = 8434.0
GROUND = 0.1
DEPOLARISED = 0.0145  # γ = ρ / (2 − ρ) of air near 550 nm


def over(values):
    """Mean over pixels, its standard error by the spread, and the degrees of freedom."""
    return values.mean(0), values.std(0, ddof=1) / np.sqrt(len(values)), len(values) - 1


def cross_section(nm):
    """Of a molecule of air, m²."""
    um = nm * 1e-3
    short = 3.01577e-28 * um ** -(3.55212 + 1.35579 * um + 0.11563 / um)
    long = 4.01061e-28 * um ** -(3.99668 + 1.10298e-3 * um + 2.71393e-2 / um)
    return 1e-4 * np.where(um <= 0.5, short, long)


def depth(nm):
    """Optical depth straight up: 288.15 K and 1013.25 hPa on the ground."""
    return 2.54743e25 * SCALE_HEIGHT * cross_section(nm)


def zenith(tau, elevation):
    """Radiance of the zenith over the irradiance of the sun, for each optical depth."""
    nodes, weights = np.polynomial.legendre.leggauss(24)
    mu, weight = (nodes + 1) / 2, weights / 2
    mu = np.concatenate([mu, [1.0]])  # the zenith is looked at and weighs nothing
    weight = np.concatenate([weight, [0.0]])
    layers = 300
    sun = np.sin(np.radians(elevation))
    step = tau[:, None] / layers
    middle = (np.arange(layers) + 0.5) * step  # of each layer, from the top
    norm = 3 / (4 * (1 + 2 * DEPOLARISED))

    def phase(a, b):
        """The mean over the azimuth, for two cosines. Up or down is the same."""
        squares = a**2 * b**2 + 0.5 * (1 - a**2) * (1 - b**2)
        return norm * ((1 + 3 * DEPOLARISED) + (1 - DEPOLARISED) * squares)

    between = phase(mu[:, None], mu[None, :]) * weight
    first = phase(mu, sun) / (4 * np.pi) * np.exp(-middle / sun)[..., None]  # wavelengths × layers × cosines
    passes = np.exp(-step / mu)
    source, last, total = first, None, np.zeros((len(tau), len(mu)))
    direct = sun * np.exp(-tau / sun)
    for order in range(200):
        down = np.zeros((len(tau), layers + 1, len(mu)))
        for layer in range(layers):
            down[:, layer + 1] = down[:, layer] * passes + source[:, layer] * (1 - passes)
        total += down[:, -1]
        up = np.zeros_like(down)
        flux = 2 * np.pi * (down[:, -1] * mu * weight).sum(1) + (direct if order == 0 else 0)
        up[:, -1] = (GROUND / np.pi * flux)[:, None]
        for layer in reversed(range(layers)):
            up[:, layer] = up[:, layer + 1] * passes + source[:, layer] * (1 - passes)
        # Means over the layers.
        field = 0.5 * (down[:, 1:] + down[:, :-1] + up[:, 1:] + up[:, :-1])
        source = 0.5 * field @ between.T
        if np.max(down[:, -1]) < 1e-6 * np.max(total):
            break
    return total[:, -1]


def sensor(height):
    return f"""<sensor type="perspective"><float name="fov" value="1"/><float name="far_clip" value="1e10"/>
        <transform name="to_world"><lookat origin="0, 0, {height}" target="0, 0, {height + 1000}" up="0, 1, 0"/></transform>
        <film type="hdrfilm"><integer name="width" value="8"/><integer name="height" value="8"/><rfilter type="box"/></film></sensor>"""


def air(elevation, amount, radius=EARTH):
    angle = np.radians(elevation)
    return f"""<scene version="3.0.0"><integrator type="volpath"><integer name="max_depth" value="24"/></integrator>{sensor(radius + 1)}
        <shape type="sphere"><float name="radius" value="{radius + 100_000}"/><bsdf type="null"/><medium type="suspension" name="interior">
        <phase type="air"><float name="amount" value="{amount}"/></phase><volume type="exponential" name="density">
        <float name="scale_height" value="{SCALE_HEIGHT}"/><float name="radius" value="{radius}"/><float name="top" value="99000"/></volume></medium></shape>
        <shape type="sphere"><float name="radius" value="{radius}"/><bsdf type="diffuse"><spectrum name="reflectance" value="{GROUND}"/></bsdf></shape>
        <emitter type="directional"><vector name="direction" x="{-np.cos(angle)}" y="0" z="{-np.sin(angle)}"/>
        <spectrum name="irradiance" value="1"/></emitter></scene>"""


def model(elevation, turbidity):
    angle = np.radians(elevation)
    return f"""<scene version="3.0.0"><integrator type="path"/>{sensor(0)}<emitter type="sunsky"><float name="sun_scale" value="0"/>
        <float name="turbidity" value="{turbidity}"/><spectrum name="albedo" value="{GROUND}"/>
        <vector name="sun_direction" x="{np.cos(angle)}" y="0" z="{np.sin(angle)}"/></emitter></scene>"""


def chromaticity(nm, radiance):
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    weights = np.array([[np.interp(at, observer.wavelengths, observer.values[:, i], 0, 0) for at in nm] for i in range(3)])
    xyz = weights @ radiance
    return xyz[:2] / xyz.sum()


def planck(nm, kelvin=5778.0):
    return nm**-5.0 / np.expm1(1.438777e7 / (nm * kelvin))


def run(claim):
    figure, above, below = curves_and_residuals("wavelength (nm)", "radiance over the sun's irradiance (1/sr)")
    rows = []
    for number, elevation in enumerate(ELEVATIONS):
        amount = 1.05 if claim.planted == DENSER else 1
        results = {}
        for name, radius in (("flat", 100 * EARTH), ("earth", EARTH)):
            file = claim.work / f"{name}{elevation}.xml"
            file.write_text(air(elevation, amount, radius))
            samples = 2048 if claim.quick else 16384
            nm, radiance, _ = claim.abbe.render(file, samples, number + 1, ("--spectral", BINS)).spectrum()
            results[name] = over(radiance.reshape(-1, BINS))
        found, doubt, freedom = results["flat"]
        width = nm[1] - nm[0]
        expected = np.mean([zenith(depth(nm + width * place), elevation) for place in (-0.375, -0.125, 0.125, 0.375)], 0)
        claim.agrees(f"zenith, sun {elevation}° high", found / expected, np.ones(BINS), doubt / expected, freedom)
        earth = results["earth"][0]
        above.plot(nm, expected, lw=1, label=f"sun {elevation}° high")
        above.plot(nm, found, ".", color=above.lines[-1].get_color())
        below.plot(nm, (found - expected) / doubt, ".", color=above.lines[-1].get_color())
        own = chromaticity(nm, earth * planck(nm))
        visible = (nm > 400) & (nm < 700)
        slope = np.polyfit(np.log(nm[visible]), np.log(earth[visible]), 1)[0]
        rows.append((f"air, sun {elevation}° high", f"{own[0]:.4f}", f"{own[1]:.4f}", "", f"{slope:.2f}"))
        for turbidity in (1, 2, 3):
            file = claim.work / f"sky{elevation}-{turbidity}.xml"
            file.write_text(model(elevation, turbidity))
            nm, radiance, _ = claim.abbe.render(file, 256, 1, ("--spectral", BINS)).spectrum()
            sky = radiance.mean((0, 1))
            x, y = chromaticity(nm, sky)
            apart = np.hypot(x - own[0], y - own[1])
            slope = np.polyfit(np.log(nm[visible]), np.log((sky / planck(nm))[visible]), 1)[0]
            rows.append((f"Hosek and Wilkie, turbidity {turbidity}", f"{x:.4f}", f"{y:.4f}", f"{apart:.4f}", f"{slope:.2f}"))
            if turbidity == 2:
                claim.bounded(f"colour beside turbidity 2, sun {elevation}° high, in x and y", apart, 0.02)
    claim.table(("zenith", "x", "y", "apart from air", "power of the wavelength, 400 to 700 nm"), rows, CAPTION)
    above.legend(fontsize=7.5)
    claim.figure("zenith", figure, "Radiance of the zenith over the sun's irradiance: lines by orders of scattering, dots by abbe.")


CAPTION = """Colour of the zenith. Light scattered once by thin air would have the power −4; where air is thick, toward violet, the power falls. The model was
fitted to an atmosphere that holds haze too, the more of it the higher the turbidity: haze scatters all colours more alike. The sun of the model is not
a black body, and its sky is tabulated every 40 nm."""
