"""The programs that are compared, each run as a process of its own."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from harness.abbe import ROOT

HERE = Path(__file__).resolve().parent
WORK = ROOT / "target/validation/speed"
# Mitsuba integrates every fifth row of the CIE's table (mitsuba/FACTS.md, 51): with another one the two pictures differ by some hundredths of a per cent.
OBSERVER = "cie1931-5nm"


@dataclass(frozen=True)
class Used:
    """What a process used, by the operating system's accounting."""

    cpu: float  # seconds of all its threads, in user and system mode
    wall: float  # seconds by the clock
    peak: int  # bytes that were resident at most
    stolen: float  # seconds that the machine's host gave to others while this machine's processors had work, over all of them
    told: dict = field(default_factory=dict)  # what the program says of its steps


def execute(command, environment=None):
    """Runs a command to its end: Used."""
    launcher = [sys.executable, "-I", "-S", str(HERE / "launch.py")]
    before = stolen()
    done = subprocess.run(launcher + [str(word) for word in command], capture_output=True, text=True, env=environment)
    taken = stolen() - before
    lines = done.stdout.splitlines()
    used = json.loads(lines[-1]) if lines else {"status": done.returncode}
    if used["status"]:
        raise RuntimeError(f"{' '.join(map(str, command))} exits with {used['status']}: {done.stderr.strip()[-800:]}")
    return Used(used["cpu"], used["wall"], used["peak"], taken, json.loads(lines[-2]) if len(lines) > 1 else {})


def words(defines):
    return [f"{name}={value}" for name, value in defines.items()]


@dataclass(frozen=True)
class Abbe:
    """abbe with its own defaults: the sampler and the number of wavelengths are what its command takes where nothing is said."""

    binary: Path
    name: str = "abbe"
    options: tuple = ()

    def run(self, scene, spp, seed, defines):
        """Renders a scene: what that used, and X, Y, Z of each pixel."""
        import OpenEXR

        output = WORK / f"{os.getpid()}.exr"
        given = [word for define in words(defines) for word in ("-D", define)]
        used = execute([self.binary, "render", scene, "-q", "-o", output, "--spp", spp, "--seed", seed, "--observer", OBSERVER, *self.options, *given])
        channels = OpenEXR.File(str(output), separate_channels=True).channels()
        picture = np.stack([channels[c].pixels.astype(np.float64) for c in "XYZ"], -1)
        output.unlink()
        output.with_suffix(".png").unlink()
        return used, picture


@dataclass(frozen=True)
class Mitsuba:
    """Mitsuba in one of its variants, with one of its samplers."""

    name: str
    variant: str
    sampler: str
    home: Path | None = None  # where it keeps compiled kernels, if not where it always does

    def run(self, scene, spp, seed, defines):
        """As `Abbe.run`."""
        output = WORK / f"{os.getpid()}.npy"
        environment = os.environ | ({"HOME": str(self.home)} if self.home else {})
        defines = defines | {"sampler": self.sampler}
        used = execute([sys.executable, HERE / "witness.py", self.variant, scene, spp, seed, output, *words(defines)], environment)
        if used.told["samples"] != spp:
            raise RuntimeError(f"{self.name} takes {used.told['samples']} samples for {spp}")
        picture = np.load(output).astype(np.float64)
        output.unlink()
        return used, picture


def processors():
    """Seconds of all processors of the machine since it started, by what they were spent on: the columns of proc_stat(5)."""
    told = Path("/proc/stat").read_text().splitlines()[0].split()[1:]
    return [int(word) / os.sysconf("SC_CLK_TCK") for word in told]


def busy():
    """Seconds that all processors of the machine have worked since it started."""
    told = processors()
    return sum(told[:3]) + sum(told[5:7])


def stolen():
    """Seconds that processors had work and the host let others run instead, since the machine started."""
    return processors()[7]


@dataclass(frozen=True)
class Kernels:
    """Small pieces of work of abbe's: validation/speed/kernels."""

    binary: str

    def list(self):
        """(group, name) of each."""
        told = subprocess.run([self.binary, "--list-kernels"], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout
        return [tuple(line.split(" ", 1)) for line in told.splitlines()]

    def command(self, times, group, name):
        """Does a piece of work so many times, after once to warm up."""
        return [self.binary, "--repeat", str(times), group, name]


def kernels():
    """The program with the pieces of work, built."""
    command = ["cargo", "bench", "--package", "abbe-validation", "--bench", "kernels", "--no-run", "--message-format", "json"]
    told = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    artefacts = [json.loads(line) for line in told if line.startswith("{")]
    return Kernels(next(a["executable"] for a in artefacts if a.get("target", {}).get("name") == "kernels" and a.get("executable")))
