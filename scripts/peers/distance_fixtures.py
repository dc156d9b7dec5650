#!/usr/bin/env python3
"""Writes tests/spatial/data/distances.json: what coal computes for random pairs of convex bodies.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/distance_fixtures.py

Fields: coal (its version), and pairs, each with the vertices and the radius of two bodies, the placement
of the second in the axes of the first (R row by row, p), m, and their signed distance. Bodies are boxes,
capsules, and hulls of eight random points.
"""

import json
from pathlib import Path

import coal
import numpy as np

TARGET = Path(__file__).resolve().parents[2] / "tests" / "spatial" / "data" / "distances.json"
PAIRS = 120
RANDOM = np.random.default_rng(5)
TOLERANCE, ITERATIONS = 1e-11, 500


def rounded(values, digits=4):
    return np.round(np.asarray(values, dtype=float), digits)


def random_body():
    """A body of coal, its vertices and its radius."""
    kind, size = RANDOM.integers(3), rounded(RANDOM.uniform(0.05, 0.5, 3))
    if kind == 0:
        corners = [[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        return coal.Box(*(2 * size)), corners * size, 0.0
    if kind == 1:
        ends = np.array([[0, 0, -size[1]], [0, 0, size[1]]])
        return coal.Capsule(size[0], 2 * size[1]), ends, size[0]
    points = rounded(RANDOM.uniform(-0.4, 0.4, (8, 3)))
    vertices = coal.StdVec_Vec3s()
    vertices.extend(list(points))
    return coal.Convex.convexHull(vertices, False, ""), points, 0.0


def random_rotation():
    x, y, z, w = (q := RANDOM.normal(size=4)) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def distance(first, second, rotation, place):
    request = coal.DistanceRequest()
    request.enable_signed_distance = True
    request.gjk_tolerance = request.epa_tolerance = TOLERANCE
    request.gjk_max_iterations = request.epa_max_iterations = ITERATIONS
    return coal.distance(first, coal.Transform3s(), second, coal.Transform3s(rotation, place), request,
                         coal.DistanceResult())


def main():
    pairs = []
    while len(pairs) < PAIRS:
        (first, a, radius_a), (second, b, radius_b) = random_body(), random_body()
        if radius_a and radius_b:
            continue  # two capsules: tests/ocp/distance_test.cpp
        rotation, place = random_rotation(), rounded(RANDOM.uniform(-0.8, 0.8, 3))
        pairs.append({"first": a.tolist(), "first_radius": radius_a, "second": b.tolist(),
                      "second_radius": radius_b, "R": rotation.ravel().tolist(), "p": place.tolist(),
                      "distance": distance(first, second, rotation, place)})
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text(json.dumps({"coal": coal.__version__, "pairs": pairs}) + "\n")
    print(TARGET.name, TARGET.stat().st_size, "bytes,", sum(p["distance"] < 0 for p in pairs), "overlap")


if __name__ == "__main__":
    main()
