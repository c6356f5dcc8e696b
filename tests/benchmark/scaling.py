#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a sample scales on the ranks that share it: measured on this machine, predicted for a cluster.

    scaling.py INPUT [--programs FOLDER] [--seconds S] [--json FILE] [--readme]
    scaling.py --from JSON [--readme]

Measured: the parts into which METIS divides a mesh; time steps on one and two ranks of one mesh (strong scaling) and of
meshes in proportion to the ranks (weak). Predicted, by crackle check: a sample of 100 million tetrahedra, and 200 samples of INPUT
on 64 nodes. With --from the tables are those of stored figures; --readme writes them to the page of speeds.
"""
from __future__ import annotations

import json
import os
import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from crackle_launch import mpirun  # noqa: E402
from crackle_runs import RunError, markdown  # noqa: E402
from peers import output_of, parsed, parser_of, processor, tell  # noqa: E402

FINE, FINEST = 0.485, 0.139  # spacings over the input's, for some 2.6 and 100 million tetrahedra from 300,000
PARTS = (2, 8, 64, 256, 1024)
NODES, RANKS_PER_NODE = 64, 64


def scaled(text: str, factor: float) -> str:
    """The input with all spacings multiplied: the same body and gradation of the mesh."""
    for key in ("spacing", "notch_spacing", "growth"):
        found = re.search(rf'(?m)^{key} = "?([\d.]+)(.*)$', text)
        if not found:
            raise RunError(f"the input has no {key}")
        quote = '"' if found[2] else ""
        text = text.replace(found[0], f"{key} = {quote}{factor * float(found[1]):.6g}{found[2]}")
    return text


def plans(text: str) -> dict:
    """What crackle check --ranks says: of the mesh, its network, and each plan as printed, by column."""
    head = re.search(r"(?m)^tetrahedra += (?:about )?([\d.e+]+)", text)
    network = re.search(r"(?m)^Plans for (.*), on cores .* with messages of (.*):$", text)
    table = text[network.end():].strip("\n").splitlines() if network else []
    if not head or len(table) < 2:
        raise RunError(f"crackle check has printed no plans: {text[-800:]}")
    titles = re.split(r" {2,}", table[0].strip())
    rows = []
    for line in table[1:]:
        if line.startswith("recommended"):
            break
        rows.append(dict(zip(titles, re.split(r" {2,}", line.strip()))))
    return {"tetrahedra": float(head[1]), "for": network[1], "network": network[2], "plans": rows,
            "recommended": int(re.search(r"ranks_per_sample = (\d+)", text)[1]),
            "division": re.search(r"METIS takes (.*), on one core", text)[1]}


def measure(source: Path, programs: Path, folder: Path, seconds: float) -> dict:
    text = source.read_text(encoding="utf-8")
    files = {}
    for name, factor in (("once", 1), ("twice", 0.5 ** (1 / 3)), ("fine", FINE), ("finest", FINEST)):
        files[name] = folder / f"{name}.toml"
        files[name].write_text(scaled(text, factor), encoding="utf-8")
    program, check = programs / "benchmark_scaling", [programs / "crackle", "check"]

    def steps(name: str, n_ranks: int) -> dict:
        print(f"steps on {n_ranks} ranks, {name}", file=sys.stderr)
        return json.loads(output_of([*mpirun(n_ranks, "core"), program, files[name], "--seconds", seconds]))

    found = {"input": os.path.relpath(source, ROOT), "processor": processor(), "seconds": seconds}
    found["steps"] = [{"mesh": name, **steps(name, n)} for name, n in (("once", 1), ("once", 2), ("fine", 1), ("fine", 2), ("twice", 2))]
    print("parts", file=sys.stderr)
    found["parts"] = json.loads(output_of([program, files["fine"], *PARTS]))
    print("predictions", file=sys.stderr)
    found["large"] = plans(output_of([*check, files["finest"], "--ranks", "1025"]))
    found["many"] = plans(output_of([*check, files["once"], "--ranks", NODES * RANKS_PER_NODE]))
    return found


def parts_table(found: dict) -> str:
    """The parts of a mesh, of each number the largest."""
    n = found["tetrahedra"]
    lines = []
    for part in found["parts"]:
        share = n / part["parts"]
        lines.append([f"{part['parts']:,}", f"{share:,.0f}", f"{100 * (part['tetrahedra'] / share - 1):.2g} %", f"{part['ghosts']:,}",
                      f"{part['ghosts'] / share ** (2 / 3):.2f}", f"{part['neighbours']}", f"{12e-3 * part['ghosts']:.3g} kB", f"{part['seconds']:.2g} s"])
    return markdown([f"parts of {n:,} tetrahedra", "each", "of others in the largest", "its ghost nodes", "over (each)^(2/3)",
                     "neighbours", "received in an exchange", "METIS"], lines)


def steps_table(found: list[dict]) -> str:
    """Steps on this machine."""
    of = {(one["mesh"], one["ranks"]): one for one in found}
    rows = [("strong", "once", 1), ("strong", "once", 2), ("strong", "fine", 1), ("strong", "fine", 2), ("weak", "twice", 2)]
    lines = []
    for scaling, mesh, n in rows:
        one = of[mesh, n]
        alone = of["once" if mesh == "twice" else mesh, 1]
        efficiency = alone["step"] / one["step"] * one["tetrahedra"] / alone["tetrahedra"] / n
        lines.append([scaling, f"{one['tetrahedra']:,}", str(n), f"{1e3 * one['step']:.3g} ms", f"{100 * one['check'] / one['step']:.0f} %",
                      f"{100 * efficiency:.0f} %" if n > 1 else "", f"{1e3 * one['exchange']:.2g} ms" if n > 1 else ""])
    return markdown(["scaling, measured", "tetrahedra", "ranks", "step, processor time without MPI", "breaking check", "efficiency without MPI",
                     "exchanges and waits, least"], lines)


def plans_table(found: dict, every: int) -> str:
    """What check predicts, from one plan in so many."""
    keys = ["ranks per sample", "groups", "tetrahedra/rank", "memory/root", "memory/other", "sample", "efficiency", "ensemble"]
    title = f"predicted, {found['tetrahedra']:.3g} tetrahedra, {found['for']}: ranks per sample"
    return markdown([title, *keys[1:]], [[row.get(key, "") for key in keys] for row in found["plans"][::every]])


def tables(found: dict) -> str:
    message = next(one for one in found["steps"] if one["latency"] > 0)
    return "\n".join([parts_table(found["parts"]), steps_table(found["steps"]), plans_table(found["large"], 2), plans_table(found["many"], 1)]) + f"""
`{found['input']}` and the same with other spacings, {found['processor']}. Steps: medians of {found['seconds']:g} s on a machine that others use, \
too, so that waits say little; one way of a message between two ranks took {1e6 * message['latency']:.2g} µs and {message['bandwidth'] / 1e9:.2g} GB/s. Predicted with {found['large']['network']}; of the large mesh, METIS \
takes {found['large']['division']} of each sample to divide it on one core. Memory grows with frames, here 11.
"""


def main() -> int:
    parser = parser_of("scaling.py", __doc__)
    parser.add_argument("--programs", type=Path, default=ROOT / "build-benchmark" / "bin")
    parser.add_argument("--seconds", type=float, default=20, help="of steps, for each number of ranks")
    options = parsed(parser)
    return tell("scaling", options, lambda folder: measure(options.input.resolve(), options.programs.resolve(), folder,
                                                           options.seconds), tables)


if __name__ == "__main__":
    sys.exit(main())
