"""What the optics claims share: Fresnel's equations in the textbook form, glasses by their coefficients, renders repeated with other seeds."""

import csv
import math
import zlib
from functools import cache

import mpmath
import numpy as np

from harness.abbe import ROOT
from harness.quadrature import over_bins

# Fraunhofer's lines, nm, as SCHOTT's catalogue lists them.
LINES = {
    "h": 404.6561,
    "g": 435.8343,
    "F'": 479.9914,
    "F": 486.1327,
    "e": 546.0740,
    "d": 587.5618,
    "D": 589.2938,
    "C'": 643.8469,
    "C": 656.2725,
    "r": 706.5188,
}

# SCHOTT N-SF10, Sellmeier's equation (SCHOTT catalogue; λ in µm): not in abbe's catalogue, so scenes give the coefficients.
N_SF10 = ("1.62153902, 0.256287842, 1.64447552", "0.0122241457, 0.0595736775, 147.468793")


def fresnel(cosine, eta):
    """Reflectances (s, p) of a dielectric, eta = far index / near index (Born and Wolf, section 1.5.2); 1 beyond the critical angle."""
    cosine, eta = np.broadcast_arrays(np.asarray(cosine, float), np.asarray(eta, float))
    squared = eta**2 - 1 + cosine**2
    g = np.sqrt(np.maximum(squared, 0))
    s = ((cosine - g) / (cosine + g)) ** 2
    p = ((eta**2 * cosine - g) / (eta**2 * cosine + g)) ** 2
    return np.where(squared > 0, s, 1.0), np.where(squared > 0, p, 1.0)


def metal(cosine, n, k):
    """Unpolarised reflectance of n + ik (Born and Wolf, section 14.2)."""
    m2 = (n + 1j * k) ** 2
    q = np.sqrt(m2 - 1 + cosine**2)
    rs, rp = (cosine - q) / (cosine + q), (m2 * cosine - q) / (m2 * cosine + q)
    return 0.5 * (np.abs(rs) ** 2 + np.abs(rp) ** 2)


@cache
def formulas():
    """Rows of data/dielectrics/dispersion_formulas.csv by name."""
    lines = (ROOT / "data/dielectrics/dispersion_formulas.csv").read_text().splitlines()
    return {row["name"]: row for row in csv.DictReader(line for line in lines if not line.startswith("#"))}


def exact_index(formula, c, nm):
    """Index by the numbered formula of the refractiveindex.info database, in mpmath. `c` are the coefficients for λ in µm."""
    um, c = mpmath.mpf(nm) / 1000, [mpmath.mpf(text) for text in c] + [mpmath.mpf(0)] * 20
    pairs = lambda first: ((c[i], c[i + 1]) for i in range(first, len(c) - 1, 2) if c[i] != 0)
    if formula == 1:
        return mpmath.sqrt(1 + c[0] + sum(b * um**2 / (um**2 - q**2) for b, q in pairs(1)))
    if formula == 2:
        return mpmath.sqrt(1 + c[0] + sum(b * um**2 / (um**2 - q) for b, q in pairs(1)))
    if formula == 3:
        return mpmath.sqrt(c[0] + sum(b * um**q for b, q in pairs(1)))
    if formula == 4:
        poles = sum(c[i] * um ** c[i + 1] / (um**2 - c[i + 2] ** c[i + 3]) for i in (1, 5) if c[i] != 0)
        return mpmath.sqrt(c[0] + poles + sum(b * um**q for b, q in pairs(9)))
    if formula == 5:
        return c[0] + sum(b * um**q for b, q in pairs(1))
    return 1 + c[0] + sum(b / (q - um**-2) for b, q in pairs(1))


def sellmeier(b, c, nm):
    """n of n² = 1 + Σ b λ²/(λ² − c), λ in µm; b and c as the scene file writes them."""
    squared = (np.asarray(nm, float) * 1e-3) ** 2
    return np.sqrt(1 + sum(float(x) * squared / (squared - float(y)) for x, y in zip(b.split(","), c.split(","))))


