"""Renders animated glTF scenes to arrays and OpenEXR image sequences, and compares images.

Keyword arguments are the settings of ``rayframe render`` with ``_`` for ``-``; ``rayframe render --help`` explains them.
"""

from __future__ import annotations

import dataclasses
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Union

import numpy as np
import numpy.typing as npt

from . import _rayframe
from ._rayframe import RayframeError, __version__

__all__ = ["Comparison", "RayframeError", "__version__", "compare", "render", "render_channels", "render_sequence"]

StrPath = Union[str, "os.PathLike[str]"]
#: A file, or linear RGB or RGBA of the shape (height, width, 3 or 4).
ImageLike = Union[StrPath, npt.ArrayLike]


@dataclasses.dataclass(frozen=True)
class Comparison:
    """How an image differs from its reference, and whether that is within the limits of a preset."""

    #: Whether there is no mismatch and every measure is within its limit.
    passes: bool
    #: Whether every bit is equal.
    identical: bool
    #: Mismatches and measures beyond their limits, one line each.
    failures: list[str]
    #: Mean FLIP from 0 (equal) to 1; None for images without colours or of different sizes.
    flip: float | None
    #: Everything measured, as ``rayframe diff --json`` names it.
    details: Mapping[str, Any]


def render(path: StrPath, *, frame: int = 0, size: tuple[int, int] | None = None, **settings: Any) -> npt.NDArray[np.float32]:
    """Renders one frame.

    Returns linear Rec. 709 light, premultiplied with alpha, of the shape (height, width, 4), top row first.
    """
    return _rayframe.render(os.fspath(path), frame, size, _texts(settings))


def render_channels(
    path: StrPath, *, frame: int = 0, size: tuple[int, int] | None = None, **settings: Any
) -> dict[str, npt.NDArray[Any]]:
    """Renders one frame and returns the channels of its EXR file by their names, each of the shape (height, width).

    ``aovs=["depth"]`` adds the channel ``Z``, for example. Ids are unsigned integers, all others floats.
    """
    return _rayframe.render_channels(os.fspath(path), frame, size, _texts(settings))


def render_sequence(
    path: StrPath, output: StrPath, *, size: tuple[int, int] | None = None, **settings: Any
) -> list[str]:
    """Renders ``frames`` to files and returns their names in order.

    ``output`` has ``####`` in place of the frame's number. Frames that are done already are kept.
    """
    return _rayframe.render_sequence(os.fspath(path), os.fspath(output), size, _texts(settings))


def compare(actual: ImageLike, reference: ImageLike, *, preset: str = "visual") -> Comparison:
    """Compares two images by the limits of a preset: ``exact``, ``visual`` or another of ``rayframe diff --preset``.

    An array has linear light, as :func:`render` returns it; a file of halves is compared with what such a file would hold of it.
    """
    passes, failures, details = _rayframe.compare(_image(actual), _image(reference), preset)
    measured = json.loads(details)
    flip = measured.get("flip")
    return Comparison(passes, measured["identical"], failures, None if flip is None else flip["mean"], measured)


def _image(image: ImageLike) -> str | npt.NDArray[np.float32]:
    if isinstance(image, (str, os.PathLike)):
        return os.fspath(image)
    pixels = np.asarray(image, dtype=np.float32)
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.size == 0:
        raise ValueError(f"an image has the shape (height, width, 3 or 4), not {pixels.shape}")
    if pixels.shape[2] == 3:
        pixels = np.concatenate([pixels, np.ones((*pixels.shape[:2], 1), np.float32)], axis=2)
    return np.ascontiguousarray(pixels)


def _texts(settings: Mapping[str, Any]) -> list[tuple[str, list[str]]]:
    """The values as the command line takes them, or those of the elements of a list. None leaves a setting as it is."""
    return [(name, [_text(item) for item in _items(value)]) for name, value in settings.items() if value is not None]


def _items(value: Any) -> Iterable[Any]:
    is_list = isinstance(value, (Sequence, np.ndarray)) and not isinstance(value, str)
    return value if is_list else [value]


def _text(value: Any) -> str:
    if isinstance(value, (bool, np.bool_)):
        return "true" if value else "false"
    if isinstance(value, (str, os.PathLike)):
        return os.fspath(value)
    if isinstance(value, (float, np.floating)):
        return repr(float(value))
    return str(value)
