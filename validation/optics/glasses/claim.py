"""Every glass of the catalogue has its index at Fraunhofer's lines and its Abbe number

n(λ) of all dispersion formulas is what the coefficients say to 10⁻¹⁵, what a render looks up is the same to 2·10⁻⁷, and nd and V_d = (n_d − 1)/(n_F
− n_C) are those of the data sheets."""

import mpmath

from harness.claim import Planted
from harness.plots import plt
from optics_common import LINES, exact_index, formulas

METHOD = """The coefficients, read from data/dielectrics/dispersion_formulas.csv by this program, are evaluated with 50 digits at ten lines by an
own implementation of the six formulas. The published figures are those of SCHOTT's data sheets to half a unit of the last digit that they print
(glass codes: nd to 0.0005), and handbook values, whose sources differ from one another in the fourth decimal, to 0.0005. Lines outside the stated
range of a formula are left out."""
DATA = """Coefficients: refractiveindex.info database (CC0). Published: SCHOTT data sheets (n and V_d, and the international glass code, nd − 1 and
10 V_d in three digits each) for the ten SCHOTT glasses; handbook values for crystals, water and air."""

# SCHOTT data sheet of N-BK7: index at each line, five decimals.
SHEET = {
    "BK7": {
        "h": 1.53024,
        "g": 1.52668,
        "F'": 1.52283,
        "F": 1.52238,
        "e": 1.51872,
        "d": 1.51680,
        "D": 1.51673,
        "C'": 1.51472,
        "C": 1.51432,
        "r": 1.51289,
    },
}
# International glass code and V_d of the SCHOTT glasses.
CODES = {
    "BK7": (517642, 64.17),
    "SF11": (785258, 25.76),
    "N-SF11": (785257, 25.68),
    "F2": (620364, 36.37),
    "SF10": (728284, 28.41),
    "N-SF66": (923209, 20.88),
    "LASFN9": (850322, 32.17),
    "N-FK51A": (487845, 84.47),
    "N-BAF10": (670471, 47.11),
    "N-BAK1": (573576, 57.55),
}
# Index at the D line as handbooks print it; their sources differ in the fourth decimal. Polymers, which differ between makers, are left out.
HANDBOOK = {
    "fused-silica": 1.4584,
    "CaF2": 1.4338,
    "sapphire-o": 1.7681,
    "sapphire-e": 1.7600,
    "diamond": 2.4173,
    "NaCl": 1.5442,
    "calcite-o": 1.6584,
    "calcite-e": 1.4864,
    "MgF2-o": 1.3777,
    "MgF2-e": 1.3896,
    "quartz-o": 1.5442,
    "quartz-e": 1.5533,
    "water-20C": 1.3330,
    "carbon-disulfide": 1.6277,
    "BaF2": 1.4744,
    "air-15C": 1.0003,
}
OFF, NANOMETRE = "coefficient wrong by 10⁻⁶", "index taken 1 nm off"
PLANTED = [
    Planted(OFF, ("n by the formula", "V_d by the formula")),
    Planted(NANOMETRE, ("n by the formula", "N-BK7"), "optics_one_nanometre_off"),
]


def run(claim):
    mpmath.mp.dps = 50
    rows = formulas()
    [named] = claim.abbe.probe([{"optics": {"names": {"conductors": False}}}])
    named = [entry for entry in named if entry["formula"]]
    claim.holds(
        "every formula of the table is in the catalogue", {e["column"] for e in named} == set(rows), f"{len(named)} of {len(rows)}", "all", "one"
    )
    nm = [LINES[line] for line in LINES]
    answers = claim.abbe.probe([{"optics": {"index": {"name": e["name"], "nm": nm, "range": [360, 830]}}} for e in named])
    errors, rendered, abbe_errors, shown, curves = [], [], [], [], {}
    for entry, answer in zip(named, answers):
        row = rows[entry["column"]]
        c = row["coefficients_um"].split()
        if claim.planted == OFF:
            c[1] = str(float(c[1]) * (1 + 1e-6))
        exact = [exact_index(int(row["formula"]), c, at) for at in nm]
        inside = [float(row["min_nm"]) <= at <= float(row["max_nm"]) for at in nm]
        errors += [float(abs(mpmath.mpf(n) / e - 1)) for n, e, ok in zip(answer["index"], exact, inside) if ok]
        rendered += [abs(a - b) for a, b, ok in zip(answer["rendered"], answer["index"], inside) if ok]
        n = dict(zip(LINES, exact))
        n_abbe = dict(zip(LINES, answer["index"]))
        if all(ok for line, ok in zip(LINES, inside) if line in "FdC"):
            number = (n["d"] - 1) / (n["F"] - n["C"])
            # n_F − n_C keeps the rounding of two indices near n.
            rounding = 2.0**-51 * float(n["d"] / (n["F"] - n["C"]))
            abbe_errors.append(float(abs(answer["abbe_number"] / number - 1)) / rounding)
        # JSON has no infinity: what is one number has no dispersion.
        v = float("inf") if answer["abbe_number"] is None else answer["abbe_number"]
        curves[entry["name"]] = (n_abbe["d"], v, n_abbe["D"])
        code, published = CODES.get(entry["name"], (None, None))
        told = HANDBOOK.get(entry["name"])
        shown.append(
            (
                entry["name"],
                *(f"{n_abbe[line]:.5f}" if ok else "–" for line, ok in zip(LINES, inside)),
                f"{v:.2f}" if v < float("inf") else "–",
                code or told or "",
                published or "",
            )
        )
    claim.bounded("n by the formula at the lines, relative", errors, 1e-15)
    claim.bounded("V_d by the formula, over two roundings of n", abbe_errors, 4)
    claim.bounded("n in a render", rendered, 2e-7)
    for name, lines in SHEET.items():
        answer = dict(zip(LINES, answers[[e["name"] for e in named].index(name)]["index"]))
        claim.bounded(f"N-{name}: the data sheet's n at the lines", [answer[line] - value for line, value in lines.items()], 5.5e-6)
    by_name = curves
    claim.bounded("SCHOTT: V_d of the data sheets", [by_name[name][1] - v for name, (_, v) in CODES.items()], 0.0051)
    claim.bounded("SCHOTT: nd by the glass code", [by_name[name][0] - 1 - (code // 1000) / 1000 for name, (code, _) in CODES.items()], 0.00051)
    claim.bounded("crystals, water and air: n at the D line by the handbooks", [by_name[name][2] - n for name, n in HANDBOOK.items()], 5e-4)
    if claim.planted:
        return
    claim.table(
        ("name", *LINES, "V_d", "published", "V_d"),
        shown,
        "Index at Fraunhofer's lines as abbe has it (– outside the formula's range); published: glass code, or n at the D line.",
    )
    figure, axes = plt.subplots(figsize=(7.2, 4.4))
    for name, (nd, v, _) in by_name.items():
        if v < 120:
            axes.plot(v, nd, "o", color="#d55e00" if name in CODES else "#0072b2")
            axes.annotate(name, (v, nd), textcoords="offset points", xytext=(4, 3), fontsize=6)
    for name, (code, v) in CODES.items():
        axes.plot(v, 1 + (code // 1000) / 1000, "+", color="black", ms=9)
    axes.set(xlabel="Abbe number V_d", ylabel="n_d")
    axes.invert_xaxis()
    claim.figure("abbe-diagram", figure, "The Abbe diagram of the catalogue (orange: SCHOTT; crosses: the published glass codes).")
