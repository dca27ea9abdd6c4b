"""Where abbe and Mitsuba disagree, a third witness decides

abbe has the value of a closed form where Mitsuba has another. Each case is a scene so small that its picture can be written down. The table lists all disagreements that were
found, whoever was wrong, with the witness of each.
"""

import sys
from dataclasses import dataclass

import numpy as np

import compare
from compare import HERE
from harness.abbe import ROOT
from harness.claim import ROUNDING, Planted

sys.path.append(str(ROOT / "scenes"))
import grids

METHOD = """The same file is rendered by both programs with 16 seeds, seen by a film that integrates the radiance L from 500 to 600 nm. abbe must agree with the witness by Student's t-test;
Mitsuba must differ by more than 5 standard errors and 0.5 %, so that a disagreement which a later Mitsuba mends is noticed. The formulas: the balance of energy under a sky of
radiance 1 (a surface that reflects the share ρ has L = ρ); L = ρ I / (π r²) of a diffuse surface under a lamp of intensity I; T = (1 − R)² e^(−τ) / (1 − R² e^(−2τ)) of an
absorbing slab with R = ((n − 1)/(n + 1))² (Fresnel, Beer and Lambert); E = π under that sky; the area of an ellipse.

For `ldsampler` the witness is Mitsuba's own `multijitter`, with the same file otherwise, in the tile where the pictures parted."""
DATA = """`DISAGREEMENTS.md` beside the scenes, made from the experiments of `FACTS.md`. The witness that is judged is Mitsuba 3.9.1, `llvm_ad_spectral`."""

THIN = "the blend's weight 0.505 for 0.5"
PLANTED = [Planted(THIN, ("abbe: blendbsdf",))]


@dataclass(frozen=True)
class Case:
    what: str
    fact: int  # in FACTS.md; 0 for what stands in docs/differences-from-mitsuba.md alone
    formula: str
    expected: float  # mean radiance of the picture, W·m⁻²·sr⁻¹·nm⁻¹
    body: str
    sensor: str = "radiancemeter"
    integrator: str = '<integrator type="path"/>'
    film: int = 1
    spp: int = 16384


def towards(origin, target):
    direction = ", ".join(str(b - a) for a, b in zip(origin, target))
    return f'<point name="origin" value="{", ".join(map(str, origin))}"/><vector name="direction" value="{direction}"/>'


SKY = '<emitter type="constant"><spectrum name="radiance" value="1"/></emitter>'
PLANE = '<shape type="rectangle"><transform name="to_world"><scale value="50"/></transform>{}</shape>'
DIFFUSE = '<bsdf type="diffuse"><spectrum name="reflectance" value="0.5"/></bsdf>'
LAMP = '<shape type="rectangle"><transform name="to_world"><scale value="{}"/><lookat origin="{}" target="{}" up="0, 1, 0"/></transform><emitter type="area"><spectrum name="radiance" value="{}"/></emitter></shape>'


GRID = compare.KEPT / "settled/plane.vol"


def write_grid():
    """z - 1/2 on 4×2×2 points of the unit cube."""
    grids.write(GRID, np.repeat([-0.5, 0.5], 8).reshape(2, 2, 4))


