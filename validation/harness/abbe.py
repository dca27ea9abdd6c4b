"""Runs abbe and reads what it wrote."""

import json
import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]


@dataclass
class Picture:
    """A picture of abbe's, in double precision; rows from the top."""

    channels: dict  # name -> height × width
    header: dict

    def stack(self, names):
        """Height × width × channels."""
        return np.stack([self.channels[name] for name in names], -1)

    def errors(self, names):
        """Standard errors as the file states them, in the same layout; see `degrees`."""
        return np.stack([self.channels["error." + name] for name in names], -1)

    @property
    def degrees(self):
        """Degrees of freedom of the errors."""
        return float(self.header["abbe.degreesOfFreedom"])

    def spectrum(self):
        """Bin centres (nm), spectral radiance per bin (W·m⁻²·sr⁻¹·nm⁻¹, height × width × bins) and its standard error. Needs `--spectral`."""
        named = sorted((float(name[3:-2].replace(",", ".")), name) for name in self.channels if name.startswith("S0.") and name.endswith("nm"))
        names = [name for _, name in named]
        return np.array([nm for nm, _ in named]), self.stack(names), self.errors(names)


@dataclass
class Abbe:
    """The renderer under test, or a faulty one made of it (`mutant`)."""

    binary: Path
    probe_binary: Path
    work: Path
    mutant: str | None = None
    cpu: float = 0.0  # seconds used so far

    def _run(self, command, **options):
        environment = dict(os.environ)
        if self.mutant:
            environment["ABBE_MUTANT"] = self.mutant
        before = os.times()
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, env=environment, **options)
        after = os.times()
        self.cpu += after.children_user + after.children_system - before.children_user - before.children_system
        if done.returncode:
            raise RuntimeError(f"{' '.join(map(str, command))} exits with {done.returncode}: {(done.stderr or done.stdout).strip()[-800:]}")
        return done.stdout

    def render(self, scene, spp, seed=1, options=(), defines=None, estimator="plain"):
        """The scene file rendered by `abbe render`: a Picture. `options` are further words, `defines` values for the scene's parameters.

        Each pixel traces its own paths unless `estimator` says otherwise: most claims take pixels as independent."""
        import OpenEXR

        self.work.mkdir(parents=True, exist_ok=True)
        output = self.work / f"{Path(scene).stem}.exr"
        words = [word for name, value in (defines or {}).items() for word in ("-D", f"{name}={value}")]
        self._run([self.binary, "render", scene, "-q", "-o", output, "--spp", spp, "--seed", seed, "--estimator", estimator, *options, *words])
        file = OpenEXR.File(str(output), separate_channels=True)
        channels = {name: channel.pixels.astype(np.float64) for name, channel in file.channels().items()}
        return Picture(channels, dict(file.header()))

    def info(self, scene):
        """What `abbe info --json` prints of a scene file."""
        return self._run([self.binary, "info", scene, "--json"])

    def spectrum(self, *words):
        """What `abbe spectrum` prints."""
        return self._run([self.binary, "spectrum", *words])

    def study(self, *words):
        """Runs `abbe study`."""
        self._run([self.binary, "study", *words])

    def probe(self, questions):
        """Answers of the library itself, in double precision: one object for each question (see `probe/`)."""
        lines = "".join(json.dumps(question) + "\n" for question in questions)
        return [json.loads(line) for line in self._run([self.probe_binary], input=lines).splitlines()]
