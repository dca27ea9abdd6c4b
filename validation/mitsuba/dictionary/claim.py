"""what abbe info --json writes is what mitsuba.load_dict takes

The scene that `abbe info --json` writes means to Mitsuba what the scene file means to it, where the file uses no extension.
"""

import json
from contextlib import chdir

import numpy as np

import compare
from compare import HERE
from harness.claim import Planted

METHOD = """Mitsuba loads each file of `mitsuba/scenes` twice: the XML itself, and what `abbe info --json` writes of it, by `load_dict`. A dictionary wants its matrices as objects of Mitsuba's,
which JSON has not, so that one line puts them in (`docs/recipes.md`). Both are rendered with the same seeds by the file's integrator, for the JSON has `path` where a file has `ptracer`, and
`volpath` where it has `volpathmis`. Their noise is nearly the same, and what their means differ by is judged by the spread of that difference over the seeds, and by the single precision in
which Mitsuba computes (the sun's place from a date, for one). `scalar_spectral` takes no LLVM and starts at once."""
DATA = """`validation/mitsuba/scenes`, those that use no extension and that are whole scenes; Mitsuba 3.9.1, `scalar_spectral`."""

BRIGHTER = "all constant radiances 1 % higher in the dictionary"
PLANTED = (Planted(BRIGHTER, ("the same means",)),)

SEEDS, SPP = range(1, 9), 2
# Eight units in the last place: what single precision may leave of a computed direction.
SINGLE = 2.0**-20
QUICK_SCENES = ("cornell", "twosided_kinds", "instances", "sdfgrid", "named_metals", "blender_export", "film_spectral", "aov", "moment", "direct_emitters", "batch")
PLANTED_SCENES = ("cornell", "twosided_kinds")


def dictionary(mitsuba, text, factor=1.0):
    """The scene as `load_dict` wants it, and how many extensions it has."""

    def made(fields):
        if fields.get("type") == "transform":
            return mitsuba.ScalarTransform4d(fields["matrix"])
        radiance = fields.get("radiance")
        if isinstance(radiance, dict) and isinstance(radiance.get("value"), float):
            radiance["value"] *= factor
        return fields

    document = json.loads(text, object_hook=made)
    return document["scene"], len(document["extensions"])


def means(mitsuba, scene, integrator):
    """Of each channel of the picture, seed by seed."""
    pictures = [np.array(mitsuba.render(scene, integrator=integrator, spp=SPP, seed=seed)) for seed in SEEDS]
    return np.stack([picture.reshape(-1, picture.shape[-1]).mean(0) for picture in pictures])


def run(claim):
    mitsuba = compare.load_mitsuba("scalar_spectral")
    mitsuba.set_log_level(mitsuba.LogLevel.Error)
    names = claim.only or (PLANTED_SCENES if claim.planted else QUICK_SCENES if claim.quick else ())
    scenes = [HERE / "scenes" / f"{name}.xml" for name in names] or sorted((HERE / "scenes").glob("*.xml"))
    factor = 1.01 if claim.planted == BRIGHTER else 1.0
    refused, measured, expected, errors, rows = [], [], [], [], []
    for path in scenes:
        scene, extensions = dictionary(mitsuba, claim.abbe.info(path), factor)
        if extensions:
            continue
        # Files are named from the folder of the scene.
        with chdir(path.parent):
            file = mitsuba.load_file(str(path))
            try:
                told = mitsuba.load_dict(scene)
            except Exception as error:  # What Mitsuba says is what this claim is about.
                refused.append(f"{path.stem}: {' '.join(str(error).split())[-200:]}")
                continue
            ours, theirs = (means(mitsuba, scene, file.integrator()) for scene in (told, file))
        difference = ours - theirs
        measured.extend(ours.mean(0))
        expected.extend(theirs.mean(0))
        errors.extend(np.hypot(difference.std(0, ddof=1) / np.sqrt(len(SEEDS)), SINGLE * np.abs(theirs.mean(0))))
        rows.append((path.stem, f"{np.abs(difference).max():.2g}", "yes" if (difference == 0).all() else "no"))
    claim.holds("load_dict takes it", not refused, "; ".join(refused) or f"{len(rows)} of {len(rows)}", "all", "a word that Mitsuba does not have")
    claim.agrees("the same means", measured, expected, errors, len(SEEDS) - 1)
    claim.table(("scene", "largest difference of a mean", "the same bits"), rows, f"{SPP} samples of each pixel, {len(SEEDS)} seeds.")
