#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""The same plate, pulled by a sudden load, by crackle, DOLFINx, CalculiX and LAMMPS, each on one core and on two.

    peers.py INPUT [--rounds N] [--steps N] [--program FILE] [--json FILE] [--readme]
    peers.py --from JSON [--readme]

All take turns in each round. DOLFINx and CalculiX have crackle's mesh, LAMMPS a cubic lattice with about as many points. Timed
are the steps alone, without what comes before, except that crackle's include the setup of the dynamic phase. With --from the
table is that of stored figures; --readme writes it to the page of speeds.
"""
from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, eigsh
from scipy.spatial import cKDTree

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools"))

from crackle_launch import environment, mpirun  # noqa: E402
from crackle_readme import put_block  # noqa: E402
from crackle_runs import RunError, markdown, median_range  # noqa: E402
from sample_times import setting  # noqa: E402

MODULUS, RATIO, DENSITY, FORCE = 3.3e9, 0.38, 1180, 135  # of the paper [Pa, 1, kg/m^3, N]
DURATION = 100e-6  # whose cost is told [s]
SAFETY = 0.9  # of the stable step, as crackle's "auto"
HORIZON = 3.0001  # spacings; the bonds of exactly 3 are in
CORES = (1, 2)
TOLERANCE, LATTICE_TOLERANCE = 1e-4, 0.5  # of displacements, on the same mesh and on a lattice
N_PRINTS = 4  # of CalculiX, between which it is timed
PACKAGES = {"DOLFINx": "python3-dolfinx-real", "CalculiX": "calculix-ccx", "LAMMPS": "lammps"}


@dataclass
class Run:
    """Steps of a program."""

    seconds: float  # of one step
    displacement: float | None = None  # of the loaded face in the end, its mean [m]


def output_of(command: list, **more: str) -> str:
    """What a command prints.

    @raise RunError: it failed
    """
    found = subprocess.run([str(word) for word in command], capture_output=True, text=True, env=environment(**more), check=False)
    if found.returncode != 0:
        raise RunError(f"'{' '.join(map(str, command))}' ended with status {found.returncode}: {(found.stdout + found.stderr)[-800:]}")
    return found.stdout


# --- crackle


def pulled(text: str, step: str, duration: float, every: float, precision: str = "mixed") -> str:
    """The input's body at rest, which a sudden load pulls and nothing breaks.

    @param every: between rows of the history [s]
    """
    body = re.sub(r"(?ms)^\[\[?(material|fracture|boundary|time|output)\b.*?(?=^\[|\Z)", "", text)
    return body + f"""
[material]
youngs_modulus = "{MODULUS:g} Pa"
poisson_ratio = {RATIO}
density = "{DENSITY:g} kg/m^3"
[fracture]
strength = "100 MPa"
[[boundary]]
on = "z-min"
fix = ["x", "y", "z"]
[[boundary]]
on = "z-max"
force = ["0 N", "0 N", "{FORCE:g} N"]
[time]
start = "rest"
step = "{step}"
duration = "{duration:.12g} s"
integrator = "verlet"
precision = "{precision}"
[output]
frames = 0
history = "{every:.12g} s"
"""


@dataclass
class Crackle:
    program: Path
    folder: Path

    def mesh(self, text: str) -> dict[str, np.ndarray]:
        """Of sample 0."""
        source, file = self.folder / "mesh.toml", self.folder / "mesh.vtkhdf"
        source.write_text(text, encoding="utf-8")
        output_of([self.program, "mesh", source, "-o", file])
        with h5py.File(file) as root:
            return {"nodes": root["VTKHDF/Points"][:], "tetrahedra": root["VTKHDF/Connectivity"][:].reshape(-1, 4),
                    "slots": root["specimen/notch_slot"][:], "size": root["specimen/size"][:]}

    def run(self, text: str, n_cores: int = 1) -> dict:
        """Sample 0: seconds of a step, the number of steps, and the history's times [s] and displacements [m]."""
        source, results = self.folder / "input.toml", self.folder / "out"
        source.write_text(text, encoding="utf-8")
        shutil.rmtree(results, ignore_errors=True)
        output_of([*mpirun(n_cores, "core"), self.program, "sample", source, "--sample", "0", "-o", results])
        with h5py.File(results / "samples" / "0000.h5") as root:
            history, n_steps = root["history"], root["counts/steps"][()]
            return {"seconds": root["timing/dynamic"][()] / n_steps, "n_steps": n_steps, "time": history["time"][:],
                    "displacement": history["governing_displacement"][:]}


