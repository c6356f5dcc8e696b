# SPDX-License-Identifier: GPL-3.0-or-later
"""What a picture module hands to the page."""
from __future__ import annotations

from dataclasses import dataclass, field

from matplotlib.figure import Figure


@dataclass
class Picture:
    name: str  # of its files, without ending
    description: str  # for those who cannot see it
    figure: Figure


@dataclass
class Animation:
    name: str  # of its file, without ending
    description: str
    gif: bytes
    width: int  # [pixels]


@dataclass
class View:
    """A crack surface that can be turned and played in time, drawn by surface.js; its picture stands where that cannot be."""

    picture: Picture
    corner: bytes  # facets x 4 x 3 float32, in order of opening, in the body's unit of lengths
    time: bytes  # facets, float32, in the unit of times
    colour: bytes  # facets x 3 uint8
    line: bytes  # lines x 2 x 3 float32: edges of the body
    time_unit: str


@dataclass
class Section:
    title: str
    text: str
    answer: str = ""  # what the pictures come to, in a sentence
    table: str = ""  # HTML
    pictures: list[Picture] = field(default_factory=list)
    animations: list[Animation] = field(default_factory=list)
    views: list[View] = field(default_factory=list)
