// SPDX-License-Identifier: GPL-3.0-or-later
#include "version.h"

#include "git_commit.h"

#include <CGAL/version.h>
#include <fmt/format.h>
#include <hdf5.h>
#include <metis.h>
#include <mpi.h>
#include <petscsys.h>
#include <Eigen/Core>

#include <array>

namespace crackle {

namespace {

// Open MPI, PETSc and HDF5 are queried at run time: the libraries may be newer than the headers.

std::string mpi_version() {
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> text{};
  int length = 0;
  if (MPI_Get_library_version(text.data(), &length) != MPI_SUCCESS) return "MPI unknown";
  // "Open MPI v4.1.4, package: Debian OpenMPI, ident: ..."
  std::string version(text.data(), static_cast<std::size_t>(length));
  version = version.substr(0, version.find_first_of(",\n"));
  const auto v = version.find(" v");
  if (v != std::string::npos) version.erase(v + 1, 1);
  return version;
}

std::string petsc_version() {
  PetscInt major = 0;
  PetscInt minor = 0;
  PetscInt patch = 0;
  PetscInt release = 0;
  if (PetscGetVersionNumber(&major, &minor, &patch, &release) != 0) return "unknown";
  return fmt::format("{}.{}.{}", major, minor, patch);
}

std::string hdf5_version() {
  unsigned major = 0;
  unsigned minor = 0;
  unsigned patch = 0;
  if (H5get_libversion(&major, &minor, &patch) < 0) return "unknown";
  return fmt::format("{}.{}.{}", major, minor, patch);
}

}  // namespace

std::string program_version() {
  return CRACKLE_VERSION;
}

std::string git_commit() {
  return CRACKLE_GIT_COMMIT;
}

std::string library_versions() {
  return fmt::format("{}, PETSc {}, METIS {}.{}.{}, HDF5 {}, CGAL {}, Eigen {}.{}.{}, UDUNITS {}",
                     mpi_version(), petsc_version(), METIS_VER_MAJOR, METIS_VER_MINOR, METIS_VER_SUBMINOR,
                     hdf5_version(), CGAL_VERSION_STR, EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                     EIGEN_MINOR_VERSION, CRACKLE_UDUNITS_VERSION);
}

}  // namespace crackle
