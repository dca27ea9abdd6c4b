"""The parts of the measurement. Each returns plain data, which `speed.main` keeps, and `speed.report` shows."""

import statistics
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from speed import assets, figures
from speed.programs import HERE, Abbe, Mitsuba, execute, kernels

median = statistics.median


@dataclass(frozen=True)
class Scene:
    name: str
    what: str
    bar: float  # largest cost that is wanted, as a share of Mitsuba's
    trimmed: bool = False
    plain_bar: float = None  # largest processor time of the plain estimator that is wanted, as a share of Mitsuba's
    defines: dict = None

    @property
    def path(self):
        return HERE / "scenes" / f"{self.name}.xml"


SCENES = (
    Scene("cornell", "Cornell box, measured spectra", 0.1, plain_bar=0.5),
    Scene("metals", "rough Au, Cu, Al under sky and lamp", 0.3, plain_bar=0.6),
    Scene("mesh", "1.3 million triangles", 0.5),
    Scene("absorber", "absorbing glass ball", 0.12, trimmed=True),
    Scene("caustic", "caustic of a glass ball", 0.12, trimmed=True),
    Scene("fluorescent", "Cornell box under F11", 0.03),
    Scene("sodium", "Cornell box under sodium lines", 0.003),
)


@dataclass(frozen=True)
class Power:
    """How much is measured."""

    size: int  # of the pictures, pixels
    rounds: int  # runs of each program of which the median is taken
    curve: tuple  # samples per pixel
    curve_size: int
    seeds: int  # of the renders of each program whose spread tells the error
    counts: tuple  # of triangles
    chunks: dict  # of the references: see `figures.reference`


FULL = Power(256, 3, (1, 4, 16, 64, 256, 1024, 4096), 96, 2, (1e3, 1e4, 1e5, 1e6, 1e7), {"abbe": (64,) * 8, "llvm multijitter": (64,) * 8})
QUICK = Power(64, 2, (1, 4, 16, 64), 64, 2, (1e3, 1e4, 1e5, 1e6), {"abbe": (64,) * 4, "llvm multijitter": (64,) * 8})
SPP = 64
# Pictures of which the time is taken where something is left out or done.
SKIP_PICTURES = 100
# The run that is taken off: what starting and ending takes is in both.
LEAST = 1

OURS, PLAIN, OPPONENT, NAMED = "abbe", "abbe, plain", "llvm multijitter", "llvm independent"


def programs(binary):
    """abbe by default, Mitsuba with its best sampler and with the one that most of its files name, and abbe's plain estimator."""
    return (
        Abbe(binary, OURS),
        Mitsuba(OPPONENT, "llvm_ad_spectral", "multijitter"),
        Mitsuba(NAMED, "llvm_ad_spectral", "independent"),
        Abbe(binary, PLAIN, ("--estimator", "plain")),
    )


def scene_at(scene, size, **more):
    return replace(scene, defines={"size": str(size)} | more)


def rounds(count, contestants):
    """Round by round, each contestant once, in an order that turns: what else the machine does meets all alike."""
    for turn in range(count):
        for place in range(len(contestants)):
            yield turn, contestants[(place + turn) % len(contestants)]


def renders(power, contestants, scene):
    """Error and use of all programs on a scene, at 64 samples per pixel."""
    scene = scene_at(scene, power.size)
    reference = figures.reference(scene, contestants[:2], power.chunks)
    warm(contestants, scene)
    told = {program.name: {"cpu": [], "whole": [], "wall": [], "peak": [], "error": []} for program in contestants}
    for turn, program in rounds(power.rounds, contestants):
        least, _ = program.run(scene.path, LEAST, 1001 + turn, scene.defines)
        used, picture = program.run(scene.path, SPP, 1 + turn, scene.defines)
        own = told[program.name]
        own["cpu"].append((used.cpu - least.cpu) * SPP / (SPP - LEAST))
        own["whole"].append(used.cpu)
        own["wall"].append(used.wall)
        own["peak"].append(used.peak)
        own["error"].append(reference.error_of(picture, scene.trimmed))
        print(f"    {scene.name}: {program.name}: {own['cpu'][-1]:.2f} s, relMSE {own['error'][-1]:.3g}", flush=True)
    return {
        "samples": power.size**2 * SPP,
        "programs": told,
        "reference": {"error": reference.error, "share": reference.share, "difference": reference.difference, "sigma": reference.sigma},
    }


