#!/usr/bin/python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""A plate pulled by a sudden load, by DOLFINx: central differences with a lumped mass, on all ranks.

    mpirun -n 2 dolfinx_plate.py PLATE.npz STEP N

PLATE.npz: `nodes` (N x 3) [m], `tetrahedra` (T x 4), `force` [N] on the face of the largest z, `modulus` [Pa], `ratio`,
`density` [kg/m^3]. The internal force is PETSc's product with the assembled stiffness or an assembled vector, whichever is the
fastest. Rank 0 prints JSON: `seconds` of N steps, `displacement` [m], the loaded face's mean, and `way`.
"""
import json
import sys
from functools import partial
from time import perf_counter

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix, assemble_vector
from mpi4py import MPI
from petsc4py import PETSc

N_TRIED = 5  # steps


class Plate:
    """The discretized plate at rest."""

    def __init__(self, file: str):
        comm = MPI.COMM_WORLD
        with np.load(file) as given:
            values = {name: given[name] for name in given}
        element = ufl.VectorElement("Lagrange", ufl.tetrahedron, 1)
        mine = slice(None) if comm.rank == 0 else slice(0)  # DOLFINx distributes them
        body = mesh.create_mesh(comm, values["tetrahedra"][mine].astype(np.int64), values["nodes"][mine], ufl.Mesh(element))
        top = values["nodes"][:, 2].max()
        space = fem.VectorFunctionSpace(body, ("Lagrange", 1))
        modulus, ratio = float(values["modulus"]), float(values["ratio"])
        shear, lame = modulus / (2 * (1 + ratio)), modulus * ratio / ((1 + ratio) * (1 - 2 * ratio))
        u, v = ufl.TrialFunction(space), ufl.TestFunction(space)

        def internal(field):
            strain = ufl.sym(ufl.grad(field))
            return ufl.inner(lame * ufl.tr(strain) * ufl.Identity(3) + 2 * shear * strain, ufl.grad(v)) * ufl.dx

        self.displacement = fem.Function(space)
        self.vector_form = fem.form(internal(self.displacement))
        matrix_form = fem.form(internal(u))
        stiffness = fem.petsc.create_matrix(matrix_form, "baij")
        assemble_matrix(stiffness, matrix_form)
        stiffness.assemble()
        stiffness.setOption(PETSc.Mat.Option.HERMITIAN, True)  # or half of it may not be dropped
        self.stiffness = {"baij": stiffness, "sbaij": stiffness.convert("sbaij", PETSc.Mat())}
        mass = self._assembled(fem.form(float(values["density"]) * sum(v[i] for i in range(3)) * ufl.dx))
        faces = mesh.locate_entities_boundary(body, 2, lambda x: np.isclose(x[2], top))
        tags = mesh.meshtags(body, 2, np.sort(faces), np.ones(len(faces), dtype=np.int32))
        ds = ufl.Measure("ds", body, subdomain_data=tags)(1)
        area = comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(body, PETSc.ScalarType(1)) * ds)))
        self.force = float(values["force"])
        self.load = self._assembled(fem.form(self.force / area * v[2] * ds))
        self.inverse_mass = mass.copy()
        self.inverse_mass.reciprocal()
        fixed = fem.locate_dofs_geometrical(space, lambda x: np.isclose(x[2], 0))
        with self.inverse_mass.localForm() as local:
            local.array.reshape(-1, 3)[fixed] = 0
        self.internal = self.load.duplicate()

    @staticmethod
    def _assembled(form):
        vector = assemble_vector(form)
        vector.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
        return vector

    def by_matrix(self, kind: str) -> None:
        self.stiffness[kind].mult(self.displacement.vector, self.internal)

    def by_vector(self) -> None:
        self.displacement.vector.ghostUpdate(addv=PETSc.InsertMode.INSERT, mode=PETSc.ScatterMode.FORWARD)
        with self.internal.localForm() as local:
            local.set(0)
        assemble_vector(self.internal, self.vector_form)
        self.internal.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)

    def move(self, internal_force, step: float, n_steps: int) -> float:
        """From rest. @return seconds, of the slowest rank"""
        u = self.displacement.vector
        u.set(0)
        velocity = u.duplicate()  # half a step later
        velocity.set(0)
        MPI.COMM_WORLD.Barrier()
        start = perf_counter()
        for n in range(n_steps):
            internal_force()
            self.internal.aypx(-1, self.load)
            self.internal.pointwiseMult(self.internal, self.inverse_mass)
            velocity.axpy(step if n > 0 else step / 2, self.internal)
            u.axpy(step, velocity)
        return MPI.COMM_WORLD.allreduce(perf_counter() - start, MPI.MAX)

    def mean_displacement(self) -> float:
        return self.load.dot(self.displacement.vector) / self.force


def main() -> None:
    file, step, n_steps = sys.argv[1], float(sys.argv[2]), int(sys.argv[3])
    plate = Plate(file)
    ways = {"MatMult of BAIJ": partial(plate.by_matrix, "baij"), "MatMult of SBAIJ": partial(plate.by_matrix, "sbaij"),
            "assembled vector": plate.by_vector}
    tried = {way: plate.move(force, step, N_TRIED) for _ in range(2) for way, force in ways.items()}  # the first touches memory
    way = min(tried, key=tried.get)
    seconds = plate.move(ways[way], step, n_steps)
    displacement = plate.mean_displacement()
    if MPI.COMM_WORLD.rank == 0:
        print(json.dumps({"seconds": seconds, "displacement": displacement, "way": way, "tried": tried}))


if __name__ == "__main__":
    main()
