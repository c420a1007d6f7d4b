"""Drives the HTML report in headless Chromium: images, slider, flicker, exposure, graph, keys and approvals.

    cargo build --release
    apt-get install chromium
    pip install playwright OpenEXR numpy pillow
    python tests/oracles/report_in_browser.py [target/release/rayframe] [report.html of `rayframe test`] [folder for screenshots] \
        [folder of that suite]

Renders a pair and a sequence that differ, writes their pages with `rayframe diff --report`, and compares what their canvases hold
with numbers made here from the EXR files. Approvals are checked on the page of a suite where one is given, and otherwise on a page of
our own whose data are changed to allow them. Where the suite's folder is given, too, the command that its page shows is run on a copy of
it, from elsewhere; its images must still be pending there. Prints a line a check and ends with 1 when one does not hold. Nothing may be asked of
the network, and the console must stay empty. No browser is downloaded: the system's Chromium is used (CHROMIUM names another).
"""

import base64
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile

import numpy
import OpenEXR
from PIL import Image
from playwright.sync_api import sync_playwright

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "target/release/rayframe").resolve()
SUITE = pathlib.Path(sys.argv[2]).resolve() if len(sys.argv) > 2 and sys.argv[2] else None
SHOTS = pathlib.Path(sys.argv[3] if len(sys.argv) > 3 else ROOT / "target/report_in_browser").resolve()
SUITE_FOLDER = pathlib.Path(sys.argv[4]).resolve() if len(sys.argv) > 4 else None
SIZE = "192x108"
FOLDER = pathlib.Path(tempfile.mkdtemp(prefix="rayframe-report-"))
failures = []


def check(name, holds, detail=""):
    print(("ok   " if holds else "FAIL ") + name + (": " + " ".join(str(detail).split()) if detail != "" else ""), flush=True)
    if not holds:
        failures.append(name)


def rayframe(*arguments, codes=(0,)):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, cwd=FOLDER)
    if done.returncode not in codes:
        sys.exit(f"{arguments}: {done.returncode} {done.stderr}")
    return done.stdout


def render(scene, target, *options):
    rayframe("render", ROOT / "scenes" / scene, "-o", target, "-r", SIZE, "-q", "--overwrite", *options)


def make_pages():
    """A pair whose light is four times as strong, and a sequence of which frames 3 and 4 are brighter and 6 is lost."""
    render("light/point.gltf", "old.exr", "-f", 0, "--layers", "depth,albedo,node_id")
    render("light/point.gltf", "new.exr", "-f", 0, "--layers", "depth,albedo,node_id", "--light-scale", 4)
    scene = "demo/whitted_1980.gltf"
    render(scene, "old/a.####.exr", "-f", "0-7")
    render(scene, "new/a.####.exr", "-f", "0-7")
    render(scene, "new/a.####.exr", "-f", "3", "--light-scale", 1.3)
    render(scene, "new/a.####.exr", "-f", "4", "--light-scale", 1.8)
    (FOLDER / "new/a.0006.exr").unlink()
    write_png("old.png", numpy.tile(numpy.arange(256, dtype=numpy.uint8), (64, 1)))
    write_png("new.png", numpy.tile(numpy.arange(256, dtype=numpy.uint8)[::-1], (64, 1)))
    write_png("small.png", numpy.full((40, 100), 120, dtype=numpy.uint8))
    broken = halves(FOLDER / "old.exr").astype(numpy.float32)
    broken[5, 7] = [numpy.nan, 0, 0]
    broken[5, 8] = [numpy.inf, 0, 0]
    OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGB": broken}).write(str(FOLDER / "broken.exr"))
    rayframe("diff", "new.exr", "old.exr", "--report", "pair", codes=(1,))
    rayframe("diff", "new.png", "old.png", "--report", "display", codes=(1,))
    rayframe("diff", "small.png", "old.png", "--report", "sizes", codes=(1,))
    rayframe("diff", "old.png", "small.png", "--report", "larger", codes=(1,))
    # More columns than a canvas of Chromium has.
    for name, grey in (("wide_old.png", 50), ("wide_new.png", 200)):
        write_png(name, numpy.full((2, 70000), grey, dtype=numpy.uint8))
    rayframe("diff", "wide_new.png", "wide_old.png", "--report", "wide", codes=(1,))
    rayframe("diff", "broken.exr", "old.exr", "--layers", "beauty", "--report", "broken", codes=(1,))
    rayframe("diff", "new", "old", "--report", "sequence", codes=(1,))
    rayframe("diff", "old", "old", "--report", "same")


