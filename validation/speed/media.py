"""What companion wavelengths are worth in chromatic media, and the cost beside Mitsuba 3's `volpathmis`: as `speed.paired`, with 1 and with 4
wavelengths a path. The error is that of X, Y and Z together, for in such media noise is coloured. Started by `validation/speed/media`."""

import argparse
import sys
from pathlib import Path

import numpy as np

from harness import machine as machines
from speed import measure
from speed.figures import mean, relative_errors
from speed.programs import HERE, WORK, Abbe, Mitsuba

SCENES = ("media_cloud", "media_within", "media_glass", "media_ahead")
# What is wanted: cost with four wavelengths over that with one, and over Mitsuba's.
BARS = (0.5, 1.0)


def error(pictures, centre, channels):
    """relMSE of each of some renders, by their spread, over some channels."""
    spread = np.var(pictures, 0, ddof=1)
    return float(np.mean([mean(relative_errors(spread[..., c], centre[..., c]), False) for c in channels]))


def main():
    parser = argparse.ArgumentParser(prog="validation/speed/media", description=__doc__)
    parser.add_argument("binary", type=Path, metavar="BINARY", help="abbe")
    parser.add_argument("--scenes", default=",".join(SCENES), metavar="NAME,…", help="which (default: all)")
    parser.add_argument("--seeds", type=int, default=3, help="renders of each program (default: 3)")
    options = parser.parse_args()
    if options.seeds < 2:
        parser.error("a spread takes at least two seeds")
    if not machines.find_llvm():
        parser.error("Mitsuba is fastest with LLVM 19, and there is none (Debian: libllvm19)")
    WORK.mkdir(parents=True, exist_ok=True)
    programs = [Abbe(options.binary, f"C = {count}", ("--wavelengths", count)) for count in (1, 4)]
    programs.append(Mitsuba("Mitsuba", "llvm_ad_spectral", "multijitter"))
    print(machines.describe())
    print("| scene | relMSE of X, Y, Z: C = 1 | C = 4 | volpathmis | CPU s: C = 1 | C = 4 | volpathmis | cost of C = 4 over C = 1 | over volpathmis | by Y alone | |")
    print("|" + " --- |" * 11)
    for scene in options.scenes.split(","):
        path = HERE / "scenes" / f"{scene}.xml"
        seconds, pictures = measure.by_turns(programs, path, options.seeds, {})
        centre = np.mean([np.mean(of_program, 0) for of_program in pictures.values()], 0)
        errors = {name: error(of_program, centre, (0, 1, 2)) for name, of_program in pictures.items()}
        of_y = {name: error(of_program, centre, (1,)) for name, of_program in pictures.items()}

        def ratio(errors, other):
            return errors["C = 4"] * seconds["C = 4"] / errors[other] / seconds[other]

        ratios = [ratio(errors, other) for other in ("C = 1", "Mitsuba")]
        by_y = [ratio(of_y, other) for other in ("C = 1", "Mitsuba")]
        met = all(found <= bar for found, bar in zip(ratios, BARS))
        columns = [scene, *(f"{errors[name]:.3g}" for name in errors), *(f"{seconds[name]:.1f}" for name in seconds)]
        columns += [*(f"**{found:.2g}**" for found in ratios), ", ".join(f"{found:.2g}" for found in by_y), "met" if met else "missed"]
        print("| " + " | ".join(columns) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
