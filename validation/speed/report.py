"""RESULTS.md and its plots, from what the parts measured."""

import json
import statistics

from harness.plots import plt
from speed import gallery
from speed.instructions import RECORD
from speed.measure import FULL, NAMED, OPPONENT, OURS, PLAIN, QUICK, SCENES, SPP

median = statistics.median
SKIPS = """What `abbe info` lists as skipped, done all the same, on a small picture: least CPU time of some runs, and instructions, which are sure. That no bit of the picture changes is tested in `tests/fast/skips.rs`. *medium stack* is part of the
four below it. Dispersion, roughness, motion, light samples and surface coordinates are no question in the loop: without them a material, a spectrum or a transform is of another kind."""
# Marks and lines of the programs, the same in all plots.
STYLES = {OURS: "o-", OPPONENT: "s-"}
# What the costs on the scenes of the gallery are to be, as shares of Mitsuba's: their geometric mean, and the largest.
GALLERY_BARS = 0.5, 1


def table(header, rows):
    """A table as Markdown."""
    return ["| " + " | ".join(map(str, row)) + " |" for row in (header, ["---"] * len(header), *rows)] + [""]


def render_figures(found):
    """(program: processor seconds, relMSE, cost) of a scene."""
    figures = {name: (median(own["cpu"]), statistics.fmean(own["error"])) for name, own in found["programs"].items()}
    return {name: (cpu, error, cpu * error) for name, (cpu, error) in figures.items()}


def renders(told):
    rows, references = [], []
    for scene in SCENES:
        if not (part := told.get(f"renders-{scene.name}")):
            continue
        found = part["found"]
        figures = render_figures(found)
        ours = figures[OURS]
        for name, (cpu, error, cost) in figures.items():
            own = found["programs"][name]
            spread = statistics.stdev(own["error"]) / len(own["error"]) ** 0.5 if len(own["error"]) > 1 else 0.0
            title = f"{scene.what}{' (trimmed)' if scene.trimmed else ''}" if name == OURS else ""
            rows.append(
                (title, name, f"{found['samples'] / cpu / 1e6:.2f}", f"{cpu:.2f}", f"{median(own['whole']):.2f}", f"{error:.3g} ± {spread / error:.0%}", f"{cost:.3g}")
                + (f"{ours[2] / cost:.2f}", f"{ours[0] / cpu:.2f}", f"{median(own['peak']) / 2**20:.0f}")
            )
        own = found["reference"]
        share = own["error"] / ours[1]
        references.append((scene.what, f"{own['error']:.2g}", f"{share:.0%}", f"{own['share']:.0%}", f"{own['difference']:+.3%}", f"{own['sigma']:+.1f}"))
    header = ("scene", "program", "10⁶ samples per CPU s", "CPU s", "whole process, CPU s", "relMSE", "cost", "abbe's cost / this", "abbe's CPU s / this", "peak, MiB")
    about = ("scene", "its relMSE", "of abbe's relMSE", "abbe's share in it", "mean of the picture, abbe / Mitsuba − 1", "in standard errors")
    return table(header, rows), table(about, references)


def gallery_figures(told):
    """(scene, by program: what was found) of the scenes of the gallery that were measured."""
    return [(scene, part["found"]) for scene in gallery.SCENES if (part := told.get(f"gallery-{scene.name}"))]


def gallery_costs(told):
    """abbe's cost on each scene of the gallery over Mitsuba's."""
    return [found[OURS]["error"] * found[OURS]["cpu"] / (found[NAMED]["error"] * found[NAMED]["cpu"]) for _, found in gallery_figures(told)]


def of_gallery(told):
    rows = []
    for scene, found in gallery_figures(told):
        ours, theirs = found[OURS], found[NAMED]
        over = lambda figure: ours[figure] * ours["cpu"] / (theirs[figure] * theirs["cpu"])
        title = f"{scene.what}{' (trimmed)' if scene.trimmed else ''}"
        ratios = over("error"), over("whole"), over("blurred"), ours["cpu"] / theirs["cpu"]
        rows.append((title, f"{ours['cpu']:.2f}", f"{ours['error']:.3g}", *(f"{ratio:.2f}" for ratio in ratios)))
    rows.append(("geometric mean", "", "", f"{statistics.geometric_mean(gallery_costs(told)):.2f}", "", "", ""))
    return table(("scene", "CPU s", "relMSE", "cost / Mitsuba's", "with all pixels", "after a 4×4 blur", "CPU s / Mitsuba's"), rows)


