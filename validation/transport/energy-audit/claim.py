"""In a closed room all light that is emitted is absorbed or escapes, per wavelength

A room with painted walls, a ball of gold, a ball of absorbing flint glass, a lamp for a ceiling and a slit in one wall: at each wavelength the
emitted power π L A is the sum of what the walls and the lamp's own paint absorb, (1 − ρ) E A with the measured reflectances ρ, of what disappears in
the balls, and of what leaves through the slit.
"""

import csv

import numpy as np
from harness.abbe import ROOT
from harness.claim import Planted
from harness.plots import curves_and_residuals
from transport_common import area, film, integrator, diffuse, scene, shape, spectrum

METHOD = """The irradiance E on each wall, on the ceiling and through the slit is measured by an irradiance meter on it, in 30 bins of 10 nm from 400
to 700 nm. What disappears in a ball, whatever it is made of, is the flux that enters a sphere of no matter around it less the flux that leaves it, by
two more meters, one with its normals turned in. Nothing of this uses what the program says of absorption: the reflectances are read from the table
here, and the balance closes only if scattering, emission, meters and the roulette that ends paths all keep the energy. (That ρ and E both change
within a bin makes less than 10⁻⁴.) Errors are those that the files state; each meter has 256 independent pixels."""
DATA = """Reflectances: BabelColor's average of 30 ColorCheckers (data/reflectance); gold by McPeak et al. (2015); SF11 by SCHOTT's formula, with an
absorption of 0.2 to 1.5 per length."""

LOW, HIGH, BINS = 400, 700, 30
BRIGHTER = "lamp 1 % brighter"
DARKER = "reflectance of the floor 0.04 lower"
PLANTED = [
    Planted(BRIGHTER, ("balance, mean over the bins",)),
    Planted(DARKER, ("balance, mean over the bins",)),
    Planted("Lambert without its cosine", ("balance, each bin",), "dropped_cosine"),
    Planted("light samples by the balance, scattering by the power heuristic", ("balance, mean over the bins",), "transport_mixed_heuristics"),
]
# name -> (paint, transform of a rectangle [−1, 1]², area). The normals look into the room [−1, 1]³.
WALLS = {
    "ceiling": ("white-9.5", '<rotate x="1" angle="90"/><translate y="1"/>', 4.0),
    "floor": ("neutral-6.5", '<rotate x="1" angle="-90"/><translate y="-1"/>', 4.0),
    "left": ("red", '<rotate y="1" angle="90"/><translate x="-1"/>', 4.0),
    "right": ("green", '<rotate y="1" angle="-90"/><translate x="1"/>', 4.0),
    "back": ("white-9.5", '<translate z="-1"/>', 4.0),
    "front": ("blue-sky", '<scale x="1" y="0.75"/><rotate y="1" angle="180"/><translate y="-0.25" z="1"/>', 3.0),
    "slit": (None, '<scale x="1" y="0.25"/><rotate y="1" angle="180"/><translate y="0.75" z="1"/>', 1.0),
}
BALLS = {"gold": (-0.45, -0.55, -0.2, 0.42), "glass": (0.45, -0.5, 0.2, 0.45)}
GAP = 1.01  # of the sphere of no matter around a ball


def reflectances():
    """Paint -> reflectance of wavelength, linear in the table."""
    with open(ROOT / "data/reflectance/colorchecker_babelcolor_average_10nm.csv") as file:
        table = list(csv.reader(line for line in file if not line.startswith("#")))
    columns = {name.split("_(")[0].replace("_", "-"): i for i, name in enumerate(table[0])}
    values = np.array(table[1:], float)
    return {name: (lambda nm, i=i: np.interp(nm, values[:, 0], values[:, i])) for name, i in columns.items()}


def emitted(nm):
    return 0.6 + 0.8 * (nm - LOW) / (HIGH - LOW)


def room(claim, paints, where, kind):
    """A scene file whose meter is on one of the walls, or on the sphere around a ball with its normals out or in."""
    scale = 1.01 if claim.planted == BRIGHTER else 1
    light = area(f"{LOW}:{emitted(LOW) * scale}, {HIGH}:{emitted(HIGH) * scale}")
    meter = f'<sensor type="irradiancemeter">{film(16, 16)}</sensor>'
    parts = []
    for name, (paint, transform, _) in WALLS.items():
        painted = '<bsdf type="null"/>'
        if paint:
            named = f'<string name="name" value="colorchecker/{paint}"/>'
            painted = f'<bsdf type="diffuse"><spectrum name="reflectance" type="measured">{named}</spectrum></bsdf>'
        if name == "floor" and claim.planted == DARKER:
            painted = diffuse(", ".join(f"{nm}:{paints[paint](nm) - 0.04:.6f}" for nm in range(LOW, HIGH + 1, 10)))
        parts.append(shape("rectangle", transform, painted + (light if name == "ceiling" else "") + (meter if name == where else "")))
    gold = '<bsdf type="conductor"><string name="material" value="Au/mcpeak"/></bsdf>'
    glass = f"""<bsdf type="dielectric"><spectrum name="int_ior" type="measured"><string name="name" value="SF11"/></spectrum></bsdf>
        <medium type="homogeneous" name="interior"><float name="albedo" value="0"/>{spectrum("sigma_t", f"{LOW}:0.2, {HIGH}:1.5")}</medium>"""
    for name, content in (("gold", gold), ("glass", glass)):
        x, y, z, radius = BALLS[name]

        def ball(size, inside):
            return f'<shape type="sphere"><point name="center" value="{x} {y} {z}"/><float name="radius" value="{size}"/>{inside}</shape>'

        parts.append(ball(radius, content))
        if where in (name + " in", name + " out"):
            flip = f'<boolean name="flip_normals" value="{str(where.endswith("out")).lower()}"/>'
            parts.append(ball(radius * GAP, flip + '<bsdf type="null"/>' + meter))
    return scene(claim.work / f"{where.replace(' ', '-')}-{kind}.xml", integrator(kind), *parts)


