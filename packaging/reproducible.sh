#!/bin/sh
# Builds the program twice, from two copies of the commit in folders of different names, and compares the files.
#
#   packaging/reproducible.sh [--target TRIPLE] [FOLDER]
#
# FOLDER (a new temporary folder unless given) holds `one` and `two other` afterwards. Ends with 1 where the files differ.
set -eu
target=
if [ "${1-}" = --target ]; then
    target=${2:?is missing: --target TRIPLE}
    shift 2
fi
folder=${1:-$(mktemp -d)}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
root=$(git -C "$(dirname "$0")" rev-parse --show-toplevel)
cargo_home=${CARGO_HOME:-$HOME/.cargo}
# The commit stays the same where another one is made meanwhile.
commit=$(git -C "$root" rev-parse HEAD)
epoch=$(git -C "$root" log -1 --format=%ct "$commit")

build() {
    mkdir -p "$1"
    git -C "$root" archive "$commit" | tar -x -C "$1"
    # Paths of the checkout and of the crates reach messages of panics. Flags hold spaces, so they are separated by 0x1f.
    flags=$(printf -- '--remap-path-prefix=%s=/rayframe\037--remap-path-prefix=%s=/cargo' "$1" "$cargo_home")
    (cd "$1" && CARGO_ENCODED_RUSTFLAGS=$flags SOURCE_DATE_EPOCH=$epoch CARGO_TARGET_DIR="$1/target" \
        cargo build --release --locked --bin rayframe ${target:+--target "$target"})
}

for name in one "two other"; do
    build "$folder/$name"
done
one=$folder/one/target/${target:+$target/}release/rayframe
two="$folder/two other/target/${target:+$target/}release/rayframe"
sha256sum "$one" "$two"
if cmp "$one" "$two"; then
    echo "both builds have the same bytes"
else
    exit 1
fi
