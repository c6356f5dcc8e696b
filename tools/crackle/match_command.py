# SPDX-License-Identifier: GPL-3.0-or-later
"""crackle match: experiments beside an ensemble."""
from __future__ import annotations

import json
import sys
from pathlib import Path

from .command_line import Parser
from .files import ResultsError

EACH = "each"


def main(words: list[str], program: Path) -> int:
    parser = Parser("match", "Hold experiments against an ensemble: the nearest samples, whether each experiment could be one of them, where its "
                    "crack leaves theirs, and what the experiments say together; reads only")
    parser.add_argument("folder", type=Path, help="output folder of crackle run, or the ensemble.h5 in it")
    parser.add_argument("experiments", type=Path, nargs="?", help="the experiments (TOML); crackle init experiments.toml --from-ensemble FOLDER "
                        "writes one to start from")
    parser.add_argument("--held-out", metavar="N", help="instead of experiments: this number of the samples, chosen at random, against the others; "
                        '"each": each against all others, which checks the code')
    parser.add_argument("--of", type=Path, metavar="FOLDER", help='with --held-out each: the samples of another ensemble against those of this '
                        "one, whose p-values should be uniform if both are of one distribution")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead, in SI units; NaN is null")
    given = parser.parse_args(words)
    if (given.experiments is None) == (given.held_out is None):
        parser.error("match takes either an experiments file or --held-out")
    if given.experiments and given.experiments.suffix == ".csv":
        parser.error(f'{given.experiments} is a table; name it in an experiments file, as path = "{given.experiments}" in an [[experiment]] '
                     f"(crackle init experiments.toml --from-ensemble {given.folder})")
    if given.held_out not in (None, EACH) and not (given.held_out.isdecimal() and int(given.held_out) > 0):
        parser.error(f'--held-out: "{given.held_out}" is neither a number of samples nor "{EACH}"')
    if given.of and given.held_out != EACH:
        parser.error("--of goes with --held-out each")
    from . import match_text, matching
    from .observations import observed_samples
    if given.held_out is None:
        found = matching.match(given.folder, given.experiments, program)
    else:
        samples = observed_samples(given.folder, True, program)
        if given.held_out == EACH:
            table = matching.p_values_of(observed_samples(given.of, True, program) if given.of else samples, samples)
            if given.json:
                print(json.dumps(table.astype(object).where(table.notna(), None).to_dict("records"), indent=1))
            else:
                print(match_text.held_out_text(list(table.itertuples(index=False)), str(given.of or "")), end="")
            return 0
        found = matching.match_with(*matching.hold_out(samples, int(given.held_out)))
    print(json.dumps(found.document, indent=1) if given.json else str(found), end="\n" if given.json else "")
    return 0
