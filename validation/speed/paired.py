"""The cost of one or more binaries of abbe beside Mitsuba 3, in minutes: the error is told by the spread of a few renders with different seeds, so no
reference is needed. All programs render by turns, with their defaults (error bars on), 64 samples a pixel. Started by `validation/speed/paired`."""

import argparse
import statistics
import sys
from pathlib import Path

import numpy as np

from harness import machine as machines
from speed import assets, gallery, measure
from speed.figures import mean, relative_errors
from speed.programs import WORK, Abbe, Mitsuba


def blurred(picture):
    """Means of 4×4 pixels."""
    height, width = picture.shape
    return picture.reshape(height // 4, 4, width // 4, 4).mean((1, 3))


def errors(stacks, trimmed):
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


def main():
    parser = argparse.ArgumentParser(prog="validation/speed/paired", description=__doc__)
    parser.add_argument("binaries", nargs="+", type=Path, metavar="BINARY", help="abbe, or several versions of it")
    parser.add_argument("--scenes", metavar="NAME,…", help="which (default: all)")
    parser.add_argument("--gallery", action="store_true", help="the scenes of gallery/; Mitsuba with its default sampler, too")
    parser.add_argument("--lamps", action="store_true", help="the scenes of lamps/, with Mitsuba as for the gallery")
    parser.add_argument("--seeds", type=int, default=3, help="renders of each program (default: 3)")
    options = parser.parse_args()
    if options.seeds < 2:
        parser.error("a spread takes at least two seeds")
    if not machines.find_llvm():
        parser.error("Mitsuba is fastest with LLVM 19, and there is none (Debian: libllvm19)")
    WORK.mkdir(parents=True, exist_ok=True)
    assets.spectra()
    if options.gallery:
        gallery.write()
        scenes = gallery.SCENES
    elif options.lamps:
        gallery.write_lamps()
        scenes = gallery.LAMPS
    else:
        assets.ball(assets.MILLION)
        scenes = measure.SCENES
    scenes = [scene for scene in scenes if not options.scenes or scene.name in options.scenes.split(",")]
    # The bench scenes face Mitsuba's best sampler, the gallery what its files name, which is the default.
    samplers = ("independent", "multijitter") if options.gallery or options.lamps else ("multijitter",)
    witnesses = [Mitsuba(f"Mitsuba {sampler}", "llvm_ad_spectral", sampler) for sampler in samplers]
    programs = [Abbe(binary, str(binary)) for binary in options.binaries] + witnesses
    print(machines.describe())
    costs = {program.name: [] for program in programs}
    for scene in scenes:
        cpu, pictures = measure.by_turns(programs, scene.path, options.seeds, scene.defines or {})
        pictures = {name: [picture[..., 1] for picture in of_program] for name, of_program in pictures.items()}
        stacks = list(pictures.values())
        smooth = [[blurred(picture) for picture in stack] for stack in stacks]
        seconds = np.array([cpu[name] for name in pictures])
        own, rough, whole = errors(stacks, scene.trimmed), errors(smooth, scene.trimmed), errors(stacks, False)
        witness = list(pictures).index(witnesses[0].name)
        over = lambda values: values / values[witness]
        cost, cost_blurred, cost_whole = over(own * seconds), over(rough * seconds), over(whole * seconds)
        for i, name in enumerate(pictures):
            costs[name].append(cost[i])
            told = f" (with all pixels {cost_whole[i]:.3g})" if scene.trimmed else ""
            ratios = f"cost {cost[i]:.3g}{told}, blurred {cost_blurred[i]:.3g}, relMSE {over(own)[i]:.3g}, CPU {over(seconds)[i]:.3g}"
            print(f"{scene.name:23} relMSE {own[i]:.3g}, blurred {rough[i]:.3g}, {seconds[i]:.2f} s; over {witnesses[0].name}'s: {ratios}  {name}", flush=True)
    for name, over in costs.items():
        print(f"{'geometric mean of cost':23} {statistics.geometric_mean(over):.3g}, largest {max(over):.3g}  {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