# --- the finite elements of others


def nodal_force(mesh: dict[str, np.ndarray]) -> np.ndarray:
    """The load's share of each node: a third of each triangle in the loaded face."""
    nodes, tetrahedra = mesh["nodes"], mesh["tetrahedra"]
    sides = np.sort(np.concatenate([np.delete(tetrahedra, corner, axis=1) for corner in range(4)]), axis=1)
    triangles, count = np.unique(sides, axis=0, return_counts=True)
    a, b, c = nodes[triangles[count == 1]].transpose(1, 0, 2)
    loaded = np.minimum(np.minimum(a, b), c)[:, 2] > nodes[:, 2].max() * (1 - 1e-9)
    area = np.linalg.norm(np.cross((b - a)[loaded], (c - a)[loaded]), axis=1)
    return np.bincount(triangles[count == 1][loaded].ravel(), np.repeat(area / 3, 3), len(nodes)) * FORCE / area.sum()


@dataclass
class Dolfinx:
    folder: Path
    mesh: dict[str, np.ndarray]
    step: float
    n_steps: int

    def run(self, n_cores: int) -> tuple[Run, str]:
        """And how it computed the internal force."""
        file = self.folder / "plate.npz"
        if not file.is_file():
            np.savez(file, nodes=self.mesh["nodes"], tetrahedra=self.mesh["tetrahedra"], force=FORCE, modulus=MODULUS, ratio=RATIO,
                     density=DENSITY)
        found = json.loads(output_of([*mpirun(n_cores, "core"), "/usr/bin/python3", "-B", ROOT / "tests/benchmark/dolfinx_plate.py", file,
                                      repr(self.step), self.n_steps], XDG_CACHE_HOME=str(self.folder)).splitlines()[-1])
        return Run(found["seconds"] / self.n_steps, found["displacement"]), found["way"]


