"""Tests of the installed package: `pip install WHEEL[test] && pytest` in the folder `packaging/python` of the repository."""

import base64
import json
import os
import pathlib
import signal
import subprocess
import sys
import sysconfig
import threading
import time

import numpy as np
import pytest

import rayframe

SCENES = pathlib.Path(__file__).resolve().parents[3] / "scenes"
DEMO = SCENES / "demo/whitted_1980.gltf"
SMALL = {"size": (48, 32), "samples": 1}


def program():
    return pathlib.Path(sysconfig.get_path("scripts")) / ("rayframe.exe" if os.name == "nt" else "rayframe")


def test_pixels_are_those_of_the_program(tmp_path):
    pixels = rayframe.render(DEMO, frame=3, **SMALL)
    assert pixels.shape == (32, 48, 4) and pixels.dtype == np.float32
    assert np.isfinite(pixels).all() and pixels.max() > 0.1
    output = tmp_path / "a.exr"
    subprocess.run([program(), "render", DEMO, "-f", "3", "-r", "48x32", "--samples", "1", "-o", output, "-q"], check=True)
    comparison = rayframe.compare(pixels, output, preset="exact")
    assert comparison.passes, comparison.failures


def test_settings_take_python_values():
    view = {"camera_position": (1.0, 2.5, np.float32(8)), "look_at": [0, 1, 0], "fov": 40}
    seen = rayframe.render(DEMO, **SMALL, **view, background=None, integrator="path", seed=7)
    text = rayframe.render(DEMO, **SMALL, camera_position="1,2.5,8", look_at="0,1,0", fov="40", integrator="path", seed="7")
    assert np.array_equal(seen, text)
    assert not np.array_equal(seen, rayframe.render(DEMO, **SMALL, integrator="path"))


def test_channels_have_the_names_of_exr_files():
    channels = rayframe.render_channels(DEMO, **SMALL, aovs=["depth", "normal", "object_id"])
    assert {"R", "G", "B", "A", "Z"} <= set(channels)
    assert all(channel.shape == (32, 48) for channel in channels.values())
    assert channels["Z"].dtype == np.float32
    assert any(channel.dtype == np.uint32 for channel in channels.values())


def test_sequences_are_written_and_kept(tmp_path):
    pattern = tmp_path / "out/a.####.exr"
    files = rayframe.render_sequence(DEMO, pattern, frames="2-4", **SMALL)
    assert [pathlib.Path(file).name for file in files] == ["a.0002.exr", "a.0003.exr", "a.0004.exr"]
    times = [os.stat(file).st_mtime_ns for file in files]
    assert rayframe.render_sequence(DEMO, pattern, frames="2-4", resume=True, **SMALL) == files
    assert [os.stat(file).st_mtime_ns for file in files] == times


def test_comparisons_tell_what_differs(tmp_path):
    first, second = (rayframe.render(DEMO, frame=frame, **SMALL) for frame in (0, 12))
    same = rayframe.compare(first, first.copy(), preset="exact")
    assert same.passes and same.identical and same.failures == [] and same.flip == 0
    other = rayframe.compare(first, second)
    assert not other.passes and other.failures and other.flip > 0.001
    assert other.details["checks"]
    assert rayframe.compare(first[..., :3], first[..., :3]).identical
    # Views of other strides are copied.
    assert rayframe.compare(first[::-1], np.flipud(first)).identical
    with pytest.raises(ValueError, match="shape"):
        rayframe.compare(first[..., 0], first)
    with pytest.raises(ValueError, match="shape"):
        rayframe.compare(first[:0], first[:0])
    with pytest.raises(rayframe.RayframeError, match="there are exact, strict"):
        rayframe.compare(first, first, preset="loose")


@pytest.mark.parametrize(
    ("path", "settings", "code"),
    [("missing.glb", {}, 66), (DEMO, {"sampels": 3}, 2), (DEMO, {"samples": "many"}, 2), (__file__, {}, 65)],
)
def test_errors_have_the_exit_code_of_the_program(path, settings, code):
    with pytest.raises(rayframe.RayframeError) as raised:
        rayframe.render(path, **settings)
    assert raised.value.exit_code == code
    assert "\n" not in str(raised.value)


def test_other_threads_run_while_a_frame_is_rendered():
    ticks = []
    done = threading.Event()

    def count():
        while not done.wait(0.005):
            ticks.append(time.monotonic())

    counter = threading.Thread(target=count)
    counter.start()
    start = time.monotonic()
    rayframe.render(DEMO, size=(320, 200), samples=16)
    end = time.monotonic()
    done.set()
    counter.join()
    during = [tick for tick in ticks if start < tick < end]
    assert len(during) > 5 * (end - start), (len(during), end - start)


@pytest.mark.skipif(os.name == "nt", reason="signals")
def test_an_interrupt_ends_rendering():
    code = f"import rayframe; print('go', flush=True); rayframe.render({str(DEMO)!r}, size=(4000, 3000), samples=256)"
    process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "go\n"
    time.sleep(0.5)
    sent = time.monotonic()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=10)
    assert time.monotonic() - sent < 2
    assert "KeyboardInterrupt" in errors


