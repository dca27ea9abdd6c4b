"""Makes the pairs of metameric paints of this scene: <name>-a.spd and <name>-b.spd.

Run it in this folder: python3 make_metamers.py (needs numpy). The first of each pair is a ColorChecker patch as measured.
The second has the same CIE 1931 XYZ under D65: it differs by a metameric black, a curve that the observer can't see under
D65, chosen to change the colour under FL11 as far as a smooth reflectance can.
"""

from pathlib import Path

import numpy as np

DATA = Path("../../data")
# Names in the ColorChecker's table, and whether paint b shall be redder (+1) or greener (-1) under FL11.
PAINTS = {
    "purple": ("purple", -1),
    "skin": ("light_skin", -1),
    "grey": ("neutral_5_(.70_D)", 1),
    "foliage": ("foliage", 1),
}
GRID = np.arange(380.0, 731.0, 10.0)  # nm, as in the ColorChecker's table
FINE = np.arange(380.0, 731.0, 1.0)  # nm, to sum over
DARKEST, BRIGHTEST = 0.015, 0.97  # what a paint can be
STEEPEST = 0.12  # change of reflectance in 10 nm that is still believable for a paint
ROUGHNESS = 1000.0  # weight of second differences against the reflectance's room


def table(path):
    """Columns of a table of data/ by name."""
    lines = [line for line in Path(path).read_text().splitlines() if not line.startswith("#")]
    rows = np.array([[float(cell) for cell in line.split(",")] for line in lines[1:]])
    return dict(zip(lines[0].split(","), rows.T))


def weights(illuminant):
    """Matrix from reflectance on GRID, linear in between, to XYZ with Y = 1 for a perfect white."""
    nm, power = illuminant
    observer = table(DATA / "cie/cmf_cie1931_2deg_1nm.csv")
    light = np.interp(FINE, nm, power)
    curves = [np.interp(FINE, observer["wavelength_nm"], observer[bar]) * light for bar in ("xbar", "ybar", "zbar")]
    hats = np.array([np.interp(FINE, GRID, column) for column in np.eye(len(GRID))])
    return np.array([[curve @ hat for hat in hats] for curve in curves]) / curves[1].sum()


def metamer(base, d65, fl11, towards):
    """`base` plus the metameric black that pushes its colour furthest towards red or green under FL11, for the room that
    the reflectance has and for its roughness: maximise change @ c against c @ cost @ c, where blacks @ c is the black.
    """
    _, _, rows = np.linalg.svd(d65)
    blacks = rows[3:].T
    x, y, _ = fl11 / fl11.sum(axis=1, keepdims=True)
    change = towards * (x - y) @ blacks
    room = np.minimum(base - DARKEST, BRIGHTEST - base)
    bend = np.diff(np.eye(len(GRID)), n=2, axis=0)
    cost = blacks.T @ (np.diag(room**-2.0) + ROUGHNESS * bend.T @ bend) @ blacks
    black = blacks @ np.linalg.solve(cost, change)
    size = min((room / np.abs(black)).min(), ((STEEPEST - np.abs(np.diff(base))) / np.abs(np.diff(black))).min())
    return base + size * black


def write(name, text, values):
    lines = [f"# {text}", "# CIE 1931 2 degrees; reflectance factor against wavelength in nm; made by make_metamers.py"]
    lines += [f"{nm:.0f} {value:.6f}" for nm, value in zip(GRID, values)]
    Path(f"{name}.spd").write_text("\n".join(lines) + "\n")


def main():
    d65, fl11 = table(DATA / "illuminants/cie_a_c_daylight_5nm.csv"), table(DATA / "illuminants/cie_fl1_fl12_5nm.csv")
    d65 = weights((d65["wavelength_nm"], d65["D65"]))
    fl11 = weights((fl11["wavelength_nm"], fl11["FL11"]))
    patches = table(DATA / "reflectance/colorchecker_babelcolor_average_10nm.csv")
    for name, (patch, towards) in PAINTS.items():
        base = patches[patch]
        source = f"ColorChecker {patch.split('_(')[0].replace('_', ' ')}, BabelColor average of 30 charts (data/reflectance)"
        write(f"{name}-a", source, base)
        write(f"{name}-b", f"metamer under D65 of: {source}", metamer(base, d65, fl11, towards))


if __name__ == "__main__":
    main()
