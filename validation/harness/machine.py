"""What the figures are made on, and where Mitsuba finds its compiler there."""

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

from harness.abbe import ROOT

LLVM_NAMES = ("libLLVM.so.19.1", "libLLVM-19.so.1", "libLLVM-19.so")
LLVM_FOLDERS = ("/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib/llvm-19/lib", "/usr/lib64", "/usr/lib")


def find_llvm():
    """Names LLVM 19 to Mitsuba if it is there (14 is refused, 15 aborts). Whether there is one, or another was named before."""
    found = [Path(f, n) for f in LLVM_FOLDERS for n in LLVM_NAMES if Path(f, n).exists()]
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", str(found[0]))
    return "DRJIT_LIBLLVM_PATH" in os.environ


def describe():
    """Processor, cores, commit and the versions of the witnesses, in a line."""
    told = Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in told.read_text().splitlines() if line.startswith("model name")] if told.exists() else []
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip() or "no commit"
    witnesses = ", ".join(f"{name} {version(name)}" for name in ("mitsuba", "colour-science", "numpy", "scipy"))
    return f"commit {commit}; {names[0] if names else platform.machine()}, {os.cpu_count()} cores; {witnesses}"
