# SPDX-License-Identifier: GPL-3.0-or-later
"""Spack (1.0 or newer) builds crackle from a checkout: see ../../../../spack.yaml."""
from spack_repo.builtin.build_systems.cmake import CMakePackage

from spack.package import *


class Crackle(CMakePackage):
    """Monte-Carlo ensembles of three-dimensional dynamic brittle fracture by PDS-FEM."""

    license("GPL-3.0-or-later")

    # Built from a checkout: `spack develop` in spack.yaml says which.
    version("main", branch="main")

    variant("report", default=True, description="What tools/crackle-report needs")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.22:", type="build")
    depends_on("ninja", type="build")
    depends_on("pkgconfig", type="build")

    # The versions of tools/cmake/Dependencies.cmake.
    depends_on("mpi@3:")
    depends_on("petsc@3.18: +mpi ~complex +double")
    depends_on("hdf5@1.10: +mpi +hl")
    depends_on("metis@5.1:")
    depends_on("eigen@3.4:3")
    depends_on("boost@1.74: +math +random")
    depends_on("cgal@5.5:")
    depends_on("gmp")
    depends_on("mpfr")
    depends_on("udunits@2.2:")
    depends_on("toml11@3.7:")
    depends_on("cli11@2.1:")
    depends_on("fmt@9:")
    depends_on("nlohmann-json@3.10:")
    depends_on("libpng")
    depends_on("nanoflann@1.4:")

    with when("+report"):
        depends_on("python@3.11:", type="run")
        depends_on("py-h5py", type="run")
        depends_on("py-numpy", type="run")
        depends_on("py-matplotlib", type="run")
        depends_on("py-pillow", type="run")
        depends_on("py-scipy", type="run")

    generator("ninja")

    def cmake_args(self):
        return [self.define("CRACKLE_TESTS", self.run_tests)]
