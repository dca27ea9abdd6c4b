"""Which words of Mitsuba's scene language the files in scenes/ use, and which they do not: exits with 1 if one of WORDS is in none.

    coverage.py             table: word, number of scenes, and the first of them
    coverage.py --missing   only what is missing

A parameter counts if it is written out; that the picture depends on it is the scene's affair. The old camelCase names count as what they are upgraded to.
"""

import re
import sys
from pathlib import Path
from xml.etree import ElementTree

HERE = Path(__file__).resolve().parent
SCENES = HERE / "scenes"

# Plugin: its parameters, as Mitsuba 3.9.1 accepts them (whatever it does not know it refuses as unreferenced). `name=a|b`: each of these values.
# Left out are `hair`, which ends Mitsuba now and then (FACTS.md, 97), those that only Python can set (data, bitmap, grid), those for gradients (silhouette_sampling_weight), and gridvolume's max_value, a bound for free flight.
MAP = "to_uv"
LIGHT = "sampling_weight"
SHAPE = "to_world flip_normals"
MESH = f"{SHAPE} filename face_normals"
SENSOR = "srf shutter_open shutter_close"
ROUGH = "distribution=beckmann|ggx alpha alpha_u alpha_v sample_visible=true|false"
FILM = "width height crop_offset_x crop_offset_y crop_width crop_height"
PATH = "max_depth rr_depth hide_emitters"
WORDS = {
    "scene": {
        "include": "filename",
        "alias": "id as",
        "default": "name value",
        "ref": "id name",
        "path": "value",
    },
    "transform": {"translate": "x y z value", "rotate": "x y z value angle", "scale": "x y z value", "lookat": "origin target up", "matrix": "9 16"},
    "property": {
        "boolean": "",
        "integer": "",
        "float": "",
        "string": "",
        "point": "xyz value",
        "vector": "xyz value",
        "rgb": "value",
        "spectrum": "constant pairs filename type",
        "transform": "",
        "texture": "",
    },
    "shape": {
        "sphere": f"{SHAPE} center radius",
        "rectangle": SHAPE,
        "disk": SHAPE,
        "cylinder": f"{SHAPE} p0 p1 radius",
        "cube": SHAPE,
        "sdfgrid": "filename normals=analytic|smooth to_world",
        "linearcurve": "to_world filename",
        "bsplinecurve": "to_world filename",
        "obj": f"{MESH} flip_tex_coords",
        "ply": f"{MESH} flip_tex_coords",
        "serialized": f"{MESH} shape_index",
        "merge": "",
        "shapegroup": "",
        "instance": "to_world",
    },
    "bsdf": {
        "diffuse": "reflectance",
        "conductor": "material eta k specular_reflectance",
        "roughconductor": f"{ROUGH} material eta k specular_reflectance",
        "dielectric": "int_ior ext_ior specular_reflectance specular_transmittance",
        "roughdielectric": f"{ROUGH} int_ior ext_ior specular_reflectance specular_transmittance",
        "thindielectric": "int_ior ext_ior specular_reflectance specular_transmittance",
        "plastic": "int_ior ext_ior diffuse_reflectance specular_reflectance nonlinear",
        "roughplastic": "int_ior ext_ior diffuse_reflectance specular_reflectance nonlinear distribution=beckmann|ggx alpha sample_visible=true|false",
        "principled": "base_color roughness anisotropic metallic spec_trans eta specular spec_tint sheen sheen_tint flatness clearcoat clearcoat_gloss "
        "diffuse_reflectance_sampling_rate main_specular_sampling_rate clearcoat_sampling_rate",
        "principledthin": "base_color roughness anisotropic spec_trans eta spec_tint sheen sheen_tint flatness diff_trans diffuse_reflectance_sampling_rate",
        "twosided": "allow_transmission",
        "mask": "opacity",
        "blendbsdf": "weight",
        "bumpmap": "scale use_shadowing_function flip_invalid_normals",
        "normalmap": "normalmap use_shadowing_function flip_invalid_normals",
        "null": "",
    },
    "emitter": {
        "area": f"radiance {LIGHT}",
        "point": f"position to_world intensity {LIGHT}",
        "spot": f"to_world intensity cutoff_angle beam_width texture {LIGHT}",
        "directional": f"direction to_world irradiance {LIGHT}",
        "directionalarea": f"radiance {LIGHT}",
        "constant": f"radiance {LIGHT}",
        "envmap": f"filename scale to_world mis_compensation {LIGHT}",
        "projector": f"irradiance scale to_world fov focal_length {LIGHT}",
        "sunsky": "turbidity albedo sun_direction sun_scale sky_scale sun_aperture complex_sun to_world latitude longitude timezone year month day "
        f"hour minute second {LIGHT}",
    },
    "sensor": {
        "perspective": f"to_world fov focal_length fov_axis=x|y|diagonal|smaller|larger near_clip far_clip focus_distance principal_point_offset_x principal_point_offset_y {SENSOR}",
        "thinlens": f"to_world fov focal_length fov_axis aperture_radius focus_distance near_clip far_clip {SENSOR}",
        "orthographic": f"to_world near_clip far_clip focus_distance {SENSOR}",
        "radiancemeter": f"to_world origin direction {SENSOR}",
        "irradiancemeter": SENSOR,
        "distant": f"to_world direction target {SENSOR}",
        "batch": SENSOR,
    },
    "film": {
        "hdrfilm": f"{FILM} pixel_format=luminance|luminance_alpha|rgb|rgba|xyz|xyza component_format=float16|float32|uint32 file_format sample_border banner compensate",
        "specfilm": f"{FILM} component_format sample_border compensate",
    },
    "rfilter": {"box": "", "tent": "radius", "gaussian": "stddev", "mitchell": "B C", "catmullrom": "", "lanczos": "lobes"},
    "sampler": {
        "independent": "sample_count seed",
        "stratified": "sample_count seed jitter",
        "multijitter": "sample_count seed jitter",
        "orthogonal": "sample_count seed jitter strength",
        "ldsampler": "sample_count seed",
    },
    "integrator": {
        "path": f"{PATH} samples_per_pass block_size timeout",
        "direct": "shading_samples emitter_samples bsdf_samples hide_emitters",
        "volpath": PATH,
        "volpathmis": f"{PATH} use_spectral_mis",
        "ptracer": "max_depth",
        "depth": "",
        "aov": "aovs",
        "moment": "",
    },
    "texture": {
        "bitmap": f"filename raw filter_type=bilinear|nearest wrap_mode=repeat|clamp|mirror format accel {MAP}",
        "checkerboard": f"color0 color1 {MAP}",
        "mesh_attribute": "name scale",
        "volume": "volume",
    },
    "volume": {
        "gridvolume": "filename raw filter_type=nearest|trilinear wrap_mode=repeat|clamp|mirror use_grid_bbox to_world accel",
        "constvolume": "value",
    },
    "spectrum": {
        "uniform": "value",
        "regular": "wavelength_min wavelength_max values",
        "irregular": "wavelengths values",
        "d65": "scale",
        "blackbody": "temperature wavelength_min wavelength_max",
        "srgb": "color",
        "rawconstant": "value",
    },
    "medium": {"homogeneous": "sigma_t albedo scale has_spectral_extinction"},
    "attached medium": {"interior": "", "exterior": "", "medium": ""},
}
CLASSES = {"texture": ("texture", "spectrum"), "spectrum": ("texture", "spectrum")}
FILES = re.compile(r'<(?:string\s+name="filename"\s+value|include\s+filename|spectrum[^>]*\sfilename)="([^"]+)"')


