# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html: one file with everything in it, so that it can be sent and read without a network."""
from __future__ import annotations

import base64
from html import escape
from pathlib import Path

from . import tables
from .figures.picture import Section
from .results import Ensemble

_HERE = Path(__file__).resolve().parent


def render(ensemble: Ensemble, sections: list[tuple[Section, list[bytes]]]) -> str:
    """The page; `sections` are the pictures' sections, each with its pictures as PNG."""
    title = f"crackle: ensemble {ensemble.folder.resolve().name}"
    parts = [
        f"<h1>{escape(title)}</h1>",
        '<p class="muted">Monte-Carlo ensemble of dynamic brittle fracture by PDS-FEM</p>',
        _notice(ensemble),
        tables.tiles(ensemble),
        f"<p>{escape(ensemble.interval_scope)}</p>",
    ]
    for section, images in sections:
        parts.append(f"<h2>{escape(section.title)}</h2>\n<p>{escape(section.text)}</p>")
        if section.answer:
            parts.append(f'<p class="answer">{escape(section.answer)}</p>')
        for picture, image in zip(section.pictures, images):
            width = round(picture.figure.get_figwidth() * 108)
            parts.append(f"<figure>{_image(picture.description, width, 'png', image)}</figure>")
        if section.animations:
            parts.append('<figure class="animations">' + "".join(
                _image(film.description, film.width, "gif", film.gif) for film in section.animations) + "</figure>")
    if ensemble.n_notches and ensemble.sections:
        parts.append("<h2>Mean crack position</h2>\n" + tables.sections(ensemble))
    parts.append("<h2>Samples</h2>\n<p>A click on a column's head sorts by it.</p>\n"
                 + tables.samples(ensemble))
    parts.append("<h2>Provenance</h2>\n" + tables.provenance(ensemble))
    parts.append(f"<h2>Input</h2>\n<pre>{escape(ensemble.input_text)}</pre>")
    body = "\n".join(part for part in parts if part)
    return f"""<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{escape(title)}</title>
<style>
{(_HERE / "page.css").read_text(encoding="utf-8")}</style>
</head>
<body>
{body}
<script>
{(_HERE / "page.js").read_text(encoding="utf-8")}</script>
</body>
</html>
"""


def _image(description: str, width: int, kind: str, content: bytes) -> str:
    data = base64.b64encode(content).decode("ascii")
    return f'<img width="{width}" alt="{escape(description)}" src="data:image/{kind};base64,{data}">'


def _notice(ensemble: Ensemble) -> str:
    if ensemble.finished:
        return ""
    return ('<p class="notice">This ensemble is not finished: the report shows the samples that are there, '
            "and its statistics are over these.</p>")
