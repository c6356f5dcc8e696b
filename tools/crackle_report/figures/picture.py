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
class Section:
    title: str
    text: str
    answer: str = ""  # what the pictures come to, in a sentence
    pictures: list[Picture] = field(default_factory=list)
    animations: list[Animation] = field(default_factory=list)
