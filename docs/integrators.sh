#!/usr/bin/env bash
# Renders docs/integrators.png: six scenes by both integrators, Whitted's tree on the left of each pair.
# usage: docs/integrators.sh [OUTPUT]    RAYFRAME names the program, default: rayframe. Needs Python with PIL.
set -euo pipefail
cd "$(dirname "$0")/.."
rayframe=${RAYFRAME:-rayframe}
output=${1:-docs/integrators.png}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
count=0
# One scene by both, with the same exposure.
pair() {
    "$rayframe" render "$@" -q -r 320x180 --samples 16 --overwrite -o "$folder/$count.whitted.png" --integrator whitted
    "$rayframe" render "$@" -q -r 320x180 --samples "${SAMPLES:-256}" --overwrite -o "$folder/$count.path.png" --integrator path
    count=$((count + 1))
}

pair scenes/path/box.gltf --env none --exposure 0.5
pair scenes/showcase/apartment.gltf --exposure 3
pair scenes/showcase/helmet.gltf --orbit 25,8 --exposure 0
pair scenes/showcase/character.gltf --animation walk -f 5 --ground --exposure 0
pair scenes/material/nested_glass.gltf --exposure 0
pair scenes/showcase/bottle.gltf --ground --env outdoor --exposure=-1

python3 - "$folder" "$output" <<'PYTHON'
import sys
from PIL import Image

folder, output = sys.argv[1:]
width, height, gap = 320, 180, 4
sheet = Image.new("RGB", (4 * width + 3 * gap + 2 * gap, 3 * height + 2 * gap), "white")
for index in range(6):
    for side, integrator in enumerate(("whitted", "path")):
        column = index % 2 * 2 + side
        x = column * (width + gap) + (2 * gap if column > 1 else 0)
        image = Image.open(f"{folder}/{index}.{integrator}.png").convert("RGB")
        sheet.paste(image, (x, index // 2 * (height + gap)))
sheet.save(output, optimize=True)
PYTHON