def included(path, folder=None):
    """The file and all files that it includes, by paths from the first one's folder (`$folder` in scenes/ means parts)."""
    folder = folder or path.parent
    found = [path]
    for name in re.findall(r'<include\s+filename="([^"]+)"', path.read_text()):
        found += included(folder / name.replace("$folder", "parts"), folder)
    return found


def fingerprint(scene):
    """All bytes on which the picture depends: the scene, what it includes, and the files that these name."""
    texts = included(scene)
    named = sorted({name for text in texts for name in FILES.findall(text.read_text())})
    folders = [scene.parent, *(scene.parent / p for text in texts for p in re.findall(r'<path\s+value="([^"]+)"', text.read_text()))]
    files = [f / name for name in named for f in folders if (f / name).is_file()]
    return b"\0".join(f.read_bytes() for f in texts + files)


def snake(name):
    """alphaU -> alpha_u, intIOR -> int_ior, as Mitsuba upgrades old files."""
    return re.sub(r"([a-z0-9])([A-Z]+)", lambda m: f"{m[1]}_{m[2].lower()}", name)


def words(path):
    """The (class, plugin, parameter) triples that a file uses; the parameter is empty for the plugin itself."""
    text = path.read_text()
    root = ElementTree.fromstring(text.encode())
    defaults = {d.get("name"): d.get("value") for d in root.iter("default")}
    old = root.get("version", "3").split(".")[0] in "01"
    used = set()

    def value(element, key="value"):
        found = element.get(key, "")
        for name in sorted(defaults, key=len, reverse=True):
            found = found.replace("$" + name, defaults[name])
        return found

    def note(kind, plugin, parameter="", given=""):
        for k in CLASSES.get(kind, (kind,)):
            used.update({(k, plugin, ""), (k, plugin, parameter), (k, plugin, f"{parameter}={given.strip().lower()}")})

    def visit(parent, kind, plugin):
        for child in parent:
            tag, name = child.tag, child.get("name", "")
            name = snake(name) if old else name
            if kind and name:
                note(kind, plugin, name, value(child))
            if tag in WORDS["scene"]:
                for a in child.keys():
                    note("scene", tag, a)
            elif kind == "transform":
                given = child.get("value", "").replace(",", " ").split()
                for a in [str(len(given))] if tag == "matrix" else child.keys():
                    note("transform", tag, a)
                continue
            if tag in ("point", "vector", "rgb") and not child.get("type"):
                note("property", tag, "xyz" if "x" in child.keys() else "value")
            elif tag == "spectrum":
                list_given = re.search(r"[ ,:]", value(child).strip())
                form = "type" if child.get("type") else "filename" if child.get("filename") else "pairs" if list_given else "constant"
                note("property", tag, form)
            elif tag in WORDS["property"]:
                note("property", tag)
            if tag in ("medium", "ref") and name in WORDS["attached medium"]:
                note("attached medium", name)
            if tag == "transform":
                visit(child, "transform", "")
            elif child.get("type"):
                note(tag, value(child, "type"))
                visit(child, tag, value(child, "type"))

    visit(root, "", "")
    return used


def table():
    """(class, plugin, parameter, scenes that use it) for every word wanted."""
    uses = {}
    for scene in sorted(SCENES.glob("*.xml")):
        for file in included(scene):
            for word in words(file):
                uses.setdefault(word, set()).add(scene.stem)
    for kind, plugins in WORDS.items():
        for plugin, parameters in plugins.items():
            wanted = [""]
            for p in parameters.split():
                name, _, values = p.partition("=")
                wanted += [name] + [f"{name}={v}" for v in values.split("|") if v]
            for parameter in wanted:
                yield kind, plugin, parameter, sorted(uses.get((kind, plugin, parameter), ()))


def missing():
    return [" ".join(row[:3]) for row in table() if not row[3]]


def main():
    for kind, plugin, parameter, scenes in table():
        if not scenes or "--missing" not in sys.argv:
            print(f"{kind:12} {plugin:16} {parameter:36} {len(scenes):3} {', '.join(scenes[:3]) or 'MISSING'}")
    lacking = missing()
    print(f"{len(list(SCENES.glob('*.xml')))} scenes; {len(lacking)} words in none of them")
    return min(len(lacking), 1)


if __name__ == "__main__":
    sys.exit(main())