def run(claim):
    paints = reflectances()
    edges = LOW + (HIGH - LOW) * (np.arange(BINS)[:, None] + (np.arange(32) + 0.5) / 32) / BINS
    supply = np.pi * WALLS["ceiling"][2] * emitted(edges).mean(1)
    cases = [("path", 4)] if claim.quick else [("path", 1), ("path", 4), ("path", 8), ("volpath", 4)]
    meters = list(WALLS) + [f"{ball} {way}" for ball in BALLS for way in ("in", "out")]
    balances, rows = [], []
    for number, (kind, count) in enumerate(cases):
        flux = {}
        for i, where in enumerate(meters):
            words = ("--spectral", BINS, "--range", f"{LOW}:{HIGH}", "--wavelengths", count)
            picture = claim.abbe.render(room(claim, paints, where, kind), 512 if claim.quick else 1024, 100 * number + i + 1, words)
            nm, irradiance, error = picture.spectrum()
            size = WALLS[where][2] if where in WALLS else 4 * np.pi * (GAP * BALLS[where.split()[0]][3]) ** 2
            flux[where] = irradiance.mean((0, 1)) * size, np.sqrt((error**2).sum((0, 1))) / irradiance[..., 0].size * size
        takes = {}
        for name, (paint, _, _) in WALLS.items():
            share = 1 - paints[paint](edges).mean(1) if paint else 1
            takes[name] = flux[name][0] * share, flux[name][1] * share
        for ball in BALLS:
            (a, da), (b, db) = flux[ball + " in"], flux[ball + " out"]
            takes[ball] = a - b, np.hypot(da, db)
        total = sum(take for take, _ in takes.values())
        doubt = np.sqrt(sum(error**2 for _, error in takes.values()))
        balances.append((kind, count, total, doubt, takes))
    total, doubt = (np.array([b[i] for b in balances]) for i in (2, 3))
    claim.agrees("balance, each bin: absorbed and escaped over emitted", total / supply, 1, doubt / supply, 1000)
    mean, error = (total / supply).mean(1), np.sqrt(((doubt / supply) ** 2).sum(1)) / BINS
    claim.agrees("balance, mean over the bins", mean, 1, error, 1000)
    found, spread = np.array([b[4]["gold"][0] for b in balances]), np.array([b[4]["gold"][1] for b in balances])
    least = f"least {(found / supply).min():+.1e} of what is emitted"
    claim.holds("gold absorbs in each bin", np.all(found > -5 * spread), least, "not below 0 by 5 errors", f"{5 * (spread / supply).mean():.1e}")
    for (kind, count, *_, takes), share, doubt in zip(balances, mean, error):
        rows.append((kind, count, *(f"{(takes[name][0] / supply).mean():.4f}" for name in takes), f"{share:.5f}", f"{doubt:.1e}"))
    claim.table(("integrator", "C", *balances[0][4], "sum", "standard error"), rows, "Shares of the emitted power, means over the bins.")
    figure, above, below = curves_and_residuals("wavelength (nm)", "share of the emitted power", "balance off (%)", height=5)
    kind, count, total, doubt, takes = next(b for b in balances if b[:2] == ("path", 4))
    labels = {"ceiling": "lamp's paint", "gold": "gold ball", "glass": "glass ball"}
    colours = ["#bbbbbb", "#999999", "#d55e00", "#009e73", "#dddddd", "#56b4e9", "#ffffff", "#e69f00", "#cc79a7"]
    shares = [take / supply for take, _ in takes.values()]
    above.stackplot(nm, shares, labels=[labels.get(name, name) for name in takes], colors=colours, edgecolor="black", lw=0.4)
    above.axhline(1, color="black", lw=0.8)
    above.legend(ncols=9, fontsize=7.5, loc="lower center", bbox_to_anchor=(0.5, 1), handlelength=1, columnspacing=1)
    above.set(ylim=(0, 1.05))
    below.errorbar(nm, (total / supply - 1) * 100, 2 * doubt / supply * 100, fmt="o")
    claim.figure("budget", figure, "Where the light goes (path, C = 4). Below, the sum of all over what is emitted, with two standard errors.")