def starts(told):
    rows = [
        (name, f"{min(own['wall']) * 1e3:.0f}", f"{median(own['wall']) * 1e3:.0f}", f"{median(own['cpu']) * 1e3:.0f}", f"{median(own['peak']) / 2**20:.0f}")
        for name, own in told["start"]["found"].items()
    ]
    return table(("whole process, 1 spp, Cornell box", "least ms by the clock", "median", "CPU ms", "peak, MiB"), rows)


def bytes_a_triangle(found, name):
    """What each further triangle takes, by the peaks of processes with few triangles and with about a million, or the most that there are."""
    few, many = found[0], min(found, key=lambda own: abs(own["triangles"] - 1e6))
    return (median(many["programs"][name]["peak"]) - median(few["programs"][name]["peak"])) / (many["triangles"] - few["triangles"])


def triangles(told):
    found = told["triangles"]["found"]
    rows = []
    for own in found:
        for name, line in own["programs"].items():
            first = f"{min(line['first']):.2f}", f"{median(line['first']):.2f}", f"{median(line['first cpu']):.2f}"
            rows.append((f"{own['triangles']:,}", name, f"{median(line['sample']) * 1e6:.2f}", *first, f"{median(line['peak']) / 2**20:.0f}"))
    each = "; ".join(f"{name} {bytes_a_triangle(found, name):.0f}" for name in found[0]["programs"])
    header = ("triangles", "program", "µs of CPU a sample", "PLY to first samples, least s by the clock", "median", "CPU s", "peak, MiB")
    return [*table(header, rows), f"Bytes that a triangle takes, from the peaks with the fewest and with about a million: {each}.", ""]


def threads(told):
    def taken(count, line):
        """The share of the time of so many processors that the host gave to others."""
        return sum(line["stolen"]) / (count * sum(line["wall"]))

    rows = []
    for scene, own in told["threads"]["found"].items():
        one, two = own["1"], own["2"]
        share_one, share_two = taken(1, one), taken(2, two)
        ratio_left = sum(one["wall"]) * (1 - share_one) / (sum(two["wall"]) * (1 - share_two))
        by_clock = f"{min(one['wall']):.2f}", f"{min(two['wall']):.2f}", f"{min(one['wall']) / min(two['wall']):.2f}"
        rows.append((scene, *by_clock, f"{share_one:.1%}", f"{share_two:.1%}", f"{ratio_left:.2f}", f"{median(two['cpu']) / median(one['cpu']):.3f}"))
    header = ("scene", "1 thread, least s by the clock", "2 threads", "ratio", "taken by the host: 1 thread", "2 threads", "ratio of the time that was left", "CPU s of 2 threads / of 1")
    return table(header, rows)


def skips(told):
    """What each thing that a scene does not need would take, as a share of the picture's time (the least of some runs) and instructions without it."""
    found = told["skips"]["found"]
    counted = json.loads(RECORD.read_text())["instructions"] if RECORD.exists() else {}
    scenes = list(dict.fromkeys(name.split(", ")[0] for name in found))
    plain = {scene: f"{scene}, nothing more" for scene in scenes}

    def cells(scene, what):
        name = f"{scene}, {what}"
        instructions = counted.get(f"skip: {name}", 0) / counted.get(f"skip: {plain[scene]}", 1)
        return f"{min(found[name]) / min(found[plain[scene]]) - 1:+.1%}", f"{instructions - 1:+.1%}" if instructions else ""

    whats = [name.split(", ", 1)[1] for name in found if name.startswith(f"{scenes[0]}, ") and name != plain[scenes[0]]]
    rows = [(what, *(cell for scene in scenes for cell in cells(scene, what))) for what in whats]
    return table(("done although not needed", *(f"{scene}: {what}" for scene in scenes for what in ("CPU time", "instructions"))), rows)


