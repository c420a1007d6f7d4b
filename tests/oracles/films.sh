#!/usr/bin/env bash
# Movies as ffmpeg reads them: makes one of each format with `-o` and compares number of frames, size, duration and the first
# frame with the PNG frames. Usage: films.sh [RAYFRAME]. Without ffmpeg and ffprobe it says so and ends with 0.
set -euo pipefail

root=$(cd "$(dirname "$0")/../.." && pwd)
rayframe=$(realpath "${1:-$root/target/debug/rayframe}")
for tool in ffmpeg ffprobe; do
    if ! command -v "$tool" >/dev/null; then
        echo "films.sh: SKIPPED, $tool is not installed: no movie was checked"
        exit 0
    fi
done

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
frames=8
width=64
height=36
options=(render "$root/scenes/animation/hierarchy.gltf" --turntable "$frames" --fps 24 -r "${width}x$height" --samples 1 --depth 1
    --exposure 0 --quiet)
mkdir "$folder/png"
"$rayframe" "${options[@]}" -o "$folder/png/f.####.png"

# Mean absolute difference of the first frames, of 255. ffmpeg before 7.1 reads no animated WebP; Pillow does.
difference() {
    ffmpeg -nostdin -loglevel error -i "$1" -frames:v 1 -f rawvideo -pix_fmt rgb24 "$folder/film.rgb" -y
    ffmpeg -nostdin -loglevel error -i "$folder/png/f.0000.png" -f rawvideo -pix_fmt rgb24 "$folder/png.rgb" -y
    python3 - "$folder/film.rgb" "$folder/png.rgb" <<'PY'
import sys
film, png = (open(name, "rb").read() for name in sys.argv[1:])
assert len(film) == len(png), f"{len(film)} bytes instead of {len(png)}"
print(sum(abs(a - b) for a, b in zip(film, png)) / len(png))
PY
}

webp() {
    python3 - "$1" "$folder/png" <<'PY'
import sys
from PIL import Image
film = Image.open(sys.argv[1])
assert film.format == "WEBP" and film.info.get("loop") == 0, film.info
milliseconds = 0
for index in range(film.n_frames):
    film.seek(index)
    film.load()
    milliseconds += film.info["duration"]
    png = Image.open(f"{sys.argv[2]}/f.{index:04}.png").convert("RGBA")
    assert film.convert("RGBA").tobytes() == png.tobytes(), f"frame {index} differs"
print(film.n_frames, *film.size, milliseconds / 1000, 0.0)
PY
}

# Read frames, columns, rows, seconds and difference of a movie.
measure() {
    if [[ $1 == *.webp ]]; then
        webp "$1"
        return
    fi
    local read
    read=$(ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames,width,height -of csv=p=0:s=x "$1" | tr -d "\n")
    # The duration of animated PNG is not in its header: time of the last frame and its duration.
    local seconds
    seconds=$(ffprobe -v error -select_streams v -show_entries packet=pts_time,duration_time -of csv=p=0 "$1" |
        awk -F, -v rate=24 '{ end = $1 + ($2 > 0 ? $2 : 1 / rate) } END { print end }')
    local columns rows count
    IFS=x read -r columns rows count <<<"$read"
    echo "$count $columns $rows $seconds $(difference "$1")"
}

failed=0
# Format, and the greatest mean difference of the first frame: lossless, 256 colours, lossy.
for case in apng:0 webp:0 gif:6 mp4:4 mov:4 mkv:4 webm:4; do
    format=${case%:*}
    mkdir "$folder/$format"
    film=$folder/$format/film.$format
    "$rayframe" "${options[@]}" -o "$film"
    left=$(ls -A "$folder/$format")
    measured=$(if [[ $format == webp ]] && ! python3 -c 'import PIL' 2>/dev/null; then echo skip; else measure "$film"; fi)
    if [[ $measured == skip ]]; then
        echo "$format: SKIPPED, Python has no Pillow"
        continue
    fi
    verdict=$(awk -v frames=$frames -v width=$width -v height=$height -v most="${case#*:}" '{
        duration = $4 - frames / 24
        ok = $1 == frames && $2 == width && $3 == height && duration < 0.011 && duration > -0.011 && $5 <= most
        print (ok ? "ok" : "FAILED")
    }' <<<"$measured")
    [[ $left == "film.$format" ]] || verdict="FAILED, the folder holds $left"
    echo "$format: $verdict (frames, width, height, seconds, difference: $measured)"
    [[ $verdict == ok ]] || failed=1
done
exit $failed