FLAKES = HERE / "scenes/volumes/flakes_skewed.vol"
REFLECTED = (0.5 / 2.5) ** 2
CASES = [
    Case(
        "blendbsdf of a mirror and a diffuse surface",
        66,
        "L = (0.5 + 1)/2 under a sky of 1",
        0.75,
        SKY + PLANE.format(f'<bsdf type="blendbsdf"><float name="weight" value="0.5"/>{DIFFUSE}<bsdf type="conductor"/></bsdf>'),
        towards((0.3, 0, 0.954), (0, 0, 0)),
        spp=262144,
    ),
    Case(
        "mask of opacity 0.4 under `path`",
        66,
        "L = 0.4 · ρ I/(π r²), ρ 0.5, r 2",
        0.4 * 0.5 / (np.pi * 4),
        '<emitter type="point"><point name="position" x="0" y="0" z="2"/><spectrum name="intensity" value="1"/></emitter>'
        + PLANE.format(f'<bsdf type="mask"><float name="opacity" value="0.4"/>{DIFFUSE}</bsdf>'),
        towards((1, 0, 1), (0, 0, 0)),
    ),
    Case(
        "absorbing slab under `path`",
        41,
        "T of τ = 1, n = 1.5",
        (1 - REFLECTED) ** 2 * np.exp(-1) / (1 - REFLECTED**2 * np.exp(-2)),
        LAMP.format(50, "0, 0, -3", "0, 0, 0", 1)
        + '<shape type="cube"><transform name="to_world"><scale x="20" y="20" z="0.5"/></transform><bsdf type="dielectric"><float name="int_ior" value="1.5"/>'
        '<float name="ext_ior" value="1"/></bsdf><medium name="interior" type="homogeneous"><float name="sigma_t" value="1"/><float name="albedo" value="0"/></medium></shape>',
        towards((0, 0, 4), (0, 0, 0)),
    ),
    Case(
        "irradiance meter on a sphere that is turned",
        72,
        "E = π under a sky of 1",
        np.pi,
        SKY,
        "irradiancemeter",
        spp=65536,
    ),
    Case(
        "sphere stretched to an ellipsoid",
        0,
        "π a b/4 of a picture of 2 × 2, a 0.9, b 0.45",
        np.pi * 0.9 * 0.45 / 4,
        '<shape type="sphere"><transform name="to_world"><scale x="0.9" y="0.45" z="0.3"/></transform><emitter type="area"><spectrum name="radiance" value="1"/></emitter></shape>',
        '<transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform>',
        film=16,
        spp=256,
    ),
    Case(
        "sdfgrid of 4×2×2 points",
        89,
        "a plane of it, z = 1/2: L = ρ 0.5 under a sky of 1",
        0.5,
        f'<shape type="sdfgrid"><string name="filename" value="{GRID}"/>{DIFFUSE}</shape>' + SKY,
        '<transform name="to_world"><scale x="0.45" y="0.45"/><lookat origin="0.5, 0.5, 5" target="0.5, 0.5, 0" up="0, 1, 0"/></transform>',
        film=16,
        spp=256,
    ),
    Case(
        "ball of white flakes, `sggx`",
        96,
        "what absorbs nothing has L = 1 under a sky of 1",
        1,
        '<shape type="sphere"><bsdf type="null"/><medium name="interior" type="homogeneous"><spectrum name="sigma_t" value="1"/><spectrum name="albedo" value="1"/>'
        f'<phase type="sggx"><volume name="S" type="gridvolume"><string name="filename" value="{FLAKES}"/><boolean name="raw" value="true"/></volume></phase></medium></shape>' + SKY,
        towards((1, -2, -3), (0, 0, 0)),
        '<integrator type="volpath"/>',
    ),
]


def document(case):
    """The scene of a case. Its film integrates over 100 nm with the response 0.01."""
    film = (
        f'<film type="specfilm"><integer name="width" value="{case.film}"/><integer name="height" value="{case.film}"/><string name="component_format" value="float32"/>'
        '<spectrum name="band" type="regular"><float name="wavelength_min" value="500"/><float name="wavelength_max" value="600"/>'
        '<string name="values" value="0.01, 0.01, 0.01, 0.01, 0.01, 0.01"/></spectrum><rfilter type="box"/></film>'
    )
    inside = film + '<sampler type="independent"/>'
    if case.sensor == "irradiancemeter":
        sensor = f'<shape type="sphere"><transform name="to_world"><rotate x="1" angle="90"/></transform><bsdf type="diffuse"/><sensor type="irradiancemeter">{inside}</sensor></shape>'
    else:
        kind = "orthographic" if "lookat" in case.sensor else "radiancemeter"
        sensor = f'<sensor type="{kind}">{case.sensor}{inside}</sensor>'
    return f'<scene version="3.0.0">{case.integrator}{sensor}{case.body}</scene>'