def curves(power, contestants, scene):
    """Error against processor time of the whole process, from one to many samples per pixel, by the spread of two renders."""
    contestants = contestants[:2]
    scene = scene_at(scene, power.curve_size)
    warm(contestants, scene, [spp for spp in power.curve if spp <= SPP])
    cpu, pictures = ({program.name: [[] for _ in power.curve] for program in contestants} for _ in range(2))
    for turn, program in rounds(2, contestants):
        for at, spp in enumerate(power.curve):
            used, picture = program.run(scene.path, spp, 2001 + turn, scene.defines)
            cpu[program.name][at].append(used.cpu)
            pictures[program.name][at].append(picture[..., 1])
        print(f"    {scene.name}: {program.name}: {cpu[program.name][-1][-1]:.1f} s at {power.curve[-1]} spp", flush=True)
    centre = np.mean([own[-1] for own in pictures.values()], axis=(0, 1))
    of_two = lambda two: figures.mean(figures.relative_errors((two[0] - two[1]) ** 2 / 2, centre), scene.trimmed)
    return {name: {"spp": list(power.curve), "cpu": cpu[name], "error": [of_two(two) for two in own]} for name, own in pictures.items()}


def spread(contestants, scene, seeds):
    """By each contestant's name: processor seconds, and relMSE by the spread of a few renders, that of all pixels (*whole*) and after a 4×4 blur."""
    cpu, pictures = by_turns(contestants, scene.path, seeds, scene.defines or {})
    stacks = [[picture[..., 1] for picture in of_program] for of_program in pictures.values()]
    smooth = [[figures.blurred(picture) for picture in stack] for stack in stacks]
    told = {
        "error": figures.errors_by_spread(stacks, scene.trimmed),
        "blurred": figures.errors_by_spread(smooth, scene.trimmed),
        "whole": figures.errors_by_spread(stacks, False),
    }
    return {name: {"cpu": cpu[name]} | {figure: float(values[i]) for figure, values in told.items()} for i, name in enumerate(pictures)}


def gallery(power, contestants, scene):
    """Error and processor time of abbe and of Mitsuba, with the sampler that its files name, on a scene in the manner of its gallery."""
    scene = scene_at(scene, power.size)
    contestants = [contestant for contestant in contestants if contestant.name in (OURS, NAMED)]
    warm(contestants, scene)
    found = spread(contestants, scene, power.seeds)
    print(f"    {scene.name}: " + ", ".join(f"{name} {own['cpu']:.2f} s, relMSE {own['error']:.3g}" for name, own in found.items()), flush=True)
    return found


def by_turns(contestants, path, seeds, defines):
    """By each contestant's name, what a few renders of different seeds take without the start (median of CPU seconds), and their pictures.

    No two contestants have a seed in common: versions that render the same bits would be taken for closer to the truth than they are."""
    start = {contestant.name: contestant.run(path, LEAST, 9, defines)[0].cpu for contestant in contestants}
    cpu, pictures = ({contestant.name: [] for contestant in contestants} for _ in range(2))
    for seed in range(seeds):
        for number, contestant in enumerate(contestants):
            used, picture = contestant.run(path, SPP, 100 + seed + seeds * number, defines)
            cpu[contestant.name].append(used.cpu - start[contestant.name])
            pictures[contestant.name].append(picture)
    return {name: median(of_contestant) for name, of_contestant in cpu.items()}, pictures


def warm(contestants, scene, counts=(SPP,)):
    """Mitsuba compiles a kernel once for each scene, sampler and number of samples and keeps it: none of the measured runs shall do that."""
    for program in contestants:
        if isinstance(program, Mitsuba):
            for spp in (LEAST, *counts):
                program.run(scene.path, spp, 1, scene.defines)


