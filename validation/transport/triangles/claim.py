"""A ball of 80, 320 and 1280 triangles lacks 7.7, 2.0 and 0.5 % of the silhouette of the sphere that it stands for

A book of 1995 asks for at least a thousand triangles for a sphere. abbe has the sphere itself; against it, the silhouette of a subdivided icosahedron
whose corners lie on the sphere lacks what a projection of its hull on paper lacks, and a quarter of that with each subdivision.
"""

import numpy as np
from harness.claim import Planted
from scipy.spatial import ConvexHull
from transport_common import film, integrator, scene, spectrum

METHOD = """A black ball before a uniform sky, seen orthographically: what is missing of the picture's radiance is the area of the silhouette. That of a
convex body is the area of the hull of its projected corners, which the claim computes itself; the sphere's is πr². Errors are those that the file
states."""
DATA = "G. Wyvill, Practical Ray Tracing, part 2 (1995), section 10.2. Corners are rounded to nine digits."

SMALLER = "the ball smaller by 0.2 %"
PLANTED = [Planted(SMALLER, ("the silhouette of 20", "the sphere's own silhouette"))]
SIZE, VIEW = 96, 1.05
BLACK = f'<bsdf type="diffuse">{spectrum("reflectance", 0)}</bsdf>'


def icosahedron():
    """Corners of its 20 faces."""
    phi = (1 + 5**0.5) / 2
    points = np.array([p for a in (-1, 1) for b in (-phi, phi) for p in ((0, a, b), (b, 0, a), (a, b, 0))])
    hull = ConvexHull(points)
    # A turn, so that no symmetry of the body is one of the picture.
    turn, _ = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))
    faces = points[hull.simplices] @ turn
    outward = np.einsum("ij,ij->i", np.cross(faces[:, 1] - faces[:, 0], faces[:, 2] - faces[:, 0]), faces.sum(1)) < 0
    faces[outward] = faces[outward][:, ::-1]
    return faces / np.linalg.norm(faces, axis=2, keepdims=True)


def subdivided(faces):
    a, b, c = faces[:, 0], faces[:, 1], faces[:, 2]
    middles = [m / np.linalg.norm(m, axis=1, keepdims=True) for m in (a + b, b + c, c + a)]
    ab, bc, ca = middles
    return np.concatenate([np.stack(t, 1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])


def silhouette(claim, shape, spp):
    """Area of what hides the sky, and its standard error."""
    view = f'<scale value="{VIEW}"/><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/>'
    camera = f'<sensor type="orthographic"><transform name="to_world">{view}</transform>{film(SIZE, SIZE)}</sensor>'
    sky = f'<emitter type="constant">{spectrum("radiance", 1)}</emitter>'
    file = scene(claim.work / "ball.xml", integrator("path", 2), camera, sky, shape)
    _, radiance, errors = claim.abbe.render(file, spp, 3, ("--spectral", 1, "--range", "555:556")).spectrum()
    whole = (2 * VIEW) ** 2
    return whole * (1 - radiance.mean()), whole * np.sqrt(np.sum(errors**2)) / errors.size


def run(claim):
    radius = 0.998 if claim.planted == SMALLER else 1.0
    spp = 64 if claim.quick else 1024
    sphere = f'<shape type="sphere"><float name="radius" value="{radius}"/>{BLACK}</shape>'
    found, error = silhouette(claim, sphere, spp)
    claim.agrees("the sphere's own silhouette is πr²", found, np.pi, error)
    faces, rows, lacks = icosahedron(), [], []
    for _ in range(1 if claim.planted else 5):
        written = "".join(f"v {x:.9f} {y:.9f} {z:.9f}\n" for x, y, z in radius * faces.reshape(-1, 3))
        (claim.work / "ball.obj").write_text(written + "".join(f"f {3 * i + 1} {3 * i + 2} {3 * i + 3}\n" for i in range(len(faces))))
        ball = f'<shape type="obj"><string name="filename" value="{claim.work / "ball.obj"}"/>{BLACK}</shape>'
        found, error = silhouette(claim, ball, spp)
        exact = ConvexHull(faces.reshape(-1, 3)[:, :2]).volume
        claim.agrees(f"the silhouette of {len(faces)} triangles is its hull's", found, exact, error)
        lacks.append(1 - exact / np.pi)
        rows.append((len(faces), f"{exact / np.pi - 1:+.2%}", f"{found / np.pi - 1:+.2%} ± {error / np.pi:.2%}"))
        faces = subdivided(faces)
    if claim.planted:
        return
    claim.bounded("each subdivision leaves a quarter of it, relative", [4 * b / a - 1 for a, b in zip(lacks[1:], lacks[2:])], 0.1)
    claim.table(("triangles", "hull on paper", "picture"), rows, "Area of the silhouette of a ball of triangles against the sphere's.")
