#!/usr/bin/env bash
# Compares renders on other processors with native ones, byte for byte: emulated processors without AVX, and other variants of the
# platform's mathematics library. Needs Debian's qemu-user; not part of the default tests.
# Run from the project's root: tests/oracles/other_processors.sh [SCENE…]
set -euo pipefail

scenes=("$@")
[ ${#scenes[@]} -gt 0 ] || scenes=(scenes/demo/whitted_1980.gltf scenes/material/nested_glass.gltf scenes/bvh/slivers.gltf
    scenes/texture/transform.gltf scenes/skin/many_influences.gltf scenes/animation/cubic_quaternion.gltf)
cargo build -q --release
program=target/release/rayframe
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
different=0

render() { # NAME SCENE PREFIX…
    local output=$folder/$1.exr scene=$2
    shift 2
    # The emulator warns about processor features that the program does not use.
    "$@" "$program" render "$scene" -o "$output" -f 5 -r 64x36 --samples 1 -q --overwrite 2> "$folder/messages" ||
        { cat "$folder/messages"; exit 1; }
}

for scene in "${scenes[@]}"; do
    render native "$scene" env
    render nehalem "$scene" qemu-x86_64 -cpu Nehalem
    render haswell "$scene" qemu-x86_64 -cpu Haswell
    render tuned "$scene" env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F
    for other in nehalem haswell tuned; do
        if cmp -s "$folder/native.exr" "$folder/$other.exr"; then
            echo "same       $other  $scene"
        else
            echo "DIFFERENT  $other  $scene"
            different=1
        fi
    done
done
exit $different