def bars(told):
    """What was asked for, what was found, and whether that is enough."""
    rows = []

    def add(what, wanted, found, form, met, part=None):
        """`part`: where time by the clock is judged, what measured it. Others on the machine can only make that worse."""
        busy = part["about"]["others"] if part else 0
        disturbed = f", but other programs kept {busy:.1f} processors busy" if busy > 0.1 else ""
        rows.append((what, wanted, form.format(found), "met" if met else f"**not met**{disturbed}"))

    for scene in SCENES:
        if part := told.get(f"renders-{scene.name}"):
            figures = render_figures(part["found"])
            (_, _, cost), (plain_cpu, _, _), (their_cpu, _, their_cost) = (figures[name] for name in (OURS, PLAIN, OPPONENT))
            add(f"cost / Mitsuba's: {scene.what}", f"≤ {scene.bar:g}", cost / their_cost, "{:.3g}", cost <= scene.bar * their_cost)
            if bar := scene.plain_bar:
                add(f"CPU time of the plain estimator / Mitsuba's: {scene.what}", f"≤ {bar:g}", plain_cpu / their_cpu, "{:.2f}", plain_cpu <= bar * their_cpu)
    if costs := gallery_costs(told):
        for what, bar, found in zip(("geometric mean", "largest"), GALLERY_BARS, (statistics.geometric_mean(costs), max(costs))):
            add(f"cost / Mitsuba's: {len(costs)} scenes in the manner of its gallery, {what}", f"≤ {bar:g}", found, "{:.2f}", found <= bar)
    if part := told.get("start"):
        least = min(part["found"]["abbe, 16×16"]["wall"]) * 1e3
        add("start to first samples, Cornell box", "< 50 ms", least, "{:.0f} ms", least < 50, part)
    if part := told.get("triangles"):
        found = part["found"]
        million = min(found, key=lambda own: abs(own["triangles"] - 1e6))["programs"][OURS]
        add("PLY of 10⁶ triangles to first samples", "≤ 1.5 s", min(million["first"]), "{:.2f} s", min(million["first"]) <= 1.5, part)
        add("memory of a triangle", "< 200 bytes", bytes_a_triangle(found, OURS), "{:.0f} bytes", bytes_a_triangle(found, OURS) < 200)
        near = lambda count: min(found, key=lambda own: abs(own["triangles"] - count))
        few, many = near(1e4), near(1e7)
        growth = median(many["programs"][OURS]["sample"]) / median(few["programs"][OURS]["sample"])
        add(f"CPU time a sample, {many['triangles']:,} / {few['triangles']:,} triangles", "< 2.5", growth, "{:.2f}", growth < 2.5)
    if part := told.get("threads"):
        for scene, own in part["found"].items():
            ratio = min(own["1"]["wall"]) / min(own["2"]["wall"])
            add(f"2 threads against 1: {scene}", "≥ 1.9", ratio, "{:.2f}", ratio >= 1.9, part)
    return table(("", "wanted", "found", ""), rows)


