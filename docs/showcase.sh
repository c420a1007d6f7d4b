#!/usr/bin/env bash
# Renders docs/showcase.png: the commands of docs/showcase.md at a small size, as one sheet.
# usage: docs/showcase.sh [OUTPUT]    RAYFRAME names the program, default: rayframe. Needs Python with PIL.
set -euo pipefail
cd "$(dirname "$0")/.."
rayframe=${RAYFRAME:-rayframe}
output=${1:-docs/showcase.png}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
render() { "$rayframe" render "$@" -q -r 480x270 --samples "${SAMPLES:-16}"; }

render scenes/showcase/apartment.gltf --exposure 3 -o "$folder/1.png"
render scenes/showcase/level.gltf -o "$folder/2.png"
render scenes/showcase/helmet.gltf --orbit 25,8 -o "$folder/3.png"
render scenes/showcase/bottle.gltf --background white -o "$folder/4.png"
# Programs without --ground show the character in the studio.
ground=()
if "$rayframe" render --help | grep -q -- '--ground'; then ground=(--ground); fi
render scenes/showcase/character.gltf --animation walk -f 5 "${ground[@]}" -o "$folder/5.png"
# Eight frames of a turn, four a row.
"$rayframe" render scenes/showcase/helmet.gltf -q --turntable 8 -r 240x135 --samples "${SAMPLES:-16}" -o "$folder/turn.####.png"

python3 - "$folder" "$output" <<'PYTHON'
import glob, sys
from PIL import Image

folder, output = sys.argv[1:]
size, gap = (480, 270), 4
turn = Image.new("RGB", size, "white")
for index, name in enumerate(sorted(glob.glob(f"{folder}/turn.*.png"))):
    cell = Image.open(name).convert("RGB").resize((120, 135), box=(60, 0, 180, 135))
    turn.paste(cell, (index % 4 * 120, index // 4 * 135))
cells = [Image.open(f"{folder}/{index}.png").convert("RGB") for index in range(1, 6)] + [turn]
sheet = Image.new("RGB", (3 * size[0] + 2 * gap, 2 * size[1] + gap), "white")
for index, cell in enumerate(cells):
    sheet.paste(cell, (index % 3 * (size[0] + gap), index // 3 * (size[1] + gap)))
sheet.save(output, optimize=True)
PYTHON
