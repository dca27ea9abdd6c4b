"""Writes brilliant.ply: the round brilliant cut, 57 facets and a polished girdle, of radius 1 with its crown towards +z.

    python make_gem.py

A stone is what all its facets' half-spaces have in common. Each facet is a plane; the corners are where three planes meet within all others.
The proportions are near those that Tolkowsky computed for diamond (Diamond Design, 1919).
"""

from itertools import combinations
from math import atan2, cos, degrees, pi, radians, sin, tan
from pathlib import Path

CROWN, PAVILION = radians(34.5), radians(40.75)  # angles of the main facets to the girdle's plane
TABLE = 0.56  # radius of the table's corners
GIRDLE = 0.025  # half of the girdle's thickness where the main facets meet it
STAR, LOWER = 0.5, 0.78  # lengths of the star facets and of the lower halves, as fractions of the way in
ROUND = 96  # sides of the girdle
EIGHTH, SIXTEENTH = pi / 8, pi / 16


def tilted(azimuth, angle, x):
    """The half-space n·p ≤ d of a facet that leans by `angle` and passes through the point x of its own azimuth: (r, z)."""
    n = (sin(angle) * cos(azimuth), sin(angle) * sin(azimuth), cos(angle))
    return (*n, sin(angle) * x[0] + cos(angle) * x[1])


def facets():
    top = GIRDLE + (1 - TABLE) * tan(CROWN)
    planes = [(0.0, 0.0, 1.0, top)]
    # Where the star facets end, between two main facets.
    edge = TABLE * cos(EIGHTH)
    end = edge + STAR * (1 - edge)
    height = GIRDLE + (1 - end * cos(EIGHTH)) * tan(CROWN)
    star = atan2(top - height, end - edge)
    upper = atan2((1 - end * cos(EIGHTH)) * tan(CROWN), (1 - end) * cos(SIXTEENTH))
    inner = 1 - LOWER
    lower = atan2((1 - inner * cos(EIGHTH)) * tan(PAVILION), (1 - inner) * cos(SIXTEENTH))
    for k in range(8):
        planes.append(tilted(k * 2 * EIGHTH, CROWN, (1, GIRDLE)))
        planes.append(tilted((2 * k + 1) * EIGHTH, star, (edge, top)))
        planes.append(tilted(k * 2 * EIGHTH, pi - PAVILION, (1, -GIRDLE)))
    for k in range(16):
        azimuth = (2 * k + 1) * SIXTEENTH
        planes.append(tilted(azimuth, upper, (cos(SIXTEENTH), GIRDLE)))
        planes.append(tilted(azimuth, pi - lower, (cos(SIXTEENTH), -GIRDLE)))
    for k in range(ROUND):
        azimuth = (2 * k + 1) * pi / ROUND
        planes.append((cos(azimuth), sin(azimuth), 0.0, cos(pi / ROUND)))
    print(f"star facets {degrees(star):.1f}°, upper halves {degrees(upper):.1f}°, lower halves {degrees(lower):.1f}°")
    print(f"from table to culet {top + GIRDLE + tan(PAVILION):.4f}")
    print(f"from the girdle's plane to the facet below it {(GIRDLE + tan(PAVILION)) * cos(PAVILION):.4f}")
    return planes


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def corners(planes):
    """The corners, each once, and for each plane those on it."""
    found, on = [], [set() for _ in planes]
    for (i, a), (j, b), (k, c) in combinations(enumerate(planes), 3):
        determinant = dot(a[:3], cross(b[:3], c[:3]))
        if abs(determinant) < 1e-9:
            continue
        sides = cross(b[:3], c[:3]), cross(c[:3], a[:3]), cross(a[:3], b[:3])
        point = tuple(sum(p[3] * s[axis] for p, s in zip((a, b, c), sides)) / determinant for axis in range(3))
        if any(dot(p[:3], point) > p[3] + 1e-9 for p in planes):
            continue
        index = next((n for n, other in enumerate(found) if max(abs(x - y) for x, y in zip(point, other)) < 1e-7), len(found))
        if index == len(found):
            found.append(point)
        for plane in (i, j, k):
            on[plane].add(index)
    return found, on


def polygon(plane, indices, points):
    """The corners of a facet, counter-clockwise as seen from outside."""
    n = plane[:3]
    centre = [sum(points[i][axis] for i in indices) / len(indices) for axis in range(3)]
    u = cross(n, (0.0, 0.0, 1.0)) if abs(n[2]) < 0.9 else cross(n, (1.0, 0.0, 0.0))
    v = cross(n, u)

    def angle(i):
        from_centre = tuple(a - b for a, b in zip(points[i], centre))
        return atan2(dot(from_centre, v), dot(from_centre, u))

    return sorted(indices, key=angle)


def main():
    planes = facets()
    points, on = corners(planes)
    faces = [polygon(plane, indices, points) for plane, indices in zip(planes, on) if len(indices) > 2]
    edges = sum(len(face) for face in faces) // 2
    assert len(points) - edges + len(faces) == 2, "the solid is not closed"
    print(f"{len(points)} corners, {edges} edges, {len(faces)} facets")
    lines = ["ply", "format ascii 1.0", f"element vertex {len(points)}", *(f"property float {axis}" for axis in "xyz")]
    lines += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join(f"{round(x, 9) + 0.0:.9g}" for x in point) for point in points]
    lines += [" ".join(map(str, (len(face), *face))) for face in faces]
    (Path(__file__).parent / "brilliant.ply").write_text("\n".join(lines) + "\n")


main()