def test_the_program_is_installed():
    version = subprocess.run([program(), "--version"], capture_output=True, text=True, check=True).stdout
    assert version.strip() == f"rayframe {rayframe.__version__}"


@pytest.mark.parametrize(
    ("function", "settings", "words"),
    [
        (rayframe.render, {"frames": "1-3"}, "frames: one frame is rendered"),
        (rayframe.render, {"start": 2}, "start: one frame is rendered"),
        (rayframe.render, {"output": "a.exr"}, "output: no file is written"),
        (rayframe.render, {"aovs": ["depth"]}, "aovs: .*render_channels"),
        (rayframe.render, {"scene": "other.glb"}, "scene: .*first argument"),
        (rayframe.render, {"size": (64, 36), "width": 32}, "size and width contradict"),
        (rayframe.render, {"size": (0, 36)}, "resolution: .*one pixel"),
        (rayframe.render, {"size": (-4, 36)}, "resolution: .*width and height"),
        (rayframe.render, {"threads": 0}, "threads"),
        (rayframe.render, {"quiet": True}, "quiet: only the program"),
        (rayframe.render_channels, {"movie": "a.mp4"}, "movie: no file is written"),
        (rayframe.render_channels, {"resolution": "8x8", "size": (64, 36)}, "size and resolution contradict"),
    ],
)
def test_arguments_without_a_meaning_are_refused(function, settings, words):
    with pytest.raises(rayframe.RayframeError, match=words) as raised:
        function(DEMO, **settings)
    assert raised.value.exit_code == 2


def test_size_replaces_the_scale_of_a_shot_file(tmp_path):
    shot = tmp_path / "shot.toml"
    shot.write_text(f'scene = "{DEMO}"\nscale = "50%"\nsamples = 1\n')
    assert rayframe.render(shot, size=(64, 36)).shape == (36, 64, 4)


def test_sequences_take_their_output_once(tmp_path):
    with pytest.raises(rayframe.RayframeError, match="stats: only the program"):
        rayframe.render_sequence(DEMO, tmp_path / "a.####.exr", stats="s.json")
    with pytest.raises(rayframe.RayframeError, match="outfile: the files are the second argument"):
        rayframe.render_sequence(DEMO, tmp_path / "a.####.exr", outfile="b.exr")


def test_threads_do_not_change_pixels():
    one, two = (rayframe.render(DEMO, size=(64, 36), samples=1, threads=threads) for threads in (1, 2))
    assert one.tobytes() == two.tobytes()
    assert rayframe.render(DEMO, size=(64, 36), samples=1, fps=12).shape == (36, 64, 4)


def test_settings_of_the_import_have_an_effect(tmp_path):
    scenes, shared, other = (tmp_path / name for name in ("scenes", "shared", "other"))
    for folder in (scenes, shared, other):
        folder.mkdir()
    document = json.loads((SCENES / "light/point.gltf").read_text())
    buffer = document["buffers"][0]
    (shared / "a.bin").write_bytes(base64.b64decode(buffer["uri"].split("base64,")[1]))
    buffer["uri"] = "../shared/a.bin"
    scene = scenes / "a.gltf"
    scene.write_text(json.dumps(document))
    with pytest.raises(rayframe.RayframeError, match="/buffers/0/uri") as raised:
        rayframe.render(scene, **SMALL)
    assert raised.value.exit_code == 77
    for folders in (shared, [other, shared]):
        assert rayframe.render(scene, **SMALL, allow_dir=folders).shape == (32, 48, 4)
    with pytest.raises(rayframe.RayframeError) as raised:
        rayframe.render(DEMO, **SMALL, max_memory="1K")
    assert raised.value.exit_code == 77


def test_lists_are_several_values(tmp_path):
    document = json.loads((SCENES / "light/point.gltf").read_text())
    document["nodes"][2]["name"] = "post, left"
    nodes = ["floor", "post, left"]
    scene = tmp_path / "a.gltf"
    scene.write_text(json.dumps(document))
    caught = rayframe.render(scene, **SMALL, shadow_catcher=nodes)
    assert caught.tobytes() != rayframe.render(scene, **SMALL, shadow_catcher=nodes[:1]).tobytes()


@pytest.mark.skipif(sys.platform != "linux", reason="names of other systems are Unicode")
def test_names_need_not_be_unicode(tmp_path):
    folder = tmp_path / os.fsdecode(b"\xff")
    folder.mkdir()
    scene = folder / "a.gltf"
    scene.write_bytes((SCENES / "light/point.gltf").read_bytes())
    (file,) = rayframe.render_sequence(scene, folder / "a.####.exr", frames="1", **SMALL)
    assert os.fsencode(file).endswith(b"\xff/a.0001.exr") and os.path.exists(file)
    pixels = rayframe.render(scene, frame=1, **SMALL, allow_dir=folder)
    assert rayframe.compare(pixels, file, preset="exact").passes
