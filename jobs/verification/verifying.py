# SPDX-License-Identifier: GPL-3.0-or-later
"""The command jobs/verification/verify: computes the cases and prints their tables."""
from __future__ import annotations

import argparse
import sys

import cases
import fast
import figures
import interface
import laws
import nucleation
import plates
import solids
import toughness
from crackle_readme import BLOCKS, put_block
from crackle_runs import command

# The tables of the README; each case takes the folder of the runs and the program.
TABLES = {
    "fast": fast.CASES | {"laws": laws.laws},
    "verification": {"notched-strip": cases.notched_strip, "slow-growth": cases.slow_growth, "engines": cases.engines,
                     "tests": lambda folder, program: cases.test_programs()},
    "plates": {"plate-tests": lambda folder, program: plates.test_programs(), "kinks": plates.kinks,
               "disk": plates.disk, "blunt-notch": plates.blunt_notch, "offset-notch": plates.offset_notch,
               "l-panel": plates.l_panel},
    "nucleation": nucleation.CASES,
    "interface": {"interface": interface.interface},
    "solids": solids.CASES,
}
CASES = {name: case for table in TABLES.values() for name, case in table.items()}


def main() -> int:
    parser = argparse.ArgumentParser(prog="verify", description="Computes the cases in jobs/verification and prints their figures "
                                     "beside the references from the literature. Finished runs are kept.")
    parser.add_argument("cases", nargs="*", metavar="CASE", default=[*CASES], help=f"of {', '.join(CASES)}, or toughness, which is computed "
                        "only when given; all others when none is")
    parser.add_argument("--kept", action="store_true", help="comparisons of laws by the samples that are there, however few; nothing is computed for them")
    parser.add_argument("--readme", action="store_true", help="update the tables of jobs/verification/README.md whose cases were all given")

    def verify(arguments: argparse.Namespace) -> int:
        if unknown := {*arguments.cases} - {*CASES, "toughness"}:
            parser.error(f"there is no case '{unknown.pop()}'; give some of {', '.join(CASES)}, toughness")
        def found(name: str) -> list[figures.Figure]:
            case = CASES[name]
            kept = (arguments.kept,) if isinstance(case, figures.Comparison) else ()
            return case(arguments.output, arguments.program, *kept)

        tables = {"toughness": toughness.table(arguments.output, arguments.program)} if "toughness" in arguments.cases else {}
        for block, of_table in TABLES.items():
            if rows := [figure for name in of_table if name in arguments.cases for figure in found(name)]:
                tables[block] = figures.table(rows)
        for block, table in tables.items():
            print(table)
            if arguments.readme and block in BLOCKS and {*TABLES.get(block, ())} <= {*arguments.cases}:
                put_block(block, table)
        return 0

    return command(parser, "verification", verify)


if __name__ == "__main__":
    sys.exit(main())
