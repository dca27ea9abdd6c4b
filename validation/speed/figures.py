"""How good a picture is, and what that cost."""

import hashlib
from dataclasses import dataclass

import numpy as np

from speed import assets
from speed.programs import WORK

LEFT_OUT = 0.001  # share of the pixels that a trimmed error leaves out, the worst


def relative_errors(squares, reference):
    """Squared errors of the pixels, relative to the square of the reference; black ones count as if they had a tenth of the mean."""
    return squares / (reference**2 + 0.01 * reference.mean() ** 2)


def mean(errors, trimmed):
    """relMSE of a picture: the mean of its relative squared errors. Trimmed: without the worst pixels, where single bright samples decide."""
    errors = np.sort(errors, axis=None)
    return errors[: errors.size - round(LEFT_OUT * errors.size)].mean() if trimmed else errors.mean()


def errors_by_spread(stacks, trimmed):
    """relMSE of a render of each program, by how far some renders are from the mean of all.

    In that mean the programs are weighed by how sure they are, so that single bright pixels of one are not in what it is judged by. A render is a part
    of the mean: with weight w a program's n renders differ from it by the fraction 1 − 2w/n + w²/n of their variance, and by w²/n of the others'."""
    renders = [len(stack) for stack in stacks]
    weights = np.array([1 / np.var(stack, 0, ddof=1).mean() for stack in stacks])
    weights /= weights.sum()
    centre = np.average([np.mean(stack, 0) for stack in stacks], axis=0, weights=weights)
    found = [np.mean([mean(relative_errors((picture - centre) ** 2, centre), trimmed) for picture in stack]) for stack in stacks]
    parts = np.tile(weights**2 / renders, (len(stacks), 1))
    return np.linalg.solve(parts + np.diag(1 - 2 * weights / renders), found)


def blurred(picture):
    """Means of 4×4 pixels."""
    height, width = picture.shape
    return picture.reshape(height // 4, 4, width // 4, 4).mean((1, 3))


@dataclass
class Reference:
    """Y of each pixel from long renders of both programs, weighed by how sure each is."""

    y: np.ndarray
    error: float  # its own relMSE, which a picture that it judges has on top of its own
    share: float  # of abbe's render in it
    difference: float  # of the mean of the whole picture: abbe's over Mitsuba's, less 1
    sigma: float  # the same in standard errors

    def error_of(self, picture, trimmed):
        """relMSE of Y of a picture, less what the reference itself contributes."""
        return mean(relative_errors((picture[..., 1] - self.y) ** 2, self.y), trimmed) - self.error


def reference(scene, programs, chunks):
    """The reference of a scene, kept on disk. `chunks`: the samples per pixel of each of a program's renders, by its name."""
    kept = WORK / "references"
    kept.mkdir(parents=True, exist_ok=True)
    stacks = [stack(scene, program, chunks[program.name], kept) for program in programs]
    means = [s.mean(0) for s in stacks]
    variances = [s.var(0, ddof=1) / len(s) for s in stacks]
    rough = sum(means) / 2
    ours, theirs = (mean(relative_errors(v, rough), scene.trimmed) for v in variances)
    share = theirs / (ours + theirs)
    y = share * means[0] + (1 - share) * means[1]
    error = mean(relative_errors(share**2 * variances[0] + (1 - share) ** 2 * variances[1], y), scene.trimmed)
    whole = [s.mean((1, 2)) for s in stacks]
    spread = np.sqrt(sum(w.var(ddof=1) / len(w) for w in whole))
    difference = whole[0].mean() - whole[1].mean()
    return Reference(y, error, share, difference / whole[1].mean(), difference / spread)


def stack(scene, program, samples, kept):
    """Renders of a scene with different seeds, Y alone: one for each number in `samples`. What was rendered before is taken from the disk."""
    digest = hashlib.sha256(scene.path.read_bytes())
    for file in sorted(assets.ASSETS.glob("*.spd")):
        digest.update(file.read_bytes())
    digest.update(repr((sorted(scene.defines.items()), samples)).encode())
    path = kept / f"{scene.name}-{program.name.replace(' ', '-')}-{digest.hexdigest()[:12]}.npy"
    if path.exists():
        return np.load(path)
    pictures = []
    for index, spp in enumerate(samples):
        print(f"    reference of {scene.name}: {program.name}, {spp} spp, {index + 1} of {len(samples)}", flush=True)
        pictures.append(program.run(scene.path, spp, 900_001 + index, scene.defines)[1][..., 1])
    np.save(path, np.stack(pictures))
    return np.stack(pictures)