def write_png(name, grey):
    Image.fromarray(numpy.stack([grey, 255 - grey, grey // 2], axis=-1)).save(FOLDER / name)


def allow_approvals(page, target):
    """The page of a sequence as a suite would write it: with hashes, and approvals allowed."""
    text = page.read_text()
    found = re.search(r'(<script type="application/json" id="data">)(.*?)(</script>)', text, re.S)
    data = json.loads(found[2])
    data["can_approve"] = True
    data["accept_command"] = "rayframe accept --approvals approvals.json --suite sequence"
    for shot in data["shots"]:
        for frame in shot["frames"]:
            if frame["status"] in ("different", "missing"):
                frame["hash"] = hashlib.sha256(frame["name"].encode()).hexdigest()
    other = json.loads(json.dumps(data["shots"][0]["frames"][3]))
    other.update(name="z/broken<b>", status="broken", frame=None, messages=["cannot be rendered </script><script>alert(1)</script>"])
    data["shots"].append({**data["shots"][0], "name": "z/broken<b>", "frames": [other], "worst": 0})
    target.write_text(text[: found.start(2)] + json.dumps(data).replace("<", "\\u003c") + text[found.end(2) :])


def halves(path):
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = file.channels()
        return numpy.stack([channels[name].pixels.astype(numpy.float64) for name in "RGB"], axis=-1)


def shown(light, stops=0.0):
    light = numpy.clip(light * 2.0**stops, 0, 1)
    encoded = numpy.where(light <= 0.0031308, light * 12.92, 1.055 * light ** (1 / 2.4) - 0.055)
    return numpy.floor(encoded * 255 + 0.5).astype(int)


class Page:
    """A page that was opened, with what it asked for and complained of."""

    def __init__(self, browser, path, name, script="", **options):
        self.name = name
        self.context = browser.new_context(viewport={"width": 1360, "height": 900}, accept_downloads=True, **options)
        self.page = self.context.new_page()
        self.page.add_init_script(script)
        self.address = path.as_uri()
        self.requests, self.errors = [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("console", lambda message: self.errors.append(message.text))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.goto(self.address)
        self.wait_until_idle()

    def wait_until_idle(self):
        self.page.wait_for_timeout(250)

    def canvas(self, index=0):
        """The pixels of a canvas of the stage."""
        size, data = self.page.evaluate(
            """(index) => {
                const canvas = document.querySelectorAll("#stage canvas")[index];
                const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
                let text = "";
                for (let at = 0; at < data.length; at += 4096) text += String.fromCharCode(...data.subarray(at, at + 4096));
                return [[canvas.height, canvas.width], btoa(text)];
            }""",
            index,
        )
        pixels = numpy.frombuffer(base64.b64decode(data), dtype=numpy.uint8)
        return pixels.reshape(size[0], size[1], 4)[:, :, :3].astype(int)

    def press(self, *keys):
        for key in keys:
            self.page.keyboard.press(key)
        self.wait_until_idle()

    def text(self, selector):
        return self.page.locator(selector).inner_text()

    def close(self):
        outside = [url for url in self.requests if url != self.address and not url.startswith(("data:", "blob:"))]
        check(f"{self.name}: nothing is asked of the network", outside == [], outside or "")
        check(f"{self.name}: the console is empty", self.errors == [], self.errors or "")
        self.context.close()


def check_pair(browser, folder):
    old, new = halves(folder / "old.exr"), halves(folder / "new.exr")
    page = Page(browser, folder / "pair/index.html", "pair", color_scheme="light")
    check("a single failure is shown at once", page.page.locator("#failure").is_visible())
    check("expected is shown as computed here", (page.canvas(0) == shown(old)).all())
    check("actual is shown as computed here", (page.canvas(1) == shown(new)).all())
    page.page.screenshot(path=SHOTS / "pair_light.png")
    check_exposure(page, old, new)
    check_slider(page, old, new)
    check_flicker(page, old, new)
    page.press("4")
    heat = page.canvas()
    check("the heat map has colours of magma", len(numpy.unique(heat.reshape(-1, 3), axis=0)) > 20 and heat.max() > 200)
    dark = (old == new).all(axis=2)
    check("the heat map is darker where nothing differs", heat[dark].mean() < heat[~dark].mean(), f"{heat[dark].mean():.1f} < {heat[~dark].mean():.1f}")
    page.page.screenshot(path=SHOTS / "heat_light.png")
    page.press("5")
    off = numpy.abs(page.canvas() - shown(numpy.abs(old - new), 3))
    check("the difference is that of light, 8 times", off.max() <= 1, f"at most {off.max()} of 255 steps off")
    page.page.screenshot(path=SHOTS / "difference_light.png")
    marks = page.page.locator(".mark").count()
    page.press("m")
    check("the worst place is marked and the mark goes", marks > 0 and page.page.locator(".mark").count() == 0, marks)
    page.press("m", "i")
    check("i inspects the worst place", re.search(r"column \d+ +row \d+", page.text("#inspector")) is not None)
    before = page.text("#inspector")
    page.press("ArrowRight", "Shift+ArrowDown")
    check("arrow keys move the inspected pixel", page.text("#inspector") != before)
    column, row = map(int, re.search(r"column (\d+) +row (\d+)", page.text("#inspector")).groups())
    told = re.search(r"expected +(\S+) +(\S+) +(\S+)", page.text("#inspector")).groups()
    values = [float(value) for value in told]
    check("the inspector tells the file's values", numpy.allclose(values, old[row, column], rtol=5e-3, atol=6e-5), f"{values} {old[row, column]}")
    page.press("z", "z", "z")
    box = page.page.locator("#stage canvas").first.bounding_box()
    check("zoom 4", abs(box["width"] - 4 * old.shape[1]) < 1, box["width"])
    page.press("1")
    page.page.evaluate("document.querySelectorAll('.port')[0].scrollTo(60, 40)")
    page.wait_until_idle()
    places = page.page.evaluate("[...document.querySelectorAll('.port')].map((port) => [port.scrollLeft, port.scrollTop])")
    check("both images scroll together", places[0] == places[1] and places[0][0] == 60, places)
    page.page.screenshot(path=SHOTS / "zoom_light.png")
    page.press("Shift+?")
    check("? opens the keys", page.page.locator("#help").is_visible())
    page.page.screenshot(path=SHOTS / "keys_light.png")
    page.press("Escape")
    page.close()


def check_other_images(browser, folder):
    old, new = (numpy.asarray(Image.open(folder / name)).astype(int) for name in ("old.png", "new.png"))
    page = Page(browser, folder / "display/index.html", "display", color_scheme="light")
    check("images for displays are shown as they are", (page.canvas(0) == old).all() and (page.canvas(1) == new).all())
    encoded = old / 255
    light = numpy.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    page.press("-")
    # Halves next to 1 are 1/2048 apart, so they are up to 1/16 of a step of 255 off.
    off = numpy.abs(page.canvas(0) - shown(light, -1))
    check("exposure works on their light", off.max() <= 1 and (off > 0).mean() < 1 / 16, f"{(off > 0).mean():.4f} are a step off")
    page.close()
    page = Page(browser, folder / "sizes/index.html", "sizes", color_scheme="light")
    small = numpy.asarray(Image.open(folder / "small.png")).astype(int)
    check("other sizes stand side by side", page.canvas(0).shape == old.shape and (page.canvas(1) == small).all())
    check("and have no difference", page.page.locator("#modes button:disabled").all_inner_texts() == ["Heat map", "Difference"])
    page.press("2", ".", "3", "f")
    check("the larger size holds both", page.canvas().shape == old.shape)
    page.close()
    page = Page(browser, folder / "larger/index.html", "larger", color_scheme="light")
    box = page.page.locator("#stage canvas").nth(1).bounding_box()
    page.page.mouse.move(box["x"] + box["width"] - 1, box["y"] + box["height"] - 1)
    page.wait_until_idle()
    height, width, _ = old.shape
    told = page.text("#inspector")
    check("beyond the smaller one the larger is inspected", f"column {width - 1}" in told and re.search(r"expected +none", told) is not None, told)
    rings = page.page.locator("#stage .cross").evaluate_all("(rings) => rings.map((ring) => ring.hidden)")
    check("and only it is marked", rings == [True, False], rings)
    page.close()
    page = Page(browser, folder / "broken/index.html", "broken", color_scheme="light")
    magenta = numpy.argwhere((page.canvas(1) == [255, 0, 255]).all(axis=2)).tolist()
    check("what is not finite is magenta", magenta == [[5, 7], [5, 8]], magenta)
    check("and is told", "1 value of R is not a number and 1 infinite" in page.text("#messages"))
    page.close()


def check_too_large(browser, folder):
    page = Page(browser, folder / "wide/index.html", "wide", color_scheme="light")
    told = page.page.locator("#stage .note").all_inner_texts()
    check("a image beyond the browser's limit is told in words", len(told) == 2 and all("70000 by 2 pixels" in text for text in told), told)
    page.press("3", "2", "+", "4", "5", "z", "m")
    check("in every view", page.page.locator("#stage .note").count() == 1)
    page.page.screenshot(path=SHOTS / "wide_light.png")
    page.errors = [error for error in page.errors if "InvalidStateError" not in error]
    page.close()
    page = Page(browser, folder / "pair/index.html", "no canvas", script="HTMLCanvasElement.prototype.getContext = () => null")
    check("a browser without canvases says so, too", page.page.locator("#stage .note").count() == 2)
    page.errors = [error for error in page.errors if "null" not in error]
    page.close()


def check_left_out(browser, path, target):
    """The same page with omitted images: the worst frame exceeds the budget, another one comes after others."""
    text = re.sub(r'(<script type="text/plain" id="image-\d+">).*?(</script>)', "", path.read_text(), flags=re.S)
    found = re.search(r'(<script type="application/json" id="data">)(.*?)(</script>)', text, re.S)
    data = json.loads(found[2])
    for frame in data["shots"][0]["frames"]:
        if frame["actual"] or frame["expected"]:
            omitted = {"why": "no_space", "command": "rayframe diff alone"} if frame["frame"] == 3 else {"why": "too_large", "command": None}
            if frame["frame"] == 4:
                omitted["command"] = "rayframe diff --heat-map heat.png"
            frame.update(omitted=omitted, actual=None, expected=None, errors=None)
            data["omitted"] += 1
    target.write_text(text[: found.start(2)] + json.dumps(data).replace("<", "\\u003c") + text[found.end(2) :])
    page = Page(browser, target, "omitted", color_scheme="light")
    told = page.text("#no-images")
    check("a frame that is too large says so and names the heat map", "they alone exceed the 64 MiB" in told and "--heat-map" in told, told)
    page.press("ArrowLeft")
    told = page.text("#no-images")
    check("an omitted frame names what shows it alone", "those of other frames" in told and "rayframe diff alone" in told, told)
    page.press("Shift+ArrowRight", "Shift+ArrowRight")
    told = page.text("#no-images")
    check("where nothing shows it no command is named", "they alone" in told and page.page.locator("#no-images code").count() == 0, told)
    page.press("g")
    check("the overview counts it", "3 frames are omitted" in page.text("#overview-note"), page.text("#overview-note"))
    page.close()


def check_exposure(page, old, new):
    bright = (new > 1).any(axis=2)
    check("there is light above 1", bright.sum() > 20, bright.sum())
    page.press("Shift++")
    check("one stop up doubles the light", (page.canvas(1) == shown(new, 1)).all() and page.text("#stops-text") == "+1.00 stops")
    page.press("0", "-", "-")
    canvas = page.canvas(1)
    check("two stops down shows light above 1", (canvas == shown(new, -2)).all() and (canvas[bright] < 255).any(), canvas[bright].min())
    page.page.locator("#stops").fill("0.25")
    page.wait_until_idle()
    check("a quarter of a stop", (page.canvas(0) == shown(old, 0.25)).all())
    page.press("0")
    check("0 resets it", (page.canvas(1) == shown(new)).all())


def check_slider(page, old, new):
    page.press("2")
    width, middle = old.shape[1], page.canvas()
    half = width // 2
    check("the slider begins in the middle", (middle[:, :half] == shown(old)[:, :half]).all() and (middle[:, half:] == shown(new)[:, half:]).all())
    box = page.page.locator("#stage canvas").bounding_box()
    x, y = box["x"], box["y"] + box["height"] / 2
    page.page.mouse.move(x + box["width"] * 0.5, y)
    page.page.mouse.down()
    page.page.mouse.move(x + box["width"] * 0.75, y, steps=4)
    page.page.mouse.up()
    page.wait_until_idle()
    moved, place = page.canvas(), width * 3 // 4
    changed = numpy.flatnonzero((moved != middle).any(axis=(0, 2)))
    check("moved to the right it changes that part alone", changed.size > 0 and half <= changed.min() and changed.max() < place, f"columns {changed.min()} to {changed.max()} of {width}")
    check("and shows expected there", (moved[:, :place] == shown(old)[:, :place]).all())
    page.page.screenshot(path=SHOTS / "slider_light.png")
    page.page.locator("#wipe").focus()
    page.press("Home")
    check("the slider works by keys", (page.canvas() == shown(new)).all())
    page.press(".")
    check("so does the key .", (page.canvas()[:, 0] == shown(old)[:, 0]).all() and (page.canvas()[:, 10] == shown(new)[:, 10]).all())
    page.page.evaluate("document.activeElement.blur()")


def check_flicker(page, old, new):
    page.press("3")
    rate = page.page.locator("#rate")
    check("flicker stays below three flashes a second, and says so", rate.get_attribute("max") == "3" and "at most 3" in rate.get_attribute("title"))
    rate.fill("3")
    seen = set()
    for _ in range(20):
        canvas, label = page.canvas(), page.text(".pane-label strong")
        kind = "expected" if (canvas == shown(old)).all() else "actual" if (canvas == shown(new)).all() else "neither"
        seen.add(kind)
        page.page.wait_for_timeout(63)
    check("flicker alternates", seen == {"expected", "actual"}, seen)
    page.page.evaluate("document.activeElement.blur()")
    page.press("f")
    before = page.text(".pane-label strong")
    page.page.wait_for_timeout(400)
    check("f stops it", page.text(".pane-label strong") == before)
    page.press("Space")
    check("Space swaps", page.text(".pane-label strong") != before)


def check_sequence(browser, folder):
    page = Page(browser, folder / "sequence/index.html", "sequence", color_scheme="dark")
    new = halves(folder / "new/a.0004.exr")
    check("the worst frame comes first", page.text(".graph-shown").startswith("frame 4"), page.text(".graph-shown"))
    page.press("Shift+ArrowRight")
    check("a lost frame shows the reference alone", page.page.locator("#stage canvas").count() == 1 and page.page.locator("#modes button:disabled").count() == 4)
    slider = page.page.locator(".graph [role=slider]")
    box = slider.bounding_box()
    page.page.mouse.click(box["x"] + 52 + (box["width"] - 60) * 4.5 / 8, box["y"] + 60)
    page.wait_until_idle()
    check("a click on the graph chooses the frame", page.text(".graph-shown").startswith("frame 4"), page.text(".graph-shown"))
    check("and shows it", (page.canvas(1) == shown(new)).all())
    page.page.screenshot(path=SHOTS / "sequence_dark.png", full_page=True)
    page.press("ArrowLeft")
    check("the left key goes to frame 3", page.text(".graph-shown").startswith("frame 3"))
    page.press("ArrowLeft")
    check("a frame that passes has numbers alone", page.page.locator("#no-images").is_visible() and page.page.locator("#measures tbody tr").count() > 0)
    page.press("Shift+ArrowRight", "Shift+ArrowRight", "Shift+ArrowRight")
    check("Shift and right go from failure to failure", page.text(".graph-shown").startswith("frame 6"))
    check("failing frames are marked", page.page.locator(".point.fails").count() == 4 and page.page.locator(".absent").count() == 2)
    check("the limits are lines", page.page.locator(".graph .limit").count() == 2)
    check("the page names its frame", "a.0006" in page.page.url)
    page.press("g")
    check("g shows the overview", page.page.locator("#overview").is_visible())
    page.page.screenshot(path=SHOTS / "overview_dark.png")
    page.close()


def check_keyboard(browser, path):
    """From the page's beginning by the keyboard alone."""
    page = Page(browser, path, "keyboard", color_scheme="dark", reduced_motion="reduce")
    page.press("g", "j")
    check("j shows the first failure", page.page.locator("#failure").is_visible())
    seen = []
    for _ in range(60):
        page.page.keyboard.press("Tab")
        seen.append(page.page.evaluate("document.activeElement.id || document.activeElement.textContent"))
    wanted = ["filter", "Side by side", "stops", "Fit", "marker-toggle", "stage", "Copy"]
    check("the tab key reaches everything", all(name in seen for name in wanted), [name for name in wanted if name not in seen] or "")
    page.page.evaluate("document.activeElement.blur()")
    page.press("3")
    before = page.text(".pane-label strong")
    page.page.wait_for_timeout(700)
    check("with reduced motion flicker does not start by itself", page.text(".pane-label strong") == before)
    page.press("/")
    page.page.keyboard.type("nothing has this name")
    page.wait_until_idle()
    check("/ filters", page.page.locator("#shots li").count() == 0 and page.page.locator("#shots-none").is_visible())
    page.press("Escape")
    check("Escape clears the filter", page.page.locator("#shots li").count() > 0)
    page.press("t", "t")
    check("t changes the theme", page.page.evaluate("document.documentElement.dataset.theme") == "dark")
    page.close()


def approve_first(page, shots):
    """Goes down the list to what can be approved, and approves it."""
    page.press("g")
    for _ in range(shots):
        page.press("j")
        if page.page.locator("#approve-frame").is_enabled():
            break
    page.press("a")


def check_memory(page, path, data):
    """Ticks are of one page, and of the images that were seen: `page` has one tick."""
    other = FOLDER / "elsewhere" / path.name
    other.parent.mkdir()
    shutil.copy(path, other)
    page.page.goto(other.as_uri())
    page.wait_until_idle()
    check("a page of the same name elsewhere has ticks of its own", page.text("#approved-count").startswith("0 of"), page.text("#approved-count"))
    page.page.locator("#approve-shown").click()
    page.page.reload()
    page.wait_until_idle()
    count = int(page.text("#approved-count").split()[0])
    changed = next(frame for shot in data["shots"] for frame in shot["frames"] if frame["status"] in ("different", "missing") and frame["hash"])
    other.write_text(other.read_text().replace(changed["hash"], "0" * 64))
    page.page.reload()
    page.wait_until_idle()
    check("a tick does not survive another image", page.text("#approved-count").startswith(f"{count - 1} of"), page.text("#approved-count"))
    other.write_text(other.read_text().replace("0" * 64, changed["hash"]))
    page.page.reload()
    page.wait_until_idle()
    check("and does not come back", page.text("#approved-count").startswith(f"{count - 1} of"), page.text("#approved-count"))
    page.requests = [url for url in page.requests if url != other.as_uri()]
    page.page.goto(page.address)
    page.wait_until_idle()
    check("and the ticks of the first page are as they were", page.text("#approved-count").startswith("1 of"), page.text("#approved-count"))


def check_accepted(command, exported, images):
    """Types the command in a folder of its own, for a copy of the suite."""
    here, copy = FOLDER / "typed_here", FOLDER / "copy of suite"
    here.mkdir()
    (here / "approvals.json").write_text(exported)
    shutil.copytree(SUITE_FOLDER, copy)
    words = shlex.split(command)
    check("the command that takes approvals names the suite", "--suite" in words, command)
    if "--suite" not in words:
        return
    at = words.index("--suite") + 1
    named = (here / words[at]).resolve()
    check("and does so from anywhere", named in (SUITE_FOLDER, SUITE_FOLDER / "suite.toml"), named)
    words[0], words[at] = str(PROGRAM), str(copy / named.relative_to(SUITE_FOLDER))
    outside_ci = {name: value for name, value in os.environ.items() if name != "CI"}
    done = subprocess.run(words, capture_output=True, text=True, cwd=here, env=outside_ci)
    lines = done.stdout.splitlines()
    check("it is accepted", done.returncode == 0 and len(lines) == len(images), f"{done.returncode} {len(lines)} lines {done.stderr}")
    waiting = sorted(str(path.relative_to(copy)) for path in copy.rglob("*.new"))
    left = [path for path in waiting if any(path.split(".exr")[0].endswith(frame["name"]) for frame in images)]
    check("and nothing of it is pending any more", left == [], left)


def check_approvals(browser, path, is_suite):
    page = Page(browser, path, "approvals", color_scheme="dark")
    data = json.loads(page.page.locator("#data").text_content())
    check("the page allows approvals", data["can_approve"])
    frames = [frame for shot in data["shots"] for frame in shot["frames"]]
    can = [frame for frame in frames if frame["status"] == "orphaned" or (frame["status"] in ("different", "missing") and frame["hash"])]
    approve_first(page, len(data["shots"]))
    check("a approves a image", page.text("#approved-count").startswith("1 of"), page.text("#approved-count"))
    page.page.screenshot(path=SHOTS / "approvals_dark.png")
    page.page.reload()
    page.wait_until_idle()
    check("ticks survive a reload", page.text("#approved-count").startswith("1 of"), page.text("#approved-count"))
    check_memory(page, path, data)
    page.page.locator("#approve-shown").click()
    check("all that are shown are approved", page.text("#approved-count").startswith(f"{len(can)} of {len(can)}"), page.text("#approved-count"))
    with page.page.expect_download() as download:
        page.page.locator("#export").click()
    check("the file is called approvals.json", download.value.suggested_filename == "approvals.json")
    exported = pathlib.Path(download.value.path()).read_text()
    found = json.loads(exported)
    wanted = [{"name": frame["name"], "hash": None if frame["status"] == "orphaned" else frame["hash"]} for frame in can]
    check("it names every image with its hash", found == {"schema": 1, "approved": wanted}, f"{len(found['approved'])} images")
    check("the command that takes it is shown", page.text("#accept-command code") == data["accept_command"] != "")
    if is_suite and SUITE_FOLDER:
        check_accepted(page.text("#accept-command code"), exported, can)
    if not is_suite:
        page.page.locator("#shots button").last.click()
        page.wait_until_idle()
        check("what is broken cannot be approved", page.page.locator("#approve-frame").is_disabled())
        check("names are texts", page.text("#shot-name") == "z/broken<b>" and "</script><script>alert(1)" in page.text("#messages"))
        page.page.screenshot(path=SHOTS / "broken_dark.png")
    page.close()
    page = Page(browser, path, "without memory", script="Object.defineProperty(window, 'localStorage', { get() { throw new Error('forbidden'); } })")
    approve_first(page, len(data["shots"]))
    check("where nothing can be stored approvals work, too", page.text("#approved-count").startswith("1 of"))
    page.close()


def check_filtered_approvals(browser, path):
    """Approves what a filter shows: images of that kind alone, and of shots that have others, too."""
    page = Page(browser, path, "filtered approvals", script="Object.defineProperty(window, 'localStorage', { get() { throw new Error('forbidden'); } })")
    data = json.loads(page.page.locator("#data").text_content())
    frames = [frame for shot in data["shots"] for frame in shot["frames"]]
    kind_of = lambda frame: frame["verdict"] if frame["status"] == "passed" else frame["status"]
    can = [frame for frame in frames if kind_of(frame) in ("different", "missing", "changed") and frame["hash"]]
    for kind in sorted({kind_of(frame) for frame in can}):
        of_kind = [frame for frame in can if kind_of(frame) == kind]
        button = page.page.locator("#kinds button", has_text=kind)
        if button.count() == 0 or not button.is_visible():
            continue
        button.click()
        page.page.locator("#approve-shown").click()
        check(f"a filter by {kind} approves these", page.text("#approved-count").startswith(f"{len(of_kind)} of"), page.text("#approved-count"))
        page.page.reload()
        page.wait_until_idle()
    name = can[-1]["name"]
    with_name = [frame for shot in data["shots"] for frame in shot["frames"] if name in "\n".join([shot["name"], frame["name"], *frame["messages"]]) and frame in can]
    page.page.locator("#filter").fill(name)
    page.page.locator("#approve-shown").click()
    check("a filter by name approves these", page.text("#approved-count").startswith(f"{len(with_name)} of"), page.text("#approved-count"))
    page.close()


def check_phone(browser, path):
    page = Page(browser, path, "phone", color_scheme="light", has_touch=True, is_mobile=True)
    page.page.set_viewport_size({"width": 390, "height": 844})
    page.wait_until_idle()
    width = lambda: page.page.evaluate("document.documentElement.scrollWidth")
    page.press("g")
    check("phone: the overview is no wider than the screen", width() <= 390, width())
    page.page.screenshot(path=SHOTS / "phone_overview.png", full_page=True)
    page.press("j")
    for mode in "12345":
        page.press(mode)
        check(f"phone: view {mode} is no wider than the screen", width() <= 390, width())
    page.press("1")
    page.page.screenshot(path=SHOTS / "phone_failure.png", full_page=True)
    page.press("2")
    canvas = page.page.locator("#stage canvas")
    canvas.scroll_into_view_if_needed()
    box, before = canvas.bounding_box(), page.canvas()
    page.page.touchscreen.tap(box["x"] + box["width"] * 0.2, box["y"] + box["height"] / 2)
    page.wait_until_idle()
    check("phone: a touch moves the slider", (page.canvas() != before).any())
    page.page.screenshot(path=SHOTS / "phone_slider.png")
    page.page.locator("#list-toggle").click()
    check("phone: the list opens", page.page.locator("#shots").is_visible())
    page.page.screenshot(path=SHOTS / "phone_list.png")
    page.close()


def check_plain(browser, folder):
    page = Page(browser, folder / "same/index.html", "all pass", color_scheme="light")
    check("a page without failures says so", "All 8 images match their references" in page.text("#overview"))
    page.page.screenshot(path=SHOTS / "same_light.png")
    page.close()
    page = Page(browser, folder / "sequence/index.html", "no script", java_script_enabled=False)
    check("without scripts the failures are listed", "a.0004: different" in page.text("body") and "mean FLIP" in page.text("body"))
    page.close()


def main():
    SHOTS.mkdir(parents=True, exist_ok=True)
    folder = FOLDER
    make_pages()
    allow_approvals(folder / "sequence/index.html", folder / "approvals.html")
    # The policy names the script's hash, which stays; data are no script.
    with sync_playwright() as playwright:
        program = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        check_pair(browser, folder)
        check_other_images(browser, folder)
        check_too_large(browser, folder)
        check_sequence(browser, folder)
        check_left_out(browser, folder / "sequence/index.html", folder / "left_out.html")
        check_keyboard(browser, folder / "approvals.html")
        check_approvals(browser, SUITE or folder / "approvals.html", SUITE is not None)
        check_filtered_approvals(browser, SUITE or folder / "approvals.html")
        check_phone(browser, folder / "approvals.html")
        check_plain(browser, folder)
        browser.close()
    shutil.rmtree(folder)
    print(f"{len(failures)} failed; images of the pages are in {SHOTS}")
    sys.exit(1 if failures else 0)


if __name__ == "__main__":
    main()