def glass(name, nm):
    """n of a glass of the table of formulas that has formula 1 or 2, in double precision."""
    row = formulas()[name]
    c = [float(text) for text in row["coefficients_um"].split()]
    power = 2 if row["formula"] == "1" else 1
    squared = (np.asarray(nm, float) * 1e-3) ** 2
    return np.sqrt(1 + c[0] + sum(b * squared / (squared - q**power) for b, q in zip(c[1::2], c[2::2])))


def repeat(claim, scene, spp, seeds, read, options=(), defines=None):
    """`read(picture)` for each of `seeds` renders: mean and standard error of the mean from their spread. No two settings share seeds, so errors
    are independent."""
    first = zlib.crc32(repr((scene.name, options, defines)).encode()) >> 1
    values = np.array([read(claim.abbe.render(scene, spp, first + i, options, defines)) for i in range(seeds)])
    return values.mean(0), values.std(0, ddof=1) / math.sqrt(seeds)


def moderated(error, seeds, reach=5):
    """Errors of rows by so many seeds, with their degrees of freedom: each variance at least the mean of those of the `reach` rows on either side
    (last axis). A few renders tell a variance badly, and stratified samples that count reflections may agree by chance to the last one; rows that lie
    together have much the same, but for one that grazes the surface: it varies more than they, and has its own. Degrees of freedom grow by at least
    `reach` where a variance is not more than twice that mean: by chance few are."""
    window = np.ones(2 * reach + 1)
    mean = lambda row: np.convolve(row, window, "same") / np.convolve(np.ones_like(row), window, "same")
    variance = np.asarray(error) ** 2
    common = np.apply_along_axis(mean, -1, variance)
    return np.sqrt(np.maximum(variance, common)), np.where(variance > 2 * common, 1, reach) * (seeds - 1)


def measured(name):
    return f'<spectrum name="int_ior" type="measured"><string name="name" value="{name}"/></spectrum><float name="ext_ior" value="1"/>'


FLOOR = """<!-- A smooth floor under a sky of radiance 1, above a black one: what is seen is the reflectance, row by row another angle -->
<scene version="3.0.0">
    <default name="target" value="1, 0, 0"/><default name="fov" value="90"/><default name="rows" value="180"/>
    <integrator type="path"/>
    <sensor type="perspective">
        <string name="fov_axis" value="y"/><float name="fov" value="$fov"/>
        <transform name="to_world"><lookat origin="0, 0, 1" target="$target" up="0, 0, 1"/></transform>
        <film type="hdrfilm">
            <integer name="width" value="1"/><integer name="height" value="$rows"/><rfilter type="box"/>
        </film>
    </sensor>
    <shape type="rectangle"><transform name="to_world"><scale x="1000000" y="1000000" z="1"/></transform>BSDF</shape>
    <shape type="rectangle">
        <transform name="to_world"><scale x="2000000" y="2000000" z="1"/><translate z="-0.01"/></transform>
        <bsdf type="diffuse"><spectrum name="reflectance" value="0"/></bsdf>
    </shape>
    <emitter type="constant"><spectrum name="radiance" value="1"/></emitter>
</scene>
"""


def write(claim, name, text):
    path = claim.work / f"{name}.xml"
    path.write_text(text)
    return path


def floor_cosines(rows, fov=90.0, aim=45.0):
    """Cosines of incidence in the floor's picture: rows × nodes, and the nodes' weights. `aim` is the angle of incidence in its middle, degrees."""
    x, w = np.polynomial.legendre.leggauss(6)
    half = math.tan(math.radians(fov) / 2)
    s = half * (1 - (2 * np.arange(rows)[:, None, None] + 1 - x[None, :, None]) / rows)
    across = half / rows * x[None, None, :]
    a = math.radians(aim)
    cosine = (math.cos(a) - s * math.sin(a)) / np.sqrt(1 + s**2 + across**2)
    return cosine.reshape(rows, -1), np.outer(w, w).ravel() / 4


def floor_picture(reflectance, centres, rows, **view):
    """Expected picture of the floor, rows × bins: `reflectance(cosine, nm)` over pixels and bins."""
    cosine, weights = floor_cosines(rows, **view)
    return over_bins(centres, lambda nm: np.einsum("rqb,q->rb", reflectance(cosine[:, :, None], nm[None, None, :]), weights), 5)
