"""What the claims on light transport share: statistics of pixels that have one expectation, and pieces of scenes."""

import numpy as np

from harness.quadrature import over_bins


def over(values):
    """Mean over the first axis, its standard error by the spread, and the degrees of freedom. The values are independent and have one expectation."""
    values = np.asarray(values)
    return values.mean(0), values.std(0, ddof=1) / np.sqrt(len(values)), len(values) - 1


def pooled(means, errors):
    """The plain mean over the first axis of independent means, and its standard error. Weights by estimated errors would bias it."""
    return np.mean(means, 0), np.sqrt(np.sum(np.square(errors), 0)) / len(means)


def bin_means(function, count, low=360.0, high=830.0):
    """Means of a function of wavelength (nm) over equal bins."""
    centres = low + (high - low) / count * (np.arange(count) + 0.5)
    return over_bins(centres, lambda nm: np.broadcast_to(function(nm), nm.shape))


def scene(path, *parts):
    """Writes a scene file of these elements and returns its path."""
    path.write_text('<scene version="3.0.0">\n' + "\n".join(parts) + "\n</scene>\n")
    return path


def film(width, height, more=""):
    """A film whose pixels are averages over their squares."""
    return (
        f'<film type="hdrfilm"><integer name="width" value="{width}"/><integer name="height" value="{height}"/>'
        f'<string name="pixel_format" value="luminance"/><rfilter type="box"/>{more}</film>'
    )


def integrator(kind, depth=None):
    """An integrator; `depth` is the most segments of a path."""
    limit = "" if depth is None else f'<integer name="max_depth" value="{depth}"/>'
    return f'<integrator type="{kind}">{limit}</integrator>'


def spectrum(name, value):
    return f'<spectrum name="{name}" value="{value}"/>'


def diffuse(reflectance):
    """`reflectance`: a number or a list of wavelengths and values."""
    return f'<bsdf type="diffuse">{spectrum("reflectance", reflectance)}</bsdf>'


def area(radiance):
    return f'<emitter type="area">{spectrum("radiance", radiance)}</emitter>'


def shape(kind, transform, content="", words=""):
    """A shape under the elements of a transform, in the order in which they are applied."""
    return f'<shape type="{kind}"{words}><transform name="to_world">{transform}</transform>{content}</shape>'


def lamp_facing_down(kind, scale, height, radiance=1):
    """A rectangle or disk that emits downwards."""
    return shape(kind, f'<scale {scale}/><rotate x="1" angle="180"/><translate z="{height}"/>', area(radiance) + diffuse(0))


# A floor z = 0 of this reflectance that reaches far, and the view of a part of it that lamps at x = 0 do not hide: rays come down along (−1, 0, −1).
REFLECTANCE = 0.6
FLOOR = shape("rectangle", '<scale value="200"/>', diffuse(REFLECTANCE))


def floor_camera(centre, half, width, height):
    """Orthographic: x from centre − half to centre + half from left to right, square pixels around y = 0."""
    return f"""<sensor type="orthographic"><transform name="to_world"><scale x="{half}" y="{half}"/>
        <matrix value="-1 0 -1 {centre + 20}  0 1 0 0  0 0 -1 20  0 0 0 1"/></transform>{film(width, height)}</sensor>"""


def floor_pixels(centre, half, width, height, nodes=3):
    """Places x, y (height × width × nodes²) in each pixel and their weights, by Gauss and Legendre's rule; column 0 is the smallest x."""
    at, weight = np.polynomial.legendre.leggauss(nodes)
    pixel = 2 * half / width
    x = centre - half + pixel * (np.arange(width)[:, None] + 0.5 + at / 2)
    y = pixel * (height / 2 - np.arange(height)[:, None] - 0.5 + at / 2)
    weights = np.outer(weight, weight).ravel() / 4
    x, y = np.broadcast_arrays(x[None, :, None, :], y[:, None, :, None])
    return x.reshape(height, width, -1), y.reshape(height, width, -1), weights


def gray(claim, file, spp, seed, *words):
    """Radiance (height × width) of a scene in which nothing depends on wavelength: of one nanometre, in which wavelengths bring no noise."""
    _, radiance, _ = claim.abbe.render(file, spp, seed, ("--spectral", 1, "--range", "555:556", *words)).spectrum()
    return radiance[..., 0]


def profile(measured, expected, columns):
    """Measured over expected of groups of `columns` columns of pixels: mean, standard error and degrees of freedom."""
    height, width = measured.shape
    ratio = (measured / expected).reshape(height, width // columns, columns)
    return over(ratio.transpose(0, 2, 1).reshape(-1, width // columns))
