# SPDX-License-Identifier: Apache-2.0
"""Files of view data: a step as PNG, an episode as GIF."""

from __future__ import annotations

import io
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from PIL import Image

from hypgen.pictures.frame import frame
from hypgen.whole_files import write_whole

MOST_FRAMES = 120
"""How many steps a GIF shows; of a longer episode it leaves out some, evenly."""

_DPI = 100
_COLOURS = 64
_MILLISECONDS, _LAST = 500, 2000


def render_png(view: Mapping[str, Any], step: int, path: str | PathLike[str]) -> None:
    """Write a step of view data as PNG; the number of steps stands for the end. Raises ``OSError``."""
    if not 0 <= step <= len(view["steps"]):
        raise ValueError(f"step {step}: the episode has the steps 0 to {len(view['steps']) - 1}, and its end")
    write_whole(Path(path), _png(view, step, 2 * _DPI))


def render_gif(view: Mapping[str, Any], path: str | PathLike[str]) -> None:
    """Write the steps of view data and its end as GIF. Raises ``OSError``."""
    count = len(view["steps"]) + (view.get("end") is not None)
    shown = (
        range(count)
        if count <= MOST_FRAMES
        else [round(i * (count - 1) / (MOST_FRAMES - 1)) for i in range(MOST_FRAMES)]
    )
    images = [Image.open(io.BytesIO(_png(view, n, _DPI))).convert("RGB") for n in shown]
    size = max(i.width for i in images), max(i.height for i in images)
    frames = []
    for image in images:
        whole = Image.new("RGB", size, "white")
        whole.paste(image)
        frames.append(whole.quantize(_COLOURS, dither=Image.Dither.NONE))
    times = [_MILLISECONDS] * (len(frames) - 1) + [_LAST]
    file = io.BytesIO()
    frames[0].save(
        file, "GIF", save_all=True, append_images=frames[1:], duration=times, loop=0, optimize=True
    )
    write_whole(Path(path), file.getvalue())


def _png(view: Mapping[str, Any], step: int, dpi: int) -> bytes:
    file = io.BytesIO()
    frame(view, step).savefig(file, format="png", dpi=dpi, metadata={"Software": None})
    return file.getvalue()
