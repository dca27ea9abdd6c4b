"""The page of the validation, its committed summary, and a look at the page in a browser."""

import html
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from harness import machine

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
WIDTH = 1180  # of the window that looks, CSS pixels
SLICE = 12000  # height of one screenshot: Chromium draws none higher than 16,384 pixels

STYLE = """
:root { --ink: #1c1f23; --soft: #5d6570; --line: #dfe3e8; --good: #11703a; --bad: #b3261e; --paper: #fff; --shade: #f6f7f9; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 2rem 1.5rem 6rem; max-width: 1080px; font: 15px/1.55 system-ui, "Segoe UI", "DejaVu Sans", sans-serif; color: var(--ink); background: var(--paper); }
h1 { font-size: 1.7rem; margin: 0 0 .3rem; } h2 { margin: 3rem 0 .5rem; font-size: 1.15rem; text-transform: capitalize; color: var(--soft); border-bottom: 2px solid var(--line); }
h3 { margin: 2rem 0 .3rem; font-size: 1.15rem; } a { color: inherit; }
p { max-width: 78ch; margin: .4rem 0; } .soft { color: var(--soft); } .name { font: 13px ui-monospace, "DejaVu Sans Mono", monospace; color: var(--soft); }
.good { color: var(--good); font-weight: 600; } .bad { color: var(--bad); font-weight: 700; }
table { border-collapse: collapse; margin: .8rem 0; font-size: 13px; line-height: 1.4; } .wide { overflow-x: auto; }
th { text-align: left; font-weight: 600; background: var(--shade); } td, th { padding: .22rem .6rem; border-bottom: 1px solid var(--line); vertical-align: top; overflow-wrap: break-word; }
td:last-child { white-space: nowrap; }
.checks td:nth-child(4) { min-width: 6rem; } .many { font-size: 11px; } .many td, .many th { padding: .15rem .35rem; }
figure { margin: 1rem 0; } figure img, figure svg { max-width: 100%; height: auto; } figcaption { color: var(--soft); font-size: 13px; max-width: 90ch; }
dt { font-weight: 600; float: left; clear: left; width: 6.5rem; } dd { margin: 0 0 .35rem 6.5rem; max-width: 78ch; }
"""


def text(words):
    """Paragraphs of a docstring as HTML; `code` and **words to begin with** as in Markdown."""
    whole = html.escape("\n\n".join(" ".join(p.split()) for p in words.strip().split("\n\n")))
    whole = re.sub(r"`([^`]+)`", r"<code>\1</code>", whole)
    return re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", whole).replace("\n\n", "<br>")


def verdict(good):
    return '<span class="good">stands</span>' if good else '<span class="bad">fell</span>'


def rows(header, body, kind=""):
    head = "".join(f"<th>{cell}" for cell in header)
    kind += " many" if len(header) > 12 else ""
    return f'<div class="wide"><table class="{kind}"><tr>{head}' + "".join("<tr>" + "".join(f"<td>{cell}" for cell in row) for row in body) + "</table></div>"


def checks(claim):
    body = [
        (html.escape(c.what), c.tests, html.escape(c.found), html.escape(c.allowed), html.escape(c.detectable), '<span class="good">pass</span>' if c.passed else '<span class="bad">FAIL</span>')
        for c in claim.checks
    ]
    return rows(("check", "values", "found", "allowed", "smallest error seen", ""), body, "checks")


def planted(outcome):
    from harness.run import caught

    if not outcome.planted:
        return ""
    body = []
    for what, claim in outcome.planted:
        fallen = [c for c in claim.checks if not c.passed]
        by = "; ".join(f"{c.what} ({c.found}, {c.allowed})" for c in fallen) or "nothing"
        body.append((html.escape(what.what), "abbe's source" if what.mutant else "the scene or the reference", html.escape(by), '<span class="good">caught</span>' if caught(what, claim) else '<span class="bad">MISSED</span>'))
    return rows(("planted error", "planted in", "what noticed it", ""), body)


