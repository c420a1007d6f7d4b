"""Which edits of glTF assets do the presets of `rayframe diff` fail, and which do other image comparisons?

    cargo build --release
    pip install OpenEXR numpy pillow flip-evaluator OpenImageIO
    npm install --prefix PEERS pixelmatch pngjs odiff-bin @gltf-transform/cli
    python tests/oracles/asset_edits.py target/release/rayframe --peers PEERS [--assets DIR] [--keep DIR] [--only TEXT] [--json FILE]

Renders each asset before and after an edit with the settings of a new suite (`rayframe test --init`) and prints a Markdown table: whether each preset
and each peer fails the pair. asset_edit_list.py has the edits, each with a mark and its reason. Peers that are not installed are skipped, with a
message. Then it prints totals, and how many likely causes are right. The exit code is 1 if the default preset misses a visible edit or fails an
invisible one, or names a wrong cause.
"""

import argparse
import concurrent.futures
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy
from PIL import Image

from asset_edit_list import BORDERLINE, EDITS, INVISIBLE, VISIBLE
from gltf_asset import Asset
from renderers import ASSETS, ASSETS_HELP, display, read_exr

ROOT = pathlib.Path(__file__).resolve().parents[2]
PRESETS = ["exact", "strict", "visual", "noisy"]
DEFAULT = "visual"
# What `rayframe test --init` gives a suite.
SETTINGS = ["-r", "320x180", "--samples", "4", "--aovs", "object_id,material_id"]
# Mean FLIP that fails: what one pixel in a hundred that changes fully gives, the share that Blender's limits admit.
MEAN_FLIP = 0.01
PIXELMATCH = """
import fs from "fs"; import pixelmatch from "pixelmatch"; import { PNG } from "pngjs";
const [a, b] = process.argv.slice(1).map((file) => PNG.sync.read(fs.readFileSync(file)));
console.log(pixelmatch(a.data, b.data, null, a.width, a.height, { threshold: 0.1 }));
"""


class Peers:
    """Comparisons of two PNG files by other programs; each tells whether it fails."""

    def __init__(self, folder):
        self.folder, self.columns = folder, {}
        modules = folder / "node_modules" if folder else None
        if self._has("pixelmatch", modules and (modules / "pixelmatch").exists() and shutil.which("node")):
            self.columns["pixelmatch 0.1"] = self._pixelmatch
        if self._has("odiff", modules and (modules / ".bin/odiff").exists()):
            self.columns["odiff"] = self._odiff
        if self._has("idiff", shutil.which("idiff")):
            self.columns["idiff 0.016, 1 %"] = self._idiff
        try:
            import flip_evaluator
            self._flip_evaluator = flip_evaluator
            self.columns[f"mean FLIP {MEAN_FLIP}"] = self._mean_flip
        except ImportError:
            self._has("flip-evaluator", False)
        tool = modules and modules / ".bin/gltf-transform"
        self.gltf_transform = tool if self._has("gltf-transform", tool and tool.exists()) else None

    @staticmethod
    def _has(name, is_there):
        if not is_there:
            print(f"skipped: {name} is not installed", file=sys.stderr)
        return is_there

    def _pixelmatch(self, actual, reference):
        command = ["node", "--input-type=module", "-e", PIXELMATCH, actual, reference]
        return int(subprocess.run(command, cwd=self.folder, capture_output=True, text=True, check=True).stdout) > 0

    def _odiff(self, actual, reference):
        found = subprocess.run([self.folder / "node_modules/.bin/odiff", actual, reference], capture_output=True, text=True)
        assert found.returncode in (0, 21, 22), found
        return found.returncode != 0

    def _idiff(self, actual, reference):
        command = ["idiff", "-fail", "0.016", "-failpercent", "1", actual, reference]
        found = subprocess.run(command, capture_output=True, text=True)
        assert found.returncode in (0, 1, 2), found
        return found.returncode == 2

    def _mean_flip(self, actual, reference):
        images = [numpy.asarray(Image.open(path)).astype(numpy.float32) / 255 for path in (reference, actual)]
        return self._flip_evaluator.evaluate(*images, "LDR", applyMagma=False)[1] > MEAN_FLIP


def source(edit, assets):
    """The file of an edit's asset: a scene of this project, or a folder of the shared assets."""
    if edit.asset.startswith("scenes/"):
        return ROOT / edit.asset
    for form in ("glTF-Binary/*.glb", "glTF/*.gltf", "glTF-Quantized/*.gltf"):
        for path in sorted((assets / edit.asset).glob(form)):
            return path
    raise SystemExit(f"{assets / edit.asset}: there is no glTF file; {ASSETS_HELP}")


def render(program, scene, frame, output):
    """An EXR file as a suite's reference, and the PNG file that other programs compare: sRGB over black without a tone curve."""
    if not output.exists():
        command = [program, "render", scene, "-o", output, "-f", str(frame), "--overwrite", "-q", *SETTINGS]
        ran = subprocess.run(command, capture_output=True, text=True)
        if ran.returncode:
            raise SystemExit(f"{' '.join(map(str, command))}\n{ran.stderr}")
    png = output.with_suffix(".png")
    Image.fromarray((display(read_exr(output)[0]) * 255 + 0.5).astype(numpy.uint8)).save(png)
    return output, png


def edited(edit, number, scene, folder, peers):
    """The file of the edited asset; `None` where its tool is missing."""
    path = folder / f"edit{number}{edit.suffix}"
    if edit.tool:
        if peers.gltf_transform is None:
            return None
        command = [peers.gltf_transform, *edit.tool, scene, path]
        subprocess.run(command, capture_output=True, check=True)
        return path
    asset = Asset(scene)
    edit.change(asset)
    asset.write(path, reversed(range(len(asset.views))) if edit.is_order_reversed else None)
    return path


