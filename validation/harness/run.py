"""Runs claims, plants errors in them, and writes the report. Started by `validation/run`."""

import argparse
import contextlib
import functools
import importlib.util
import io
import multiprocessing
import os
import shutil
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field
from pathlib import Path

from harness import mutants, report
from harness.abbe import ROOT, Abbe
from harness.claim import Check, Claim

HERE = ROOT / "validation"
WORK = ROOT / "target/validation"
# The order of the report: what rests on what.
GROUPS = ("method", "colour", "optics", "transport", "mitsuba", "noise")
# It takes a third of the time of all, so it starts first.
LONGEST = "mitsuba/pairs"


@dataclass
class Outcome:
    """What became of one claim."""

    claim: Claim
    seconds: float
    planted: list = field(default_factory=list)  # (Planted, Claim) pairs

    @property
    def module(self):
        return load(self.claim.name)

    @property
    def passed(self):
        return self.claim.passed and all(caught(what, claim) for what, claim in self.planted)


def caught(planted, claim):
    """Whether each check that must notice the planted error failed."""
    fallen = [check.what for check in claim.checks if not check.passed]
    return all(any(what.startswith(name) for what in fallen) for name in planted.caught_by)


def names():
    """Folders with a claim, in the order of the report."""
    found = [path.parent.relative_to(HERE).as_posix() for path in HERE.glob("*/*/claim.py")]
    return sorted(found, key=lambda name: (GROUPS.index(name.split("/")[0]), name))


@functools.cache
def load(name):
    """The module of a claim; its folder's neighbours can be imported by it."""
    folder = HERE / name
    for path in (str(folder.parent), str(folder)):
        if path not in sys.path:
            sys.path.insert(0, path)
    spec = importlib.util.spec_from_file_location(name.replace("/", "_") + "_claim", folder / "claim.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def execute(module, name, work, abbe, quick, planted=None, only=()):
    """The claim after its run; what it raises is a check that failed."""
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    claim = Claim(name, abbe, work, quick, planted, only)
    try:
        module.run(claim)
    except Exception as error:  # Any failure is one of the claim, and the others shall still run.
        traceback.print_exc()
        claim.checks.append(Check("ran to its end", 1, f"{type(error).__name__}: {error}", "no error", "", float("inf")))
    return claim


def renderer(work, binaries, mutant=None):
    return Abbe(*binaries, work / "renders", mutant)


def run(name, options, faulty):
    """The claim, its planted errors with what became of each, and the seconds that they took: what can be handed from one process to another."""
    module = load(name)
    print(f"{name}: {module.__doc__.splitlines()[0]}", flush=True)
    start = time.monotonic()
    work = WORK / name
    binaries = (options.abbe, options.abbe.with_name("probe"))
    claim = execute(module, name, work, renderer(work, binaries), options.quick, only=options.only)
    tried = []
    # An error is told from noise at the power of --quick, so that is what the planted ones are run at. They tell of the checks, which change rarely, and not
    # of abbe: a quick run leaves them out.
    for planted in () if options.only or options.quick else getattr(module, "PLANTED", ()):
        if planted.mutant and not faulty:
            continue
        where = WORK / name / "planted" / planted.what.replace(" ", "-").replace("%", "percent")
        abbe = renderer(where, faulty if planted.mutant else binaries, planted.mutant)
        wrong = execute(module, name, where, abbe, True, planted.what)
        tried.append((planted, wrong))
        fallen = sum(not check.passed for check in wrong.checks)
        print(f"    {'caught' if caught(planted, wrong) else 'MISSED'}  planted: {planted.what}: {fallen} of {len(wrong.checks)} checks fell", flush=True)
    seconds = time.monotonic() - start
    print(f"    {seconds:.0f} s", flush=True)
    return claim, seconds, tried


def run_quietly(*words):
    """The same with what it prints, which else would mix with that of others."""
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        outcome = run(*words)
    return outcome, printed.getvalue()


def run_all(names, options, faulty):
    """The outcomes of claims in their order. As many are run at a time as there are cores: much of their time, programs start and numbers are looked at by one thread."""
    at_once = min(os.cpu_count() or 1, len(names))
    if at_once < 2:
        return [Outcome(*run(name, options, faulty)) for name in names]
    found = {}
    # A fresh process for each claim: Mitsuba and the modules of claims are loaded anew, and only what most of them need is there already.
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["harness.plots", "scipy.stats", "colour"])
    with ProcessPoolExecutor(at_once, context, max_tasks_per_child=1) as pool:
        running = {pool.submit(run_quietly, name, options, faulty): name for name in sorted(names, key=lambda name: name != LONGEST)}
        for done in as_completed(running):
            outcome, printed = done.result()
            print(printed, end="", flush=True)
            found[running[done]] = Outcome(*outcome)
    return [found[name] for name in names]


def main():
    parser = argparse.ArgumentParser(prog="validation/run", description=__doc__)
    parser.add_argument("claims", nargs="*", metavar="CLAIM", help="folders of claims, or of groups of them (default: all)")
    parser.add_argument("--quick", action="store_true", help="less power and no planted errors; some minutes instead of most of an hour")
    parser.add_argument("--only", metavar="PART,…", default=(), type=lambda words: tuple(words.split(",")), help="only these scenes of the claim, and no planted errors")
    parser.add_argument("--list", action="store_true", help="list the claims")
    parser.add_argument("--abbe", type=Path, default=ROOT / "target/release/abbe", help="the binary to test, with probe beside it")
    options = parser.parse_args()
    known = names()
    wanted = [name for name in known if not options.claims or any(name == c.strip("/") or name.startswith(c.strip("/") + "/") for c in options.claims)]
    unknown = [c for c in options.claims if not any(n == c.strip("/") or n.startswith(c.strip("/") + "/") for n in known)]
    if unknown:
        parser.error(f"no such claim: {', '.join(unknown)}; there are {', '.join(known)}")
    if options.list:
        for name in wanted:
            print(f"{name:28} {load(name).__doc__.splitlines()[0]}")
        return 0
    start = time.monotonic()
    faulty = None if options.quick or options.only else mutants.build(WORK / "mutants")
    if options.quick:
        # They are not built here, but the lists of faults must not rot unseen.
        mutants.check(WORK / "mutants")
    outcomes = run_all(wanted, options, faulty)
    complete = not options.claims and not options.quick and not options.only
    page = report.write(outcomes, HERE / "report", options.quick, time.monotonic() - start)
    if complete:
        report.write_summary(outcomes, HERE / "RESULTS.md", time.monotonic() - start)
    fallen = [outcome.claim.name for outcome in outcomes if not outcome.passed]
    seen = report.look(page)
    print(f"\n{len(outcomes) - len(fallen)} of {len(outcomes)} claims stand, {time.monotonic() - start:.0f} s; {os.path.relpath(page)}")
    for name in fallen:
        print(f"FELL: {name}")
    for problem in seen:
        print(f"REPORT: {problem}")
    return 1 if fallen or seen else 0


if __name__ == "__main__":
    sys.exit(main())
