# SPDX-License-Identifier: GPL-3.0-or-later
"""The program starts `python3 tools/crackle compare ...` for the commands that are carried out in Python."""
import sys
from pathlib import Path

sys.path[0] = str(Path(__file__).resolve().parents[1])

from crackle_start import start  # noqa: E402

sys.exit(start("crackle.commands"))
