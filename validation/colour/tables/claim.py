"""Tables: observers, illuminants and reflectances as abbe has loaded them

Every colour-matching function, illuminant and reflectance of abbe's catalogue has the values of colour-science's own table, at every node and linearly between them;
daylight of any temperature follows the CIE's formula.
"""

import colour
import numpy as np
from harness.claim import Planted
from harness.plots import plt

from colour_common import OBSERVERS, ask, catalogue, grid, illuminant, linear, observer, reflectance

METHOD = """The library is asked for its values every 0.5 nm from 360 to 830 nm, so at every node and between them. colour-science's tables are put on the same grid by
its own linear interpolator. Deviations are relative to the largest value of the function (its peak), and the bound 10⁻⁹ is the rounding of the tables with the
fewest digits. A different value of one node, a shifted or a swapped column, another interpolation or another rule for what lies outside a table are seen.

The CIE published a chromaticity for each illuminant, computed by others from the original tables, as a sum in steps of 5 nm. The same sum over abbe's values must give it to within
its rounding."""
DATA = """abbe's tables in `data/` were taken from colour-science 0.4.7, which restates those of CIE 15:2004, CIE 15:2018, CVRL, ISO 17321-1, BabelColor and NIST:
equality shows that nothing was lost on the way, not that the source is right. So two further witnesses stand beside it: Mitsuba 3.9's own transcription of the CIE 1931
observer and of D65 (5 nm, single precision), and the published chromaticities (`CCS_ILLUMINANTS`: CIE 15:2004 tables T.3, T.8.1 to T.8.3 and CIE 15:2018). Illuminant A is
colour-science's formula every 1 nm (ISO 11664-2); D50 to D75 continue beyond 780 nm, where the published tables end, by its daylight formula."""

# Tolerance of chromaticities that were published with four decimals: half a unit of the last, and 10⁻⁵ for the rounding of the tables' own values (0.005 in each of those whose
# weighted sum is some 500).
ROUNDED = 6e-5
PLANTED = [
    Planted("colour-matching functions shifted by 0.1 nm", caught_by=("observer cie1931", "observer cie2015-10", "Mitsuba's table of the CIE 1931 observer"), mutant="colour_shifted_observer"),
    Planted("one value of x̄ off by 10⁻⁴", caught_by=("observer cie1931",)),
    Planted("one value of FL11 off by 10⁻⁴ of its peak", caught_by=("illuminants",)),
    Planted("daylight's formula off by 10⁻⁵ in x", caught_by=("daylight",), mutant="colour_daylight_formula"),
]


def run(claim):
    nm = grid(0.5).wavelengths
    for name in OBSERVERS:
        expected = observer(name, 0.5).values.copy()
        if claim.planted == "one value of x̄ off by 10⁻⁴" and name == "cie1931":
            expected[np.argmin(np.abs(nm - 600)), 0] *= 1 + 1e-4
        found = np.array(ask(claim.abbe, "observer", name=name, nm=nm)["values"])
        claim.bounded(f"observer {name}: values every 0.5 nm", (found - expected) / expected.max(0), 1e-9)
    coarse = colour.MSDS_CMFS[OBSERVERS["cie1931"]].copy().align(grid(5))
    parts = [linear(colour.SpectralDistribution(values, coarse.wavelengths), grid(0.5), "zero").values for values in coarse.values.T]
    found = np.array(ask(claim.abbe, "observer", name="cie1931-5nm", nm=nm)["values"])
    claim.bounded("observer cie1931-5nm: values every 0.5 nm", (found - np.transpose(parts)) / coarse.values.max(0), 1e-9)
    cones = colour.MSDS_CMFS["Stockman & Sharpe 2 Degree Cone Fundamentals"]
    found = [ask(claim.abbe, "spectrum", kind="sensitivity", name=f"cone/{cone}", nm=cones.wavelengths)["values"] for cone in "LMS"]
    claim.bounded("cone fundamentals", np.transpose(found) - cones.values, 1e-9)

    rows = []
    for kind, theirs, outside, names in (("illuminant", illuminant, "zero", "illuminants"), ("reflectance", reflectance, "hold", "reflectances")):
        deviations, sources = [], {}
        entries = catalogue(claim.abbe, kind)
        questions = [{"colour": {"spectrum": {"kind": kind, "name": name, "nm": nm.tolist()}}} for name, _, _ in entries]
        for (name, file, column), found in zip(entries, claim.abbe.probe(questions)):
            sd, source = theirs(file, column)
            expected = linear(sd, grid(0.5), outside).values
            if claim.planted == "one value of FL11 off by 10⁻⁴ of its peak" and name == "FL11":
                expected[np.argmin(np.abs(nm - 600))] += 1e-4 * expected.max()
            deviation = np.abs(np.array(found["values"]) - expected).max() / expected.max()
            deviations.append(deviation)
            sources.setdefault(source, []).append((name, deviation))
        claim.bounded(f"{names}: largest deviation of each, as a share of its peak", deviations, 1e-9)
        rows += [(names, source, len(of), f"{max(deviation for _, deviation in of):.1e}", f"{of[0][0]} … {of[-1][0]}") for source, of in sources.items()]
    claim.table(("what", "colour-science", "spectra", "largest deviation of the peak", "from … to"), rows, "Which table each spectrum was compared with. What stands as data/ colour-science does not have: those rows show only that abbe reads its own files.")

    kelvin = np.array([4000, 5000, 6000, 6504, 7000, 7001, 8500, 10000, 15000, 25000])
    found = np.array(ask(claim.abbe, "daylight", kelvin=kelvin.astype(float), nm=nm))
    xy = [colour.temperature.CCT_to_xy_CIE_D(k) for k in kelvin]
    expected = np.array([linear(colour.sd_CIE_illuminant_D_series(c, shape=colour.SpectralShape(300, 830, 5)), grid(0.5), "zero").values for c in xy])
    claim.bounded("daylight of 4000 to 25000 K, as a share of the peak", (found - expected) / expected.max(1, keepdims=True), 1e-9)

    mitsuba(claim, nm)
    published(claim)


