"""A second abbe with known faults, of which the environment variable ABBE_MUTANT turns one on.

The files in `controls/` name each fault: a file, a piece of code that stands in it exactly once, and what stands there in the faulty program; `also` names more
of these, where a formula stands both for one path and for several in lanes. The source is copied, changed and built once, so the program under test never holds a fault.
"""

import json
import shutil
import subprocess
import tomllib
from pathlib import Path

from harness.abbe import ROOT

LISTS = ROOT / "validation/controls"
SWITCH = '''
/// Whether the named fault is planted.
pub fn planted(name: &str) -> bool {
    static MUTANT: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| std::env::var("ABBE_MUTANT").unwrap_or_default());
    *MUTANT == name
}
'''


def replace_once(path, old, new):
    text = path.read_text()
    if text.count(old) != 1:
        raise RuntimeError(f"validation/controls: {old!r} stands {text.count(old)} times in {path.name}; name a piece that stands there once")
    path.write_text(text.replace(old, new))


def copy(source, target):
    """Copies files whose content differs, so that an unchanged program is not built again."""
    target.parent.mkdir(parents=True, exist_ok=True)
    if not target.exists() or target.read_bytes() != source.read_bytes():
        shutil.copy2(source, target)


def sources():
    """What the programs of the manifests are made from, but for the tests: folders, and files: manifests, and the script that cargo runs before it builds."""
    metadata = subprocess.run(["cargo", "metadata", "--no-deps", "--format-version=1"], cwd=ROOT, check=True, capture_output=True, text=True).stdout
    packages = json.loads(metadata)["packages"]
    targets = [target for package in packages for target in package["targets"]]
    files = {package["manifest_path"] for package in packages} | {target["src_path"] for target in targets if "custom-build" in target["kind"]}
    programs = [target for target in targets if not {"test", "custom-build"} & set(target["kind"])]
    folders = {Path(target["src_path"]).parent.relative_to(ROOT) for target in programs}
    return {Path("data")} | folders, {Path(file).relative_to(ROOT) for file in files}


def plant(folder):
    """Writes the source of the faulty programs. An error where the lists of faults no longer fit the source."""
    faults = {name: fault for path in sorted(LISTS.glob("*.toml")) for name, fault in tomllib.loads(path.read_text()).items()}
    fresh = folder.with_name(folder.name + "-fresh")
    shutil.rmtree(fresh, ignore_errors=True)
    folders, files = sources()
    for name in folders:
        shutil.copytree(ROOT / name, fresh / name)
    for name in (Path("Cargo.lock"), *files):
        shutil.copy2(ROOT / name, fresh / name)
    # Other packages, so that their programs lie beside the true ones and share what was compiled for them.
    manifest, programs, lock = fresh / "Cargo.toml", fresh / "validation/Cargo.toml", fresh / "Cargo.lock"
    replace_once(manifest, 'name = "abbe"\n', 'name = "abbe-mutants"\n')
    replace_once(manifest, 'default-run = "abbe"\n', '')
    replace_once(manifest, '[workspace.lints.rust]\n', '[workspace.lints.rust]\nunused_parens = "allow"\n')
    replace_once(manifest, '\nabbe = { codegen', '\nabbe-mutants = { codegen')
    manifest.write_text(manifest.read_text() + '\n[lib]\nname = "abbe"\n\n[[bin]]\nname = "abbe-mutants"\npath = "src/main.rs"\n')
    replace_once(programs, 'name = "abbe-validation"\n', 'name = "abbe-validation-mutants"\n')
    replace_once(programs, 'name = "probe"\n', 'name = "probe-mutants"\n')
    replace_once(programs, 'abbe = { path', 'abbe = { package = "abbe-mutants", path')
    replace_once(lock, 'name = "abbe"\n', 'name = "abbe-mutants"\n')
    replace_once(lock, 'name = "abbe-validation"\n', 'name = "abbe-validation-mutants"\n')
    replace_once(lock, ' "abbe",\n', ' "abbe-mutants",\n')
    for name, fault in faults.items():
        for place in (fault, *fault.get("also", ())):
            replace_once(fresh / place["file"], place["old"], "(if crate::planted(\"%s\") { %s } else { %s })" % (name, place["new"], place["old"]))
    library = fresh / "src/lib.rs"
    # The parentheses around what was planted are not needed everywhere.
    library.write_text(library.read_text().replace("\npub mod ", "\n#[allow(unused_parens)]\npub mod ") + SWITCH)
    for path in fresh.rglob("*"):
        if path.is_file():
            copy(path, folder / path.relative_to(fresh))
    shutil.rmtree(fresh)


def cargo(verb, folder):
    """Lets cargo build or check what is planted."""
    command = ["cargo", verb, "--release", "--quiet", "--workspace", "--bin", "abbe-mutants", "--bin", "probe-mutants", "--target-dir", str(ROOT / "target")]
    subprocess.run(command, cwd=folder, check=True)


def check(folder):
    """Whether the faults still are code of the renderer. The message of the compiler tells which is not."""
    plant(folder)
    cargo("check", folder)


def build(folder):
    """The faulty renderer and probe: (binary, probe)."""
    plant(folder)
    cargo("build", folder)
    return ROOT / "target/release/abbe-mutants", ROOT / "target/release/probe-mutants"
