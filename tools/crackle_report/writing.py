# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes files."""
from __future__ import annotations

import io
import os
from pathlib import Path

from PIL import Image
from matplotlib.figure import Figure

WIDTH, N_COLOURS = 1280, 256  # of a light picture, at the most


def write_whole(file: Path, content: bytes) -> None:
    """Replaces a file in one step, so that a reader never sees half of it."""
    partial = file.with_name(file.name + ".partial")
    partial.unlink(missing_ok=True)  # whatever it is, so that nothing but a new file is written to
    with open(partial, "xb") as stream:
        stream.write(content)
    os.replace(partial, file)


def write_light_image(image: Image.Image, file: Path) -> None:
    """Few pixels and colours make small files; without dither, so that plain areas stay plain."""
    light = io.BytesIO()
    image = image.convert("RGB")
    if image.width > WIDTH:
        image = image.resize((WIDTH, round(WIDTH * image.height / image.width)), Image.Resampling.LANCZOS)
    # The means of clusters: the first palette tints greys.
    image.quantize(N_COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=8, dither=Image.Dither.NONE).save(light, format="png", optimize=True)
    write_whole(file, light.getvalue())


def write_light_figure(figure: Figure, file: Path, dpi: float) -> None:
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=dpi)
    with Image.open(content) as image:
        write_light_image(image, file)
