# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html: one file with everything in it, so that it can be sent and read without a network."""
from __future__ import annotations

import base64
import shlex
from html import escape
from pathlib import Path

from . import tables
from .figures.picture import Section, View
from .results import Ensemble

_HERE = Path(__file__).resolve().parent
# Where Debian's libjs-three has three.js.
THREE = (Path("/usr/share/javascript/three"),)
MOST_WARNINGS = 3  # of the program, that a page shows


def render(ensemble: Ensemble, sections: list[tuple[Section, list[bytes]]]) -> str:
    """The page; `sections` are the pictures' sections, each with its pictures as PNG."""
    title = f"crackle: ensemble {ensemble.folder.resolve().name}"
    parts = [
        f"<h1>{escape(title)}</h1>",
        '<p class="muted">Monte-Carlo ensemble of dynamic brittle fracture by PDS-FEM</p>',
        _notice(ensemble),
        tables.tiles(ensemble),
        *_warnings(ensemble),
        f"<p>{escape(ensemble.interval_scope)}</p>",
    ]
    for section, images in sections:
        parts += of_section(section, images)
    if ensemble.n_notches and ensemble.sections:
        parts.append("<h2>Mean crack position</h2>\n" + tables.sections(ensemble))
    if not ensemble.n_notches and ensemble.places:
        parts.append("<h2>Places of the breaks</h2>\n" + tables.places(ensemble))
    parts.append("<h2>Samples</h2>\n<p>Click a column heading to sort by it.</p>\n"
                 + tables.samples(ensemble))
    parts.append(_next(ensemble))
    parts.append("<h2>Provenance</h2>\n" + tables.provenance(ensemble))
    parts.append(f"<h2>Input</h2>\n<pre>{escape(ensemble.input_text)}</pre>")
    return document(title, parts, sections)


def of_section(section: Section, images: list[bytes]) -> list[str]:
    """Parts of the page."""
    parts = [f"<h2>{escape(section.title)}</h2>\n<p>{escape(section.text)}</p>"]
    if section.answer:
        parts.append(f'<p class="answer">{escape(section.answer)}</p>')
    parts.append(section.table)
    for picture, image in zip(section.pictures, images):
        width = round(picture.figure.get_figwidth() * 108)
        parts.append(f"<figure>{_image(picture.description, width, 'png', image)}</figure>")
    parts += [_view(view, image) for view, image in zip(section.views, images[len(section.pictures):])]
    if section.animations:
        parts.append('<figure class="animations">' + "".join(
            _image(film.description, film.width, "gif", film.gif) for film in section.animations) + "</figure>")
    return parts


def document(title: str, parts: list[str], sections: list[tuple[Section, list[bytes]]]) -> str:
    """The whole file of these parts; empty ones are left out."""
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
{_surface_script(sections)}</body>
</html>
"""


def _next(ensemble: Ensemble) -> str:
    """What else can be done with these results."""
    folder = escape(shlex.quote(str(ensemble.folder)))
    sample = int(ensemble.done[0]) if ensemble.done.size else 0
    steps = ((f"crackle-paraview {folder}", "writes the fields and cracks of a typical sample for ParaView"),
             (f"crackle.open({escape(repr(str(ensemble.folder)))})", "in Python: samples, paths, histories and fields as labelled tables"),
             (f"crackle-report {folder} --sample {sample} --times 0,30,50,70", "shows other samples and times"),
             (f"crackle run plate.toml -o {folder} --resume", "continues, with more samples if the input asks for more"))
    rows = "".join(f'<tr><td class="text"><code>{command}</code></td><td class="text reason">{what}</td></tr>' for command, what in steps)
    return f'<h2>Next</h2>\n<div class="scroll"><table><tbody>{rows}</tbody></table></div>'


def _view(view: View, image: bytes) -> str:
    """A crack surface, hidden until surface.js draws it in place of its picture."""
    width = round(view.picture.figure.get_figwidth() * 108)
    data = "".join(f' data-{name}="{base64.b64encode(getattr(view, name)).decode("ascii")}"'
                   for name in ("corner", "time", "colour", "line"))
    return (f'<figure class="surface"{data} data-unit="{view.time_unit}">{_image(view.picture.description, width, "png", image)}'
            f'<div class="stage"><canvas></canvas><p><b>{escape(view.picture.description)}</b> <button type="button">Play</button> '
            '<input type="range" min="0" aria-label="time"> <output></output></p></div></figure>')


def _surface_script(sections: list[tuple[Section, list[bytes]]]) -> str:
    """three.js and what draws the surfaces; nothing where there are none, or no three.js: then their pictures stand."""
    library = next((folder for folder in THREE if (folder / "three.min.js").is_file()), None)
    if library is None or not any(section.views for section, _ in sections):
        return ""
    controls = library / "examples" / "js" / "controls" / "OrbitControls.js"
    texts = [file.read_text(encoding="utf-8") for file in (library / "three.min.js", controls, _HERE / "surface.js")]
    return "".join(f"<script>\n{text.replace('</script', '<' + chr(92) + '/script')}</script>\n" for text in texts)


def _image(description: str, width: int, kind: str, content: bytes) -> str:
    data = base64.b64encode(content).decode("ascii")
    return f'<img width="{width}" alt="{escape(description)}" src="data:image/{kind};base64,{data}">'


def _warnings(ensemble: Ensemble) -> list[str]:
    """The first ones of the program."""
    texts = [warning.removeprefix("warning: ") for warning in ensemble.warnings]
    shown = [text[0].upper() + text[1:] + "." for text in texts[:MOST_WARNINGS]]
    if more := len(texts) - len(shown):
        shown.append(f"{more} more warning{'s' * (more > 1)}: crackle stats prints all.")
    return [f'<p class="notice">{escape(text)}</p>' for text in shown]


def _notice(ensemble: Ensemble) -> str:
    notices = [] if ensemble.finished else ["This ensemble is not finished: the report shows the samples computed so far, "
                                            "and statistics over these."]
    notices += [f"Left out of the pictures: {damage}." for damage in (*ensemble.files.damage.values(), *ensemble.unreadable)]
    return "\n".join(f'<p class="notice">{escape(notice)}</p>' for notice in notices)
