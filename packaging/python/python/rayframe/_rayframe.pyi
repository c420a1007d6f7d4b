from typing import Any

import numpy as np
import numpy.typing as npt

__version__: str

class RayframeError(Exception):
    exit_code: int

def render(
    path: str, frame: int, size: tuple[int, int] | None, settings: list[tuple[str, list[str]]]
) -> npt.NDArray[np.float32]: ...
def render_channels(
    path: str, frame: int, size: tuple[int, int] | None, settings: list[tuple[str, list[str]]]
) -> dict[str, npt.NDArray[Any]]: ...
def render_sequence(
    path: str, output: str, size: tuple[int, int] | None, settings: list[tuple[str, list[str]]]
) -> list[str]: ...
def compare(
    actual: str | npt.NDArray[np.float32], reference: str | npt.NDArray[np.float32], preset: str
) -> tuple[bool, list[str], str]: ...
