#!/usr/bin/env python3
"""Writes tests/problem_file/data/heights.json: what scipy interpolates between random heights.

    scripts/peers/setup
    build/peers/bin/python scripts/peers/height_fixtures.py

Fields: scipy (its version), cell (m), heights (row by row along y), and samples, each with x, y, the
height there and its derivatives along x and y. Cubic convolution is the cubic Hermite spline whose
slopes are central differences, and one-sided differences of second order at the ends.
"""

import json
from pathlib import Path

import numpy as np
import scipy
from scipy.interpolate import CubicHermiteSpline

TARGET = Path(__file__).resolve().parents[2] / "tests" / "problem_file" / "data" / "heights.json"
CELL, ROWS, COLUMNS, SAMPLES = 0.25, 5, 6, 40
RANDOM = np.random.default_rng(3)


def spline(numbers):
    """Along the first axis."""
    slopes = np.gradient(numbers, CELL, axis=0, edge_order=2)
    return CubicHermiteSpline(CELL * np.arange(len(numbers)), numbers, slopes)


def height(heights, x, y, along_x, along_y):
    columns = spline(heights.T)(x, along_x)
    return float(spline(columns)(y, along_y))


def main():
    heights = np.round(RANDOM.uniform(-1, 1, (ROWS, COLUMNS)), 3)
    samples = []
    for _ in range(SAMPLES):
        x, y = np.round(RANDOM.uniform(0, [CELL * (COLUMNS - 1), CELL * (ROWS - 1)]), 4)
        samples.append([float(x), float(y)] +
                       [height(heights, x, y, *order) for order in ((0, 0), (1, 0), (0, 1))])
    TARGET.parent.mkdir(exist_ok=True)
    TARGET.write_text(json.dumps({"scipy": scipy.__version__, "cell": CELL, "heights": heights.tolist(),
                                  "samples": samples}) + "\n")
    print(TARGET.name, TARGET.stat().st_size, "bytes")


if __name__ == "__main__":
    main()
