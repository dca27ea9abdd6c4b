"""Prints ꟻLIP of two small pictures by its authors' own program (PyPI `flip-evaluator` 1.7), as `src/compare/flip.rs` states them in its test.

The pictures are made by the same formula there.
"""

import numpy as np
from flip_evaluator import evaluate

W, H = 48, 40
y, x = np.mgrid[0:H, 0:W].astype(float)
reference = np.stack([0.5 + 0.45 * np.sin(0.31 * x + 0.17 * y), 0.5 + 0.45 * np.sin(0.23 * x - 0.29 * y + 1), 0.5 + 0.45 * np.sin(0.11 * x * y / 9 + 2)], -1)
test = np.clip(reference + 0.08 * np.sin(1.3 * x + 0.7 * y)[..., None] * np.array([1, -0.5, 0.7]), 0, 1)
test[12:20, 30:38] = [0.9, 0.1, 0.1]

for name, bright in (("LDR", 1.0), ("HDR", 40.0)):
    # High dynamic range: a bright disk in a dark picture.
    glow = 1 + (bright - 1) * np.exp(-((x - 20) ** 2 + (y - 15) ** 2) / 30)[..., None]
    a, b = ((picture * glow).astype(np.float32) for picture in (reference, test))
    for ppd in (67.0206, 20.0):
        image, mean, used = evaluate(a, b, name, inputsRGB=False, applyMagma=False, parameters={"ppd": ppd})
        print(name, ppd, f"mean {mean:.9f}", "pixels", [f"{image[j, i, 0] if image.ndim == 3 else image[j, i]:.7f}" for i, j in ((0, 0), (33, 15), (20, 15), (47, 39))], used)
