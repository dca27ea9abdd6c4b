#!/bin/sh
# A release build that the compiler fits to this processor and to what renders do. The pictures have the same bits,
# and take less time.
#
#   sh contrib/profile-guided.sh           # writes target/profile-guided/release/abbe
#
# It builds abbe twice, and renders scenes of different kinds in between: some ten minutes on two cores.
# It needs rustup, and the toolchain's llvm-tools, which it installs.
set -eu
cd "$(dirname "$0")/.."
rustup component add llvm-tools
tools=$(rustc --print target-libdir)/../bin
work=$(pwd)/target/profile-guided
profiles=$work/profiles
# The variable would take the place of the flags in .cargo/config.toml; these are added to them, and the last holds.
unset RUSTFLAGS
build() {
    flags="['-C', 'target-cpu=native', '-C', '$1']"
    cargo build --release --config "target.'cfg(all())'.rustflags = $flags" --target-dir "$2"
}
rm -rf "$profiles"
mkdir -p "$profiles"

build "profile-generate=$profiles" "$work/measured"
for scene in box metals caustic sphereflake shapes doublet coloured-glass gem fluorescent cloud marble effects/gloss; do
    for estimator in shared plain; do
        "$work/measured/release/abbe" render "scenes/$scene/scene.xml" --size 192x144 --spp 16 --estimator $estimator \
            --no-png -q -o "$profiles/picture.exr"
    done
done
"$tools/llvm-profdata" merge -o "$profiles/abbe.profdata" "$profiles"/*.profraw

build "profile-use=$profiles/abbe.profdata" "$work"
echo "$work/release/abbe"