def steps(actual, reference):
    """The largest difference of the 8-bit images, and the share of pixels that differ by 3 steps or more."""
    pair = [numpy.asarray(Image.open(path)).astype(int) for path in (actual, reference)]
    difference = numpy.abs(pair[0] - pair[1]).max(axis=-1)
    return int(difference.max()), float((difference >= 3).mean())


def measure(number, edit, options, folder, peers):
    """A dictionary of everything that is measured of one edit."""
    scene = source(edit, options.assets)
    name = f"{edit.asset.replace('/', '_')}.{edit.frame}.{number}"
    changed = edited(edit, number, scene, folder, peers)
    if changed is None:
        return None
    reference = render(options.program, scene, edit.frame, folder / f"{name}.before.exr")
    actual = render(options.program, changed, edit.frame, folder / f"{name}.after.exr")
    result = {"steps": steps(actual[1], reference[1]), "fails": {}, "reports": {}}
    for preset in options.presets:
        command = [options.program, "diff", actual[0], reference[0], "--preset", preset, "--json"]
        report = json.loads(subprocess.run(command, capture_output=True, text=True).stdout)
        result["fails"][preset], result["reports"][preset] = not report["same"], report["frames"][0]
    for column, compare in peers.columns.items():
        result["fails"][column] = compare(actual[1], reference[1])
    return result


def cause_verdict(edit, result):
    """Whether the likely cause of a failure under the default preset is `right`, `wrong` or `unclear`; empty where it passes."""
    if not result["fails"][DEFAULT]:
        return ""
    cause = result["reports"][DEFAULT]["cause"]
    if cause is None or cause["kind"] in ("unclear", "material_or_light"):
        return "unclear"
    accepted = {"surface": ("geometry", "material")}.get(edit.cause, (edit.cause,))
    return "right" if cause["kind"] in accepted else "wrong"


def print_table(rows, columns):
    print(f"| edit | asset | mark: reason | largest step, ≥ 3 steps | {' | '.join(columns)} | FLIP mean, tile, object | cause |")
    print("|---" * (len(columns) + 6) + "|")
    for edit, result in rows:
        flip = result["reports"][DEFAULT]["flip"]
        in_object = flip.get("object")
        largest, share = result["steps"]
        fails = " | ".join("**fails**" if result["fails"][column] else "passes" for column in columns)
        numbers = f"{flip['mean']:.4f}, {flip['tile']:.4f}, {in_object['mean'] if in_object else 0:.4f}"
        asset = pathlib.PurePath(edit.asset).stem
        print(f"| {edit.name} | {asset} | {edit.mark}: {edit.reason} | {largest}, {share * 100:.1f} % | {fails} | {numbers} |"
              f" {cause_verdict(edit, result)} |")


def print_totals(rows, columns):
    print(f"\n| | {' | '.join(columns)} |\n|---{'|---' * len(columns)}|")
    for label, mark, is_failure in (
        ("visible caught", VISIBLE, True), ("visible missed", VISIBLE, False), ("invisible failed", INVISIBLE, True),
        ("invisible passed", INVISIBLE, False), ("borderline failed", BORDERLINE, True), ("borderline passed", BORDERLINE, False),
    ):
        counts = [sum(edit.mark == mark and result["fails"][column] == is_failure for edit, result in rows) for column in columns]
        print(f"| {label} | {' | '.join(map(str, counts))} |")
    verdicts = [cause_verdict(edit, result) for edit, result in rows]
    counts = ", ".join(f"{verdicts.count(word)} {word}" for word in ("right", "wrong", "unclear"))
    print(f"\nlikely causes of failures under `{DEFAULT}`: {counts}")
    return verdicts.count("wrong")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=lambda path: pathlib.Path(path).resolve())
    parser.add_argument("--assets", type=pathlib.Path, default=ASSETS, help=ASSETS_HELP)
    parser.add_argument("--peers", type=lambda path: pathlib.Path(path).resolve(), help="folder with node_modules")
    parser.add_argument("--keep", type=pathlib.Path, help="folder to keep renders in; existing ones are not rendered again")
    parser.add_argument("--only", default="", help="edits whose names contain this")
    parser.add_argument("--presets", nargs="+", default=PRESETS)
    parser.add_argument("--json", type=pathlib.Path, help="file for all measures")
    options = parser.parse_args()
    peers = Peers(options.peers)
    with tempfile.TemporaryDirectory() as temporary:
        folder = (options.keep or pathlib.Path(temporary)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        chosen = [(number, edit) for number, edit in enumerate(EDITS) if options.only in edit.name]
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            results = list(pool.map(lambda item: measure(*item, options, folder, peers), chosen))
    rows = [(edit, result) for (_, edit), result in zip(chosen, results) if result is not None]
    columns = options.presets + list(peers.columns)
    print_table(rows, columns)
    wrong = print_totals(rows, columns)
    if options.json:
        items = [{"edit": edit.name, "asset": edit.asset, "mark": edit.mark, "cause": edit.cause, **result} for edit, result in rows]
        options.json.write_text(json.dumps(items))
    wanted = {VISIBLE: True, INVISIBLE: False}
    mistakes = sum(result["fails"][DEFAULT] != wanted.get(edit.mark, result["fails"][DEFAULT]) for edit, result in rows)
    sys.exit(1 if mistakes or wrong else 0)


if __name__ == "__main__":
    main()