def start(power, contestants):
    """Whole processes that make one sample of each pixel of a picture of 16 × 16, or of the usual size: to the first sample, nearly."""
    cornell = SCENES[0]
    contestants = contestants[:2]
    found = {}
    for size in (16, power.size):
        scene = scene_at(cornell, size)
        warm(contestants, scene, ())
        for turn, program in rounds(2 * power.rounds + 1, contestants):
            used, _ = program.run(scene.path, LEAST, 1 + turn, scene.defines)
            keep(found, f"{program.name}, {size}×{size}", used)
        with tempfile.TemporaryDirectory() as empty:
            for turn in range(2):
                cold = Mitsuba("llvm multijitter, no kernel kept", "llvm_ad_spectral", "multijitter", Path(empty) / str(turn))
                cold.home.mkdir()
                keep(found, f"{cold.name}, {size}×{size}", cold.run(scene.path, LEAST, 1 + turn, scene.defines)[0])
    return found


def keep(found, name, used):
    own = found.setdefault(name, {"cpu": [], "wall": [], "peak": []})
    own["cpu"].append(used.cpu)
    own["wall"].append(used.wall)
    own["peak"].append(used.peak)


def triangles(power, contestants):
    """The same ball cut into more and more triangles: time of a sample, time to the first one, and memory."""
    mesh = next(scene for scene in SCENES if scene.name == "mesh")
    spp = SPP // 4
    found = []
    for count in map(assets.triangles_near, power.counts):
        assets.ball(count)
        scene, small = (scene_at(mesh, size, triangles=str(count)) for size in (power.size, 16))
        warm(contestants[:2], scene, (spp,))
        warm(contestants[:2], small, ())
        own = {"triangles": count, "programs": {p.name: {"sample": [], "first": [], "first cpu": [], "peak": []} for p in contestants[:2]}}
        for turn, program in rounds(max(power.rounds // 2, 1) + 1, contestants[:2]):
            first, _ = program.run(small.path, LEAST, 1 + turn, small.defines)
            least, _ = program.run(scene.path, LEAST, 1 + turn, scene.defines)
            used, _ = program.run(scene.path, spp, 1 + turn, scene.defines)
            line = own["programs"][program.name]
            line["sample"].append((used.cpu - least.cpu) / (power.size**2 * (spp - LEAST)))
            line["first"].append(first.wall)
            line["first cpu"].append(first.cpu)
            line["peak"].append(first.peak)
        print(f"    {count} triangles: " + ", ".join(f"{name} {median(line['sample']) * 1e6:.2f} µs a sample, {median(line['first']):.2f} s" for name, line in own["programs"].items()), flush=True)
        found.append(own)
    return found


def threads(power, binary):
    """abbe with one thread and with two, on two scenes."""
    found = {}
    contestants = [Abbe(binary, f"{count}", ("--threads", str(count))) for count in (1, 2)]
    for scene in (SCENES[0], SCENES[1]):
        scene = scene_at(scene, power.size)
        own = found[scene.name] = {program.name: {"cpu": [], "wall": [], "stolen": []} for program in contestants}
        for turn, program in rounds(power.rounds, contestants):
            least, _ = program.run(scene.path, LEAST, 1 + turn, scene.defines)
            used, _ = program.run(scene.path, SPP, 1 + turn, scene.defines)
            own[program.name]["cpu"].append(used.cpu - least.cpu)
            own[program.name]["wall"].append(used.wall - least.wall)
            own[program.name]["stolen"].append(used.stolen - least.stolen)
        print(f"    {scene.name}: " + ", ".join(f"{name} threads {min(line['wall']):.2f} s" for name, line in own.items()), flush=True)
    return found


def skips(power, binary):
    """Small pictures of which the renderer does what the scene has no need of, beside the same without (validation/speed/kernels/skips.rs)."""
    found = {}
    program = kernels()
    names = [name for group, name in program.list() if group == "skip"]
    for _, name in rounds(power.rounds, names):
        none, many = (execute(program.command(times, "skip", name)).cpu for times in (0, SKIP_PICTURES))
        found.setdefault(name, []).append((many - none) / SKIP_PICTURES)
    return found
