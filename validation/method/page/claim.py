"""The look at this page notices what a reader could not see

Each run ends with a browser that lays out the report and a screenshot on which every figure and heading must be drawn. A figure that is empty or does not load, a
heading that is invisible and a table wider than the window are each noticed; a page without them raises no alarm.
"""

import shutil

from harness import report
from harness.plots import plt

METHOD = """
A small page with one figure is written as the report writes its own, whole and with one fault at a time, and shown to the same function that looks at the report.
"""
DATA = "None. Where there is no browser nothing is checked, and the claim says so."

FAULTS = {
    "none": lambda page: page,
    "an empty figure": lambda page: page.replace("figure.svg", "empty.svg"),
    "a figure that is not there": lambda page: page.replace("figure.svg", "missing.svg"),
    "a heading in the colour of the paper": lambda page: page.replace("<h3>", '<h3 style="color: #fff">'),
    "a line wider than the window": lambda page: page + '<pre style="width: 3000px">wide</pre>',
}


def run(claim):
    if not any(shutil.which(name) for name in report.BROWSERS):
        claim.holds("looked at in a browser", True, "no browser here: left out", "", "nothing")
        return
    curve, axes = plt.subplots(figsize=(4, 2))
    axes.plot([0, 1, 2], [0, 1, 0])
    blank = plt.figure(figsize=(4, 2))
    rows = []
    for fault, plant in FAULTS.items():
        folder = claim.work / fault.replace(" ", "-")
        folder.mkdir()
        curve.savefig(folder / "figure.svg")
        blank.savefig(folder / "empty.svg")
        page = folder / "index.html"
        text = f'<!doctype html><html><meta charset="utf-8"><style>{report.STYLE}</style><h3>A heading</h3><figure><img src="figure.svg" alt=""></figure><p>Text.</p>'
        page.write_text(plant(text), encoding="utf-8")
        found = report.look(page)
        rows.append((fault, "; ".join(found) or "nothing"))
        claim.holds(f"fault: {fault}", len(found) == (fault != "none"), rows[-1][1], "nothing" if fault == "none" else "one problem", "the fault")
    plt.close(curve)
    plt.close(blank)
    claim.table(("fault", "noticed"), rows, "What the look at the page says of each fault.")
