"""Counts the instructions of small pieces of work (validation/speed/kernels) and compares them with what was counted before.

    instructions               exits with 1 if a piece takes 3 % more than instructions.json says, and names it
    instructions GROUP …       only these groups
    instructions --record      writes what was counted to instructions.json

Where time is too noisy to tell, this is not: the number changes with the code, the compiler and its options alone. Needs valgrind; without it nothing is
counted, which is said.
"""

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from harness.abbe import ROOT
from speed.programs import HERE, kernels

RECORD = HERE / "instructions.json"
TOLERANCE = 0.03
VALGRIND = ("valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=kernels::counted*")


def count(command):
    """Instructions of the part of a run that counts."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "callgrind"
        done = subprocess.run([*VALGRIND, f"--callgrind-out-file={out}", *command], cwd=ROOT, capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"{' '.join(command)}: {done.stderr.strip()[-800:]}")
        found = re.search(r"^totals: (\d+)", out.read_text(), re.M)
    instructions = int(found.group(1)) if found else 0
    if not instructions:
        sys.exit(f"{' '.join(command)}: nothing was counted")
    return instructions


def main():
    parser = argparse.ArgumentParser(prog="validation/speed/instructions", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("groups", nargs="*", metavar="GROUP")
    parser.add_argument("--record", action="store_true")
    options = parser.parse_args()
    if not shutil.which("valgrind"):
        print("no valgrind: no instructions are counted")
        return 0
    compiler = subprocess.run(["rustc", "--version"], capture_output=True, text=True, check=True).stdout.strip()
    record = json.loads(RECORD.read_text()) if RECORD.exists() else {"compiler": compiler, "instructions": {}}
    before = record["instructions"]
    if record["compiler"] != compiler and not options.record:
        print(f"counted before with {record['compiler']}, now with {compiler}: differences may be the compiler's")
    program = kernels()
    known = program.list()
    if unknown := set(options.groups) - {group for group, _ in known}:
        parser.error(f"no such group: {', '.join(sorted(unknown))}; there are {', '.join(dict.fromkeys(group for group, _ in known))}")
    grew, counted = [], {}
    for group, name in known:
        if options.groups and group not in options.groups:
            continue
        key = f"{group}: {name}"
        counted[key] = now = count(program.command(1, group, name))
        change = now / before[key] - 1 if key in before else None
        if change is not None and change > TOLERANCE:
            grew.append(f"{key}: {before[key]:,} → {now:,} ({change:+.1%})")
        print(f"{key:48} {now:>14,} {'new' if change is None else f'{change:+.1%}'}", flush=True)
    if options.record:
        # Groups that were not asked for keep what was counted of them.
        kept = before | counted if options.groups else counted
        RECORD.write_text(json.dumps({"compiler": compiler, "instructions": kept}, indent=1) + "\n")
        return 0
    for line in grew:
        print(f"GREW: {line}")
    return 1 if grew else 0


if __name__ == "__main__":
    sys.exit(main())
