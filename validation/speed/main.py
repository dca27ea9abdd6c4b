"""Measures abbe beside Mitsuba 3 and writes what was found. Started by `validation/speed/run`."""

import argparse
import json
import os
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

from harness import machine as machines
from harness.abbe import ROOT
from speed import assets, gallery, measure, report
from speed.programs import WORK, busy

BINARY = ROOT / "target/release/abbe"
PARTS = ("renders", "gallery", "curves", "start", "triangles", "threads", "skips")
SCENES = [scene.name for scene in (*measure.SCENES, *gallery.SCENES)]


def parts(power, options):
    """What is to be measured: the name of each piece, and what measures it."""
    contestants = measure.programs(options.abbe)
    scenes = {"renders": measure.SCENES, "curves": measure.SCENES, "gallery": gallery.SCENES}
    for part in options.parts or PARTS:
        step = getattr(measure, part)
        if part in scenes:
            chosen = [scene for scene in scenes[part] if not options.scenes or scene.name in options.scenes]
            yield from ((f"{part}-{scene.name}", lambda scene=scene, step=step: step(power, contestants, scene)) for scene in chosen)
        elif part in ("threads", "skips"):
            yield part, lambda step=step: step(power, options.abbe)
        else:
            yield part, lambda step=step: step(power, contestants)


def main():
    parser = argparse.ArgumentParser(prog="validation/speed/run", description=__doc__)
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"what to measure anew: {', '.join(PARTS)} (default: all)")
    parser.add_argument("--quick", action="store_true", help="small pictures and few runs, in some minutes: whether all of it works, no figures to keep")
    parser.add_argument("--scenes", metavar="NAME,…", default=(), type=lambda words: tuple(words.split(",")), help=f"only these of {', '.join(SCENES)}")
    parser.add_argument("--abbe", type=Path, default=BINARY, help="the binary to measure")
    parser.add_argument("--report", action="store_true", help="measure nothing: write what was found before")
    options = parser.parse_args()
    for given, known in ((options.parts, PARTS), (options.scenes, SCENES)):
        if unknown := set(given) - set(known):
            parser.error(f"no such thing: {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    if not machines.find_llvm():
        parser.error("Mitsuba is fastest with LLVM 19, and there is none (Debian: libllvm19); slower it is no opponent")
    kept = WORK / ("quick" if options.quick else "full")
    kept.mkdir(parents=True, exist_ok=True)
    gallery.write()
    assets.ball(assets.MILLION)
    power = measure.QUICK if options.quick else measure.FULL
    for name, step in () if options.report else parts(power, options):
        print(name, flush=True)
        began, worked, own = time.monotonic(), busy(), own_seconds()
        found = step()
        wall, worked, own = time.monotonic() - began, busy() - worked, own_seconds() - own
        commit, machine = machines.describe().split("; ", 1)
        commit = commit if options.abbe == BINARY else f"another binary than that of {commit}"
        about = {"when": datetime.now(UTC).isoformat(timespec="minutes"), "commit": commit, "machine": machine, "wall": wall, "others": max(worked - own, 0) / wall}
        (kept / f"{name}.json").write_text(json.dumps({"about": about, "found": found}, indent=1))
    told = {path.stem: json.loads(path.read_text()) for path in sorted(kept.glob("*.json"))}
    report.write(told, ROOT / "validation/speed" if not options.quick else kept, options.quick)
    return 0


def own_seconds():
    """Processor time of this process and of those that it waited for."""
    used = os.times()
    return sum(used[:4])


if __name__ == "__main__":
    sys.exit(main())