def shown(claim, folder):
    """Figures and tables of a claim; pictures are copied beside the page, drawings stand in it."""
    from harness.claim import Figure

    parts = []
    for number, item in enumerate(claim.shown):
        if not isinstance(item, Figure):
            parts.append(rows([html.escape(h) for h in item.header], [[html.escape(c) for c in row] for row in item.rows]))
            parts.append(f'<p class="soft">{html.escape(item.caption)}</p>')
            continue
        name = f"{claim.name.replace('/', '-')}-{number}{item.path.suffix}"
        shutil.copyfile(item.path, folder / name)
        parts.append(f'<figure><img src="{name}" alt="{html.escape(item.caption)}"><figcaption>{html.escape(item.caption)}</figcaption></figure>')
    return "".join(parts)


def title(outcome):
    return outcome.module.__doc__.strip().splitlines()[0].rstrip(".")


def hypothesis(outcome):
    return outcome.module.__doc__.strip().split("\n", 1)[1]


def counts(outcome):
    claims = [outcome.claim] + [claim for _, claim in outcome.planted]
    return len(outcome.claim.checks), sum(check.tests for check in outcome.claim.checks), len(claims) - 1


def write(outcomes, folder, quick, seconds):
    """The page; returns its path."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    good = all(outcome.passed for outcome in outcomes)
    parts = [
        f'<!doctype html><html lang="en"><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>Validation of abbe</title><style>{STYLE}</style>',
        "<h1>Validation of abbe</h1>",
        f'<p>Claims: {len(outcomes)}; {sum(len(o.claim.checks) for o in outcomes)} checks of {sum(c.tests for o in outcomes for c in o.claim.checks):,} values, {sum(len(o.planted) for o in outcomes)} planted errors. '
        + ('<span class="good">All claims stand.</span>' if good else '<span class="bad">Not all claims stand.</span>') + "</p>",
        '<p class="soft">A random value is judged by its standard error: a check fails with a probability of 10⁻⁴ if nothing is wrong, and “smallest error seen” is what it would have found with a probability of 90 %. '
        "Where nothing is random that is the bound itself. A planted error is a fault of known size that the checks of the claim must notice.</p>",
        f'<p class="soft">{html.escape(machine.describe())}; {"--quick" if quick else "full power"}; {seconds / 60:.0f} minutes. <code>validation/run CLAIM</code> repeats one.</p>',
    ]
    body = [
        (f'<a href="#{o.claim.name}">{html.escape(title(o))}</a>', f'<span class="name">{o.claim.name}</span>', *counts(o), f"{o.seconds:.0f} s", verdict(o.passed)) for o in outcomes
    ]
    parts.append(rows(("claim", "folder", "checks", "values", "planted", "time", ""), body))
    group = None
    for outcome in outcomes:
        if (own := outcome.claim.name.split("/")[0]) != group:
            group = own
            parts.append(f"<h2>{group}</h2>")
        parts.append(f'<section id="{outcome.claim.name}"><h3>{html.escape(title(outcome))}</h3><p class="name">{outcome.claim.name} · {verdict(outcome.passed)}</p>')
        parts.append(f"<dl><dt>Hypothesis<dd>{text(hypothesis(outcome))}<dt>Method<dd>{text(outcome.module.METHOD)}<dt>Data<dd>{text(outcome.module.DATA)}</dl>")
        parts += [shown(outcome.claim, folder), checks(outcome.claim), planted(outcome), "</section>"]
    page = folder / "index.html"
    page.write_text("\n".join(parts), encoding="utf-8")
    return page


def write_summary(outcomes, path, seconds):
    """RESULTS.md: one line a claim, the worst check of each, and the planted errors."""
    from harness.run import caught

    lines = ["# What `validation/run` found", "", f"{machine.describe()}; full power, {seconds / 60:.0f} minutes. Written by the run; `validation/report/index.html` has the figures.", ""]
    lines += ["| claim | | checks | values | the tightest check | found | allowed | smallest error seen |", "|---" * 8 + "|"]
    cell = lambda words: str(words).replace("|", "\\|")
    for o in outcomes:
        tightest = max(o.claim.checks, key=lambda check: check.strength)
        words = (title(o), "stands" if o.passed else "**FELL**", *counts(o)[:2], tightest.what, tightest.found, tightest.allowed, tightest.detectable)
        lines.append("| " + " | ".join(map(cell, words)) + " |")
    lines += ["", "| planted error | claim | | noticed by |", "|---" * 4 + "|"]
    for o in outcomes:
        for planted_error, claim in o.planted:
            fallen = [c for c in claim.checks if not c.passed]
            by = "; ".join(f"{c.what}: {c.found}" for c in fallen[:2]) + (f"; {len(fallen) - 2} more" if len(fallen) > 2 else "")
            lines.append("| " + " | ".join(map(cell, (planted_error.what, o.claim.name, "caught" if caught(planted_error, claim) else "**MISSED**", by))) + " |")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


# Where each figure and heading lies once the page is laid out, for the look at the screenshot.
MEASURE = """<script>addEventListener("load", () => {
  const box = e => { const r = e.getBoundingClientRect(); return [r.left + scrollX, r.top + scrollY, r.width, r.height].map(Math.round).join(","); };
  const lines = [["page", [0, 0, document.documentElement.scrollWidth, document.documentElement.scrollHeight].join(",")]];
  for (const e of document.querySelectorAll("figure img, h3")) lines.push([e.tagName + (e.complete === false || e.naturalWidth === 0 ? "-broken" : ""), box(e)]);
  const pre = document.createElement("pre"); pre.id = "boxes"; pre.hidden = true; pre.textContent = lines.map(l => l.join(" ")).join("\\n"); document.body.append(pre);
});</script>"""


def look(page):
    """Opens the page in a browser and checks on the screenshot that nothing is wider than the window, and that each figure and each heading is drawn.
    A list of problems; empty without a browser, which it says. The screenshots lie beside the page."""
    import matplotlib.image
    import numpy as np

    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if not browser:
        print("no browser: nothing has looked at the page")
        return []
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "report"
        shutil.copytree(page.parent, copy)
        (copy / page.name).write_text(page.read_text(encoding="utf-8") + MEASURE, encoding="utf-8")
        quiet = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync", "--hide-scrollbars"]
        start = lambda height, *words: subprocess.run(
            [browser, *quiet, f"--user-data-dir={folder}/profile-{height}", f"--window-size={WIDTH},{height}", *words, (copy / page.name).as_uri()], capture_output=True, text=True, timeout=300
        )
        dom = start(900, "--dump-dom", "--virtual-time-budget=10000").stdout
        found = re.search(r'<pre id="boxes"[^>]*>(.*?)</pre>', dom, re.S)
        if not found:
            return ["the browser did not lay out the page"]
        boxes = [(kind, [int(v) for v in box.split(",")]) for kind, box in (line.split() for line in found.group(1).splitlines())]
        height = boxes[0][1][3]
        slices = []
        for top in range(0, height, SLICE):
            shot = Path(folder) / "slice.png"
            shot.unlink(missing_ok=True)
            (copy / page.name).write_text(page.read_text(encoding="utf-8") + f"<style>body {{ position: relative; top: -{top}px; }}</style>", encoding="utf-8")
            start(min(SLICE, height - top), f"--screenshot={shot}")
            if not shot.exists():
                return ["the browser made no screenshot"]
            slices.append((matplotlib.image.imread(shot)[..., :3] * 255).astype(np.uint8))
            shutil.copyfile(shot, page.parent / f"page-{len(slices)}.png")
        seen = np.concatenate(slices)
    problems = []
    if boxes[0][1][2] > WIDTH:
        problems.append(f"the page is {boxes[0][1][2]} pixels wide in a window of {WIDTH}")
    for kind, (x, y, w, h) in boxes[1:]:
        part = seen[y : y + h, x : x + w].reshape(-1, 3)
        if kind.endswith("-broken"):
            problems.append(f"a picture at {x}, {y} does not load")
        elif kind == "IMG" and (part.size == 0 or len(np.unique(part @ [65536, 256, 1])) < 8 or (part.max(1) > 250).mean() > 0.995):
            problems.append(f"a figure at {x}, {y} ({w}×{h}) is empty")
        elif kind == "H3" and (part.size == 0 or part.min() > 120):
            problems.append(f"a heading at {x}, {y} is not drawn")
    return problems