def mitsuba(claim, nm):
    """Its 5 nm tables, which are not from colour-science, at their nodes."""
    import mitsuba as mi

    mi.set_variant("scalar_spectral")
    nodes = np.arange(360, 831, 5)
    theirs = np.array([np.ravel(mi.cie1931_xyz(float(w))) for w in nodes])
    ours = np.array(ask(claim.abbe, "observer", name="cie1931", nm=nodes.astype(float))["values"])
    claim.bounded("Mitsuba's table of the CIE 1931 observer, every 5 nm, as a share of the peak", (ours - theirs) / theirs.max(0), 2e-6)
    light, interaction = mi.load_dict({"type": "d65"}), mi.SurfaceInteraction3f()

    def at(wavelength):
        interaction.wavelengths = mi.Color0f() if mi.is_rgb else mi.Spectrum(float(wavelength))
        return np.ravel(light.eval(interaction))[0]

    theirs = np.array([at(w) for w in nodes])
    ours = np.array(ask(claim.abbe, "spectrum", kind="illuminant", name="D65", nm=nodes.astype(float))["values"])
    ours, theirs = ours / ours[nodes == 560], theirs / theirs[nodes == 560]
    inside = nodes <= 780
    claim.bounded("Mitsuba's table of D65 to 780 nm, relative to 560 nm", (ours - theirs)[inside], 2e-6)
    claim.bounded("Mitsuba's table of D65 beyond, where abbe has the formula, relative to 560 nm", (ours - theirs)[~inside], 5e-5)


def published(claim):
    """Chromaticities as the CIE computed them, from the values that abbe has every 5 nm; and as abbe integrates."""
    known = colour.CCS_ILLUMINANTS[OBSERVERS["cie1931"]]
    names = [name for name, _, _ in catalogue(claim.abbe, "illuminant") if name in known and name != "E"]
    nm = np.arange(380.0, 781.0, 5.0)
    questions = [{"colour": {"spectrum": {"kind": "illuminant", "name": name, "nm": nm.tolist()}}} for name in names]
    lights = np.array([answer["values"] for answer in claim.abbe.probe(questions)])
    matching = np.array(ask(claim.abbe, "observer", name="cie1931", nm=nm)["values"])
    target = np.array([known[name] for name in names])
    summed = colour.XYZ_to_xy(lights @ matching) - target
    claim.bounded("chromaticities that the CIE published for 2°, from abbe's values every 5 nm: x and y", summed, ROUNDED)
    answers = ask(claim.abbe, "colours", observer="cie1931", illuminants=names, reflectances=[])
    integrated = colour.XYZ_to_xy(np.array([answer["white"] for answer in answers])) - target
    figure, axes = plt.subplots(figsize=(9, 3.4))
    axes.axhspan(-5, 5, color="#0072b2", alpha=0.12, lw=0)
    for k, axis, ink in ((0, "x", "#0072b2"), (1, "y", "#d55e00")):
        axes.plot(1e5 * summed[:, k], "o", color=ink, label=f"{axis}, abbe's values summed every 5 nm, as published")
        axes.plot(1e5 * integrated[:, k], "x", color=ink, alpha=0.7, label=f"{axis}, abbe's integral")
    axes.set_xticks(range(len(names)), names)
    axes.set(ylabel="abbe − published, 10⁻⁵", ylim=(-45, 30))
    axes.tick_params("x", rotation=90, labelsize=7)
    axes.legend(ncols=2, fontsize=7.5, loc="lower left")
    claim.figure(
        "published",
        figure,
        "Chromaticity of every illuminant for which the CIE published one (2°). The band is the rounding of four decimals. Summed as the CIE did, abbe's values give what was published; the crosses "
        "are what the coarse sum neglects: between nodes 5 nm apart lies colour, up to 3·10⁻⁴ of it for narrow lines.",
    )