def curves(told, path):
    """Costs at all numbers of samples, and the plot."""
    scenes = [scene for scene in SCENES if f"curves-{scene.name}" in told]
    columns = 4
    figure, axes = plt.subplots(-(-len(scenes) // columns), columns, figsize=(10.8, 2.6 * -(-len(scenes) // columns)), squeeze=False)
    for axis in axes.flat[len(scenes) :]:
        axis.axis("off")
    rows = []
    for axis, scene in zip(axes.flat, scenes):
        found = told[f"curves-{scene.name}"]["found"]
        points = {name: [(median(cpu), error) for cpu, error in zip(own["cpu"], own["error"])] for name, own in found.items()}
        for name, of_program in points.items():
            axis.loglog(*zip(*of_program), STYLES[name], label=name)
        axis.set_title(scene.what, fontsize=8)
        cost = lambda name: [cpu * error for cpu, error in points[name]]
        rows.append((scene.what, *(f"{ours / theirs:.2g}" for ours, theirs in zip(cost(OURS), cost(OPPONENT)))))
    counts = told[f"curves-{scenes[0].name}"]["found"][OURS]["spp"]
    axes[0, 0].legend(fontsize=7)
    figure.supxlabel("CPU seconds of the whole process", fontsize=9)
    figure.supylabel("relMSE", fontsize=9)
    plot = save(figure, path, "Error against processor time, from one to many samples per pixel")
    return [*table((f"cost / {OPPONENT}, samples per pixel", *map(str, counts)), rows), *plot]


def plot_triangles(told, path):
    if "triangles" not in told:
        return []
    found = told["triangles"]["found"]
    figure, axes = plt.subplots(1, 3, figsize=(10.8, 3))
    counts = [own["triangles"] for own in found]
    for axis, key, factor, what in zip(axes, ("sample", "first", "peak"), (1e6, 1, 1 / 2**20), ("CPU µs a sample", "s to the first samples", "peak of memory, MiB")):
        for name in found[0]["programs"]:
            axis.loglog(counts, [median(own["programs"][name][key]) * factor for own in found], STYLES[name], label=name)
        axis.set(xlabel="triangles", title=what)
    axes[0].legend(fontsize=8)
    return save(figure, path, "Cost of a sample, start and memory against the number of triangles")


def save(figure, path, caption):
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)
    plt.close(figure)
    return [f"![{caption}](plots/{path.name})", "", f"{caption}.", ""]


def write(told, folder, quick):
    """RESULTS.md in the folder, and plots beside it. `told`: by the name of each part, what it found and when."""
    power = QUICK if quick else FULL
    lines = ["# abbe's speed beside Mitsuba 3.9.1", "", f"Written by `validation/speed/run{' --quick' if quick else ''}`.", "", *machines(told), "", "## What was wanted", "", *bars(told)]
    lines += ["What is not measured here: rays per second beside Embree.", ""]
    if any(name.startswith("renders-") for name in told):
        figures, references = renders(told)
        lines += ["## Error and processor time", "", *method(told, power), "", *figures, "The references:", "", *references]
    if gallery_figures(told):
        lines += ["## In the manner of Mitsuba's gallery", "", gallery_method(power), "", *of_gallery(told)]
    if any(name.startswith("curves-") for name in told):
        lines += ["## From one sample to thousands", "", curves_method(power), "", *curves(told, folder / "plots/curves.svg")]
    if "start" in told:
        lines += ["## Start", "", *starts(told)]
    if "triangles" in told:
        lines += ["## Triangles", "", *triangles(told), *plot_triangles(told, folder / "plots/triangles.svg")]
    if "threads" in told:
        lines += ["## Threads", "", *threads(told)]
    if "skips" in told:
        lines += ["## What is left out", "", SKIPS, "", *skips(told)]
    path = folder / "RESULTS.md"
    path.write_text("\n".join(lines), encoding="utf-8")
    print(path)


def method(told, power):
    """How the figures of `renders` came about."""
    rounds = sorted({len(part["found"]["programs"][OURS]["cpu"]) for name, part in told.items() if name.startswith("renders-")})
    return [
        f"{power.size} × {power.size} pixels, {SPP} samples each, no bound on depth, Russian roulette from depth 5, box filter; the same file for both programs.",
        "*abbe* is what a user gets, with error bars; *plain* is `--estimator plain`, by which each pixel pays for its own paths. *CPU s*: user and system time of the whole process less that of one with 1 sample per pixel, × 64/63, so without start, loading and compiling;",
        f"median of {' or '.join(map(str, rounds))} rounds in which the programs take turns. *relMSE*: mean of (I − R)² / (R² + 0.01·mean(R)²) in Y, mean of the rounds ± its standard error, less the reference's own;",
        "*trimmed*: without the worst 0.1 % of the pixels. *cost* = relMSE × CPU s. R is the mean of long renders of both programs with other seeds, each weighed by how sure it is, so neither is judged by itself alone.",
    ]


def gallery_method(power):
    """How the figures of `gallery` came about."""
    return (
        f"Files with Mitsuba's defaults for filter (gaussian) and sampler (`independent`), {power.size} × {power.size} pixels, {SPP} samples each; "
        f"relMSE by the spread of {power.seeds} renders. *with all pixels*: the trimmed costs without trimming."
    )


def curves_method(power):
    """How the figures of `curves` came about."""
    return (
        f"{power.curve_size} × {power.curve_size} pixels. CPU time is that of the whole process, start included (Mitsuba's kernels are compiled before). "
        "relMSE is half the squared difference of two renders, so it needs no reference; the absorber's and the caustic's are trimmed."
    )


def machines(told):
    """What it was made on and when."""
    about = [part["about"] for part in told.values()]
    if not about:
        return ["Nothing was measured."]
    machines = sorted({own["machine"] for own in about})
    when = sorted(own["when"] for own in about)
    busy = statistics.fmean(own["others"] for own in about)
    return [
        f"abbe at {' and '.join(sorted({own['commit'] for own in about}))}; {'; '.join(machines)}; {when[0][:16]} to {when[-1][:16]} UTC.",
        "",
        f"Beside the measurement other programs kept {busy:.1f} processors busy (mean over its parts): that makes processor time longer for all alike, and time by the clock for whoever is unlucky.",
    ]
