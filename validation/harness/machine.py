"""What the figures were made on."""

import os
import platform
import subprocess
from importlib.metadata import version
from pathlib import Path

from harness.abbe import ROOT


def describe():
    """Processor, cores, commit and the versions of the witnesses, in a line."""
    told = Path("/proc/cpuinfo")
    names = [line.split(":")[1].strip() for line in told.read_text().splitlines() if line.startswith("model name")] if told.exists() else []
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True).stdout.strip() or "no commit"
    witnesses = ", ".join(f"{name} {version(name)}" for name in ("mitsuba", "colour-science", "numpy", "scipy"))
    return f"commit {commit}; {names[0] if names else platform.machine()}, {os.cpu_count()} cores; {witnesses}"