TILE = (slice(8, 16), slice(24, 32))  # rows, columns


def low_discrepancy(claim, mitsuba, abbe):
    """The tile of `direct_emitters` that is too dark with Mitsuba's ldsampler: with it, with multijitter, and in abbe."""
    scene = HERE / "scenes/direct_emitters.xml"
    text = scene.read_text()
    start, end = text.index("<sampler"), text.index("</sampler>")
    found = []
    for sampler in ("ldsampler", "multijitter"):
        file = compare.KEPT / f"settled/direct-{sampler}.xml"
        file.write_text(text[:start] + f'<sampler type="{sampler}"><integer name="sample_count" value="256"/>' + text[end:])
        found.append(mitsuba.stack(file, 256, range(7001, 7033)))
    found.append(abbe.stack(scene, 256, range(8001, 8033), found[0].names))
    level = [s.pictures[(slice(None), *TILE)].astype(float)[..., 1].mean((1, 2)) for s in found]
    (low, a), (witness, b), (ours, c) = [(v.mean(), v.std(ddof=1) / np.sqrt(len(v))) for v in level]
    claim.agrees("abbe: ldsampler, a tile under two lamps, Mitsuba's multijitter", ours, witness, c, 31, expected_error=b)
    differs = abs(low - witness) > 5 * np.hypot(a, b)
    claim.holds("Mitsuba: ldsampler is otherwise", differs, f"{low:.5g} ± {a:.1g}, {low / witness - 1:+.1%}", "more than 5 standard errors", "")
    return "ldsampler, a tile under two lamps", "Mitsuba's multijitter", f"{witness:.5g} ± {b:.1g}", f"{ours:.5g} ± {c:.1g}", f"{low:.5g} ± {a:.1g}", 82


def run(claim):
    mitsuba, abbe = compare.Mitsuba(), compare.Abbe(claim.abbe)
    rows = []
    folder = compare.KEPT / "settled"
    folder.mkdir(parents=True, exist_ok=True)
    write_grid()
    for number, case in enumerate(CASES[:1] if claim.planted else CASES):
        file, wrong = folder / f"case-{number}.xml", claim.work / f"case-{number}.xml"
        file.write_text(document(case))
        wrong.write_text(document(case).replace('"weight" value="0.5"', f'"weight" value="{0.505 if claim.planted else 0.5}"'))
        seeds = range(1, 17)
        of = lambda stack: (lambda m: (m.mean(), m.std(ddof=1) / np.sqrt(len(m))))(stack.pictures.astype(float).mean((1, 2, 3)))
        (ours, error), (theirs, their_error) = of(abbe.stack(wrong, case.spp, seeds, ("band",))), of(mitsuba.stack(file, case.spp, seeds))
        claim.agrees(f"abbe: {case.what}, {case.formula}", ours, case.expected, error, len(seeds) - 1)
        off = theirs / case.expected - 1
        differs = abs(theirs - case.expected) > 5 * max(their_error, ROUNDING * case.expected) and abs(off) > 0.005
        claim.holds(f"Mitsuba: {case.what} is otherwise", differs, f"{theirs:.5g} ± {their_error:.1g}, {off:+.1%}", "more than 0.5 %", "")
        rows.append((case.what, case.formula, f"{case.expected:.6g}", f"{ours:.6g} ± {error:.1g}", f"{theirs:.6g} ± {their_error:.1g}", case.fact or ""))
    if claim.planted is None:
        rows.append(low_discrepancy(claim, mitsuba, abbe))
        claim.table(("", "witness", "value", "abbe", "Mitsuba", "FACTS.md"), rows, "The disagreements that are cheap to settle, rendered again.")
        lines = [[cell.strip() for cell in line.strip("| \n").split(" | ")] for line in (HERE / "DISAGREEMENTS.md").read_text().splitlines() if line.startswith("| ")]
        claim.table(lines[0], lines[1:], "All disagreements found, from DISAGREEMENTS.md.")
