# SPDX-License-Identifier: GPL-3.0-or-later
"""The look that all pictures share: readable in print, safe for the colour-blind."""
from __future__ import annotations

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402
from matplotlib.colors import LinearSegmentedColormap  # noqa: E402

MILLIMETRE = 1e-3

PAGE_WIDTH = 9.6  # of a picture [inch]

BODY = "#e9ecef"
OTHER_MATERIAL = "#f3dfb5"
MATERIAL_BORDER = "#b07d10"
OUTLINE = "#343a40"
MUTED = "#6c757d"
BEFORE_ONSET = "#9aa1a9"
AFTER_PHASE = "#c98b6b"
BRANCHING = "#c1121f"

# Okabe and Ito's colours without the yellow, which is too light on white.
NOTCH_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")

# Viridis without its yellow end, which vanishes on paper.
TIME_COLOURS = LinearSegmentedColormap.from_list(
    "time", matplotlib.colormaps["viridis"]([0.9 * i / 255 for i in range(256)]))

PATTERN_COLOURS = ("#adb5bd", "#0072b2", "#d55e00", "#6c757d")
PATTERN_NAMES = ("no crack", "one main crack", "two cracks", "other")
SHORT_PATTERN_NAMES = ("none", "one", "two", "other")


def apply() -> None:
    """Sets matplotlib's defaults; the same data give the same files."""
    plt.rcParams.update({
        "font.family": "DejaVu Sans",
        "font.size": 8,
        "axes.titlesize": 8,
        "axes.labelsize": 8,
        "axes.linewidth": 0.6,
        "axes.edgecolor": OUTLINE,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "xtick.labelsize": 7,
        "ytick.labelsize": 7,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "legend.fontsize": 7,
        "legend.frameon": False,
        "figure.dpi": 100,
        "savefig.dpi": 200,
        "svg.hashsalt": "crackle",
        "svg.fonttype": "none",
    })


def notch_colour(notch: int) -> str:
    return NOTCH_COLOURS[notch % len(NOTCH_COLOURS)]


def pattern_name(pattern: int, short: bool = False) -> str:
    names = SHORT_PATTERN_NAMES if short else PATTERN_NAMES
    return names[pattern] if 0 <= pattern < len(names) else f"pattern {pattern}"
