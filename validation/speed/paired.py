"""The cost of one or more binaries of abbe beside Mitsuba 3, in minutes: the error is told by the spread of a few renders with different seeds, so no
reference is needed. All programs render by turns, with their defaults (error bars on), 64 samples a pixel. Started by `validation/speed/paired`."""

import argparse
import statistics
import sys
from pathlib import Path

from harness import machine as machines
from speed import assets, gallery, measure
from speed.programs import WORK, Abbe, Mitsuba


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
        found = measure.spread(programs, scene, options.seeds)
        witness = found[witnesses[0].name]
        for name, own in found.items():
            over = {figure: own[figure] / witness[figure] for figure in own}
            cost = over["error"] * over["cpu"]
            costs[name].append(cost)
            told = f" (with all pixels {over['whole'] * over['cpu']:.3g})" if scene.trimmed else ""
            ratios = f"cost {cost:.3g}{told}, blurred {over['blurred'] * over['cpu']:.3g}, relMSE {over['error']:.3g}, CPU {over['cpu']:.3g}"
            print(f"{scene.name:23} relMSE {own['error']:.3g}, blurred {own['blurred']:.3g}, {own['cpu']:.2f} s; over {witnesses[0].name}'s: {ratios}  {name}", flush=True)
    for name, over in costs.items():
        print(f"{'geometric mean of cost':23} {statistics.geometric_mean(over):.3g}, largest {max(over):.3g}  {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