class Calculix:
    """Its explicit dynamics; it has threads, and chooses its steps by itself."""

    def __init__(self, folder: Path, mesh: dict[str, np.ndarray], n_steps: int):
        self.folder, self.n_steps = folder, n_steps
        self.force = nodal_force(mesh)
        self.loaded = np.flatnonzero(self.force)
        # In mm, N, MPa, t, s.
        with open(folder / "body.inp", "w", encoding="utf-8") as file:
            file.write("*NODE, NSET=ALL\n")
            np.savetxt(file, np.c_[1:len(self.force) + 1, 1e3 * mesh["nodes"]], fmt="%d, %.13g, %.13g, %.13g")
            file.write("*ELEMENT, TYPE=C3D4, ELSET=PLATE\n")
            np.savetxt(file, np.c_[1:len(mesh["tetrahedra"]) + 1, mesh["tetrahedra"] + 1], fmt="%d", delimiter=", ")
            file.write(f"*MATERIAL, NAME=M\n*ELASTIC\n{1e-6 * MODULUS:.12g}, {RATIO}\n*DENSITY\n{1e-12 * DENSITY:.12g}\n"
                       "*SOLID SECTION, ELSET=PLATE, MATERIAL=M\n")
            for name, members in (("FIXED", np.flatnonzero(mesh["nodes"][:, 2] == 0)), ("LOADED", self.loaded)):
                file.write(f"*NSET, NSET={name}\n")
                np.savetxt(file, members + 1, fmt="%d")
        # Three digits of the step that it would choose itself, so that other programs can take the same one.
        chosen = float(re.search(r"stable time increment:\s*(\S+)", self._calculate(1e-12, 1, 1, 1)[0])[1])
        self.step = float(f"{0.999 * chosen:.2e}")

    def run(self, n_cores: int) -> Run:
        every = max(self.n_steps // N_PRINTS, 1)
        _, times, displacement = self._calculate(self.step, self.n_steps, every, n_cores)
        if len(times) < 2:
            raise RunError(f"CalculiX needs at least {2 * N_PRINTS} steps to be timed")
        n_timed = (len(times) - 1) * every
        return Run((times[-1] - times[0]) / n_timed, displacement)

    def _calculate(self, step: float, n_steps: int, every: int, n_cores: int) -> tuple[str, list[float], float]:
        """What it writes, when it has printed each `every`-th step [s], and the displacement in the end [m]."""
        forces = "".join(f"{node + 1}, 3, {self.force[node]:.12g}\n" for node in self.loaded)
        (self.folder / "plate.inp").write_text(
            f"*INCLUDE, INPUT=body.inp\n*BOUNDARY\nFIXED, 1, 3\n*STEP, INC=1000000\n*DYNAMIC, EXPLICIT, ALPHA=0\n"
            f"{step:.12g}, {n_steps * step:.12g}, , {step:.12g}\n*CLOAD\n{forces}*NODE PRINT, NSET=LOADED, FREQUENCY={every}\nU\n*END STEP\n",
            encoding="utf-8")
        results, log, times = self.folder / "plate.dat", self.folder / "ccx.log", []
        results.unlink(missing_ok=True)
        with open(log, "w", encoding="utf-8") as file:
            process = subprocess.Popen(["ccx", "plate"], cwd=self.folder, stdout=file, stderr=subprocess.STDOUT,
                                       env=environment(OMP_NUM_THREADS=str(n_cores), GFORTRAN_UNBUFFERED_ALL="1"))
            while process.poll() is None:
                n_printed = results.read_text().count("displacements") if results.is_file() else 0
                times += (n_printed - len(times)) * [time.perf_counter()]
                time.sleep(0.01)
        text = log.read_text(encoding="utf-8", errors="replace")
        if process.returncode != 0 or not results.is_file():
            raise RunError(f"CalculiX ended with status {process.returncode}: {text[-800:]}")
        last = np.array([line.split() for line in results.read_text().split("displacements")[-1].splitlines()[1:] if line.strip()], dtype=float)
        return text, times, 1e-3 * float(self.force[last[:, 0].astype(int) - 1] @ last[:, 3]) / FORCE


# --- LAMMPS


class Lattice:
    """A cubic lattice in a body's box with about as many points as the mesh has nodes, and what a peridynamic law needs of it."""

    def __init__(self, size: np.ndarray, n_nodes: int):
        across = [(abs(self._shape(size, n).prod() - n_nodes), n) for n in range(2, 1000)]
        self.spacing = size[1] / min(across)[1]
        self.shape = self._shape(size, min(across)[1])
        self.n_points = int(self.shape.prod())

    @staticmethod
    def _shape(size: np.ndarray, n: int) -> np.ndarray:
        return np.maximum(np.rint(size * n / size[1]), 1).astype(int)

    def coefficients(self, law: str) -> tuple[float, ...]:
        """Of pair_coeff before the horizon: of `pmb`, whose Poisson's ratio is 1/4, the micromodulus; of `lps`, bulk and shear modulus."""
        if law == "pmb":
            return (18 * MODULUS / 1.5 / (np.pi * (3 * self.spacing)**4),)
        return MODULUS / (3 * (1 - 2 * RATIO)), MODULUS / (2 * (1 + RATIO))

    def stable_step(self, law: str) -> float:
        """2 / omega of the fastest oscillation of a block as thick as the lattice, its surfaces included [s]."""
        h = self.spacing
        points = h * np.stack(np.meshgrid(*map(np.arange, np.minimum(self.shape, 12)), indexing="ij"), axis=-1).reshape(-1, 3)
        pairs = cKDTree(points).query_pairs(HORIZON * h, output_type="ndarray")
        i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
        length = np.linalg.norm(points[j] - points[i], axis=1)
        direction = (points[j] - points[i]) / length[:, None]
        volume = h**3 * np.clip(0.5 + HORIZON - length / h, 0, 1)  # what lies within the horizon
        at_i = csr_matrix((np.ones(len(i)), (i, np.arange(len(i)))))

        def force(u: np.ndarray) -> np.ndarray:
            extension = np.einsum("bk,bk->b", u.reshape(-1, 3)[j] - u.reshape(-1, 3)[i], direction)
            if law == "pmb":
                tension = self.coefficients(law)[0] / length * extension
            else:
                bulk, shear = self.coefficients(law)
                weight = at_i @ (volume * length)  # the influence function is 1 / length
                dilatation = at_i @ (volume * extension) * 3 / weight
                tension = ((3 * bulk - 5 * shear) * (dilatation[i] / weight[i] + dilatation[j] / weight[j])
                           + 15 * shear * extension / length * (1 / weight[i] + 1 / weight[j]))
            return -(at_i @ (direction * (volume * tension)[:, None])).ravel()

        operator = LinearOperator((3 * len(points),) * 2, matvec=force, dtype=float)
        fastest = eigsh(operator, k=1, which="LA", tol=1e-3, return_eigenvectors=False)[0]
        return 2 / np.sqrt(fastest / DENSITY)


@dataclass
class Lammps:
    folder: Path
    mesh: dict[str, np.ndarray]
    lattice: Lattice
    law: str
    step: float
    n_steps: int

    def script(self) -> str:
        """Its bonds across the notches are left out, by types of points above and below them."""
        h, shape, lines = self.lattice.spacing, self.lattice.shape, []
        for n, ((y_low, y_high), (z_low, z_high)) in enumerate(self.mesh["slots"]):
            z = (z_low + z_high) / 2
            for number, name, low, high in ((2, "below", z - 4 * h, z), (3, "above", z, z + 4 * h)):
                lines.append(f"region {name}{n} block INF INF {y_low} {y_high} {low} {high} units box\nset region {name}{n} type {number}\n")
        box = " ".join(f"0 {n * h}" for n in shape)
        coefficients = " ".join(map(str, self.lattice.coefficients(self.law)))
        force = FORCE / (self.mesh["size"][0] * self.mesh["size"][1]) / h  # per volume, as the forces of atom_style peri
        return f"""units si
boundary s s s
atom_style peri
atom_modify map array
neighbor {0.1 * h} bin
lattice sc {h} origin 0.5 0.5 0.5
region plate block {box} units box
create_box 3 plate
create_atoms 1 region plate
{''.join(lines)}pair_style peri/{self.law}
pair_coeff * * {coefficients} {HORIZON * h} 1e10 0
pair_coeff 2 3 {coefficients} {h / 2} 1e10 0
set group all density {DENSITY}
set group all volume {h**3}
region bottom block INF INF INF INF INF {h} units box
region top block INF INF INF INF {(shape[2] - 1) * h} INF units box
group bottom region bottom
group top region top
fix load top addforce 0 0 {force}
fix clamp bottom setforce 0 0 0
fix move all nve
compute moved top displace/atom
compute mean top reduce ave c_moved[3]
thermo_style custom step c_mean
thermo {self.n_steps}
timestep {self.step}
# The bonds are there after the first force, which leaves a critical stretch of nothing in peri/lps.
run 0
run {self.n_steps}
variable mean equal c_mean
print "mean displacement ${{mean}}"
"""

    def run(self, n_cores: int) -> Run:
        file = self.folder / f"in.{self.law}"
        file.write_text(self.script(), encoding="utf-8")
        text = output_of([*mpirun(n_cores, "core"), "lmp", "-in", file, "-log", "none"])
        loop = re.findall(r"Loop time of (\S+) on", text)[-1]
        return Run(float(loop) / self.n_steps, float(re.findall(r"(?m)^mean displacement (\S+)", text)[-1]))


# --- the comparison


def check_peers() -> None:
    """@raise RunError: a program or a core is missing"""
    if len(os.sched_getaffinity(0)) < max(CORES):
        raise RunError(f"{max(CORES)} cores are needed")
    missing = [name for name in ("ccx", "lmp") if shutil.which(name) is None]
    if subprocess.run(["/usr/bin/python3", "-c", "import dolfinx"], capture_output=True, check=False).returncode != 0:
        missing.append("dolfinx")
    if missing:
        raise RunError(f"there is no {', '.join(missing)}: run tools/setup peers")


def versions() -> dict[str, str]:
    return {name: re.match(r"[\d.]*\d", output_of(["dpkg-query", "-W", "-f", "${source:Upstream-Version}", package]))[0]
            for name, package in PACKAGES.items()}


def processor() -> str:
    found = re.search(r"(?m)^model name\s*: (.*)$", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return found[1].strip() if found else "unknown"


def compare(source: Path, program: Path, folder: Path, n_rounds: int, n_steps: int) -> dict:
    """All figures."""
    text = source.read_text(encoding="utf-8")
    crackle = Crackle(program, folder)
    mesh = crackle.mesh(pulled(text, "auto", DURATION, DURATION))
    lattice = Lattice(mesh["size"], len(mesh["nodes"]))
    laws = ("pmb", "lps")
    lattice_steps = {law: SAFETY * lattice.stable_step(law) for law in laws}
    duration = max(DURATION, *(n_steps * step for step in lattice_steps.values()))
    first = crackle.run(pulled(text, "auto", duration, duration))
    step = duration / first["n_steps"]
    elastic = pulled(text, "auto", duration, n_steps * step)
    breaking = setting(text, "verlet", "auto")
    dolfinx = Dolfinx(folder, mesh, step, n_steps)
    calculix = Calculix(folder, mesh, n_steps)
    # In its short steps little moves, below the resolution of 32 bits.
    end = n_steps * calculix.step
    end_of_calculix = crackle.run(pulled(text, f"{calculix.step!r} s", end, end, "double"))["displacement"][-1]
    lammps = {law: Lammps(folder, mesh, lattice, law, lattice_steps[law], n_steps) for law in laws}
    found: dict[str, dict] = {}
    ways = set()

    def add(name: str, n_points: int, step: float, n_cores: int, run: Run, expected: float | None = None) -> None:
        entry = found.setdefault(name, {"points": n_points, "step": step, "seconds": {}})
        entry["seconds"].setdefault(str(n_cores), []).append(run.seconds)
        if expected is None:
            return
        difference = run.displacement / expected - 1
        if not abs(difference) < (LATTICE_TOLERANCE if name.startswith("LAMMPS") else TOLERANCE):
            raise RunError(f"in {name} the loaded face moves by {1e9 * run.displacement:.7g} nm, in crackle by {1e9 * expected:.7g} nm")
        entry["difference"] = max(entry.get("difference", 0), difference, key=abs)

    for number in range(n_rounds):
        for n_cores in CORES:
            n_nodes, own = len(mesh["nodes"]), crackle.run(elastic, n_cores)
            add("crackle", n_nodes, step, n_cores, Run(own["seconds"]))
            add("crackle, cracks running", n_nodes, step, n_cores, Run(crackle.run(breaking, n_cores)["seconds"]))
            run, way = dolfinx.run(n_cores)
            ways.add(way)
            add("DOLFINx", n_nodes, step, n_cores, run, np.interp(n_steps * step, own["time"], own["displacement"]))
            add("CalculiX", n_nodes, calculix.step, n_cores, calculix.run(n_cores), end_of_calculix)
            for law in laws:
                add(f"LAMMPS, peri/{law}", lattice.n_points, lattice_steps[law], n_cores, lammps[law].run(n_cores),
                    np.interp(n_steps * lattice_steps[law], own["time"], own["displacement"]))
            print(f"round {number + 1} of {n_rounds}, {n_cores} of {max(CORES)} cores", file=sys.stderr)
    return {"input": os.path.relpath(source, ROOT), "processor": processor(), "versions": versions(), "rounds": n_rounds, "steps": n_steps,
            "tetrahedra": len(mesh["tetrahedra"]), "force_of_dolfinx": " or ".join(sorted(ways)), "programs": found}


def duration_text(seconds: float) -> str:
    """In the largest unit of which there are two, with two digits."""
    value, unit = next((seconds / size, unit) for size, unit in ((3600, "h"), (60, "min"), (1, "s")) if seconds >= 2 * size or size == 1)
    return f"{value:.2g} {unit}" if value < 99.5 else f"{value:.0f} {unit}"


def table(figures: dict) -> str:
    """As on the page of speeds: rates, what DURATION costs, and how far the displacements differ."""
    programs, lines = figures["programs"], []
    for name, entry in programs.items():
        program, _, law = name.partition(", peri/")
        title = " ".join(filter(None, (program, figures["versions"].get(program), law and f"`peri/{law}`")))
        rates = [median_range((entry["points"] / seconds / 1e6 for seconds in entry["seconds"][str(n)]), ".3g") for n in CORES]
        costs = [duration_text(n * np.median(entry["seconds"][str(n)]) * DURATION / entry["step"]) for n in CORES]
        difference = f"{100 * entry['difference']:+.2g} %" if "difference" in entry else ""
        lines.append([title, f"{entry['points']:,}", f"{1e9 * entry['step']:.3g} ns", *rates, *costs, difference])
    body = f"`{figures['input']}`, {figures['tetrahedra']:,} tetrahedra, {figures['processor']}"
    calculix = programs["CalculiX"]
    elsewhere = duration_text(np.median(calculix["seconds"]["1"]) * DURATION / programs["crackle"]["step"])
    return markdown([body, "points", "step", "million node-steps per second, one core", "two", "core time of 100 µs, one core", "two",
                     "displacement"], lines) + f"""
Medians (and ranges) of {figures['rounds']} rounds of {figures['steps']} steps, of crackle 100 µs. Stable steps times {SAFETY}; CalculiX \
chooses its own, with those of crackle its 100 µs would take {elsewhere}. Two cores are ranks, of CalculiX threads. DOLFINx: central \
differences in Python, internal force by the faster of products and assembled vectors, {figures['force_of_dolfinx']}. LAMMPS: lattice with a horizon of 3 spacings; Poisson's ratio of \
`pmb` is 1/4. Displacement: the loaded face's mean after these steps, over crackle's.
"""


def parser_of(program: str, documentation: str) -> argparse.ArgumentParser:
    """The arguments of every benchmark that tell() ends."""
    parser = argparse.ArgumentParser(prog=program, description=documentation.splitlines()[0])
    parser.add_argument("input", type=Path, nargs="?")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--from", dest="stored", type=Path)
    parser.add_argument("--readme", action="store_true")
    return parser


def parsed(parser: argparse.ArgumentParser) -> argparse.Namespace:
    options = parser.parse_args()
    if (options.input is None) == (options.stored is None):
        parser.error("either an input or --from is needed")
    return options


def tell(block: str, options: argparse.Namespace, measure: Callable[[Path], dict], tables: Callable[[dict], str]) -> int:
    """Tells figures, measured in a folder or stored before, where the options want them; the exit status."""
    try:
        if options.stored is not None:
            figures = json.loads(options.stored.read_text(encoding="utf-8"))
        else:
            with tempfile.TemporaryDirectory(prefix=f"crackle-{block}-") as folder:
                figures = measure(Path(folder))
    except (RunError, OSError, ValueError) as error:
        print(f"{block}.py: {error}", file=sys.stderr)
        return 1
    if options.json is not None:
        options.json.write_text(json.dumps(figures, indent=2) + "\n", encoding="utf-8")
    text = tables(figures)
    print(text, end="")
    if options.readme:
        put_block(block, text)
    return 0


def main() -> int:
    parser = parser_of("peers.py", __doc__)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--steps", type=int, default=60)
    parser.add_argument("--program", type=Path, default=ROOT / "build-benchmark" / "bin" / "crackle")
    options = parsed(parser)
    if options.rounds < 1 or options.steps < 2 * N_PRINTS:
        parser.error(f"at least 1 round and {2 * N_PRINTS} steps are needed")

    def measure(folder: Path) -> dict:
        check_peers()
        return compare(options.input.resolve(), options.program.resolve(), folder, options.rounds, options.steps)

    return tell("peers", options, measure, table)


if __name__ == "__main__":
    sys.exit(main())
