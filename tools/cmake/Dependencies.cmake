# SPDX-License-Identifier: GPL-3.0-or-later
# The libraries that crackle is made of, wherever they come from: their own CMake package, pkg-config under any of
# the names that systems give it, or headers and libraries below CMAKE_PREFIX_PATH. Each becomes an imported target
# and is held against its oldest version that the program is known to work with. Those that a source bundle has in
# external/ are taken from there.

find_package(PkgConfig QUIET)

# crackle_require(<name> <version> <oldest>): stops when the version is known and too old.
function(crackle_require name version oldest)
  if(version AND version VERSION_LESS oldest)
    message(FATAL_ERROR "${name} ${version} is too old: crackle needs ${oldest} or newer. Another one is found first where "
                        "CMAKE_PREFIX_PATH names its folder.")
  endif()
  if(version)
    message(STATUS "${name} ${version}")
  else()
    message(STATUS "${name}, version not known")
  endif()
endfunction()

# crackle_library(<name> OLDEST <version> HEADER <file> LIBRARY <names>... [MODULE <pkg-config names>...]
#                 [SUFFIXES <folders>...] [HINTS <folders>...] [PACKAGES <text>])
# Makes the target crackle::<name>, and sets <name>_OLDEST in the caller, and <name>_VERSION where pkg-config knows it.
function(crackle_library name)
  cmake_parse_arguments(ARG "" "OLDEST;HEADER;PACKAGES" "LIBRARY;MODULE;SUFFIXES;HINTS" ${ARGN})
  # What the modules of clusters set.
  string(TOUPPER ${name} NAME)
  foreach(variable ${NAME}_ROOT ${NAME}_DIR ${NAME}_HOME EBROOT${NAME})
    list(PREPEND ARG_HINTS ${${variable}} $ENV{${variable}})
  endforeach()
  if(PkgConfig_FOUND AND ARG_MODULE)
    pkg_search_module(PC_${name} QUIET ${ARG_MODULE})
  endif()
  find_path(${name}_INCLUDE_DIR ${ARG_HEADER} HINTS ${ARG_HINTS} ${PC_${name}_INCLUDE_DIRS} PATHS ENV CPATH
            PATH_SUFFIXES include ${ARG_SUFFIXES})
  find_library(${name}_LIBRARY NAMES ${ARG_LIBRARY} HINTS ${ARG_HINTS} ${PC_${name}_LIBRARY_DIRS} PATHS ENV LIBRARY_PATH
               PATH_SUFFIXES lib lib64)
  if(NOT ${name}_INCLUDE_DIR OR NOT ${name}_LIBRARY)
    list(JOIN ARG_LIBRARY " or " names)
    message(FATAL_ERROR "${name} is missing, of which crackle needs ${ARG_OLDEST} or newer: ${ARG_HEADER} or the library ${names} "
                        "is not where CMake looks. Load its module or install it (${ARG_PACKAGES}), or name its folder in "
                        "${NAME}_DIR or CMAKE_PREFIX_PATH.")
  endif()
  mark_as_advanced(${name}_INCLUDE_DIR ${name}_LIBRARY)
  add_library(crackle::${name} UNKNOWN IMPORTED)
  set(includes ${${name}_INCLUDE_DIR})
  set(pc_version)
  if(PC_${name}_FOUND AND (NOT PC_${name}_INCLUDE_DIRS OR ${name}_INCLUDE_DIR IN_LIST PC_${name}_INCLUDE_DIRS))
    # What pkg-config adds: further include folders, such as those of PETSc's build. It may know another library of this
    # name than the one that CMAKE_PREFIX_PATH has.
    list(APPEND includes ${PC_${name}_INCLUDE_DIRS})
    list(REMOVE_DUPLICATES includes)
    set(pc_version ${PC_${name}_VERSION})
  endif()
  set_target_properties(crackle::${name} PROPERTIES IMPORTED_LOCATION ${${name}_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES "${includes}"
                        INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${includes}")
  set(${name}_VERSION "${pc_version}" PARENT_SCOPE)
  set(${name}_OLDEST "${ARG_OLDEST}" PARENT_SCOPE)
endfunction()

# crackle_version_of(<variable> <file> <macro>...): the numbers of the macros in a header, joined with dots.
function(crackle_version_of variable file)
  set(numbers)
  if(EXISTS ${file})
    file(READ ${file} text)
    foreach(macro ${ARGN})
      if(text MATCHES "#define[ \t]+${macro}[ \t]+\\(?([0-9]+)")
        list(APPEND numbers ${CMAKE_MATCH_1})
      endif()
    endforeach()
  endif()
  string(REPLACE ";" "." numbers "${numbers}")
  set(${variable} "${numbers}" PARENT_SCOPE)
endfunction()

find_package(MPI COMPONENTS C CXX)
if(NOT MPI_FOUND)
  message(FATAL_ERROR "MPI is missing, of which crackle needs the standard 3.0 or newer: load its module or install it "
                      "(libopenmpi-dev, openmpi-devel, mpich), or name its compilers in MPI_C_COMPILER and MPI_CXX_COMPILER.")
endif()
crackle_require("MPI (standard)" "${MPI_CXX_VERSION}" 3.0)

# PETSc says by its variables where it is when it was built by hand.
crackle_library(PETSc OLDEST 3.18 HEADER petscksp.h LIBRARY petsc petsc_real petsc64_real MODULE petsc PETSc
                HINTS $ENV{PETSC_DIR}/$ENV{PETSC_ARCH} $ENV{PETSC_DIR} PACKAGES "libpetsc-real-dev, petsc-devel, petsc")
if(DEFINED ENV{PETSC_DIR} AND EXISTS $ENV{PETSC_DIR}/$ENV{PETSC_ARCH}/include/petscconf.h)
  set_property(TARGET crackle::PETSc APPEND PROPERTY INTERFACE_INCLUDE_DIRECTORIES $ENV{PETSC_DIR}/include
               $ENV{PETSC_DIR}/$ENV{PETSC_ARCH}/include)
endif()
crackle_version_of(PETSc_VERSION ${PETSc_INCLUDE_DIR}/petscversion.h PETSC_VERSION_MAJOR PETSC_VERSION_MINOR
                   PETSC_VERSION_SUBMINOR)
crackle_require(PETSc "${PETSc_VERSION}" ${PETSc_OLDEST})
target_link_libraries(crackle::PETSc INTERFACE MPI::MPI_CXX)

# HDF5 with MPI. Systems that have several builds of it beside each other give them names of their own.
if(DEFINED CRACKLE_HDF5_FLAVOUR)
  set(hdf5_flavours ${CRACKLE_HDF5_FLAVOUR})
else()
  set(hdf5_flavours openmpi mpich)
  set(hdf5_plain hdf5)
endif()
list(TRANSFORM hdf5_flavours PREPEND hdf5- OUTPUT_VARIABLE hdf5_modules)
list(TRANSFORM hdf5_flavours PREPEND hdf5_ OUTPUT_VARIABLE hdf5_names)
list(TRANSFORM hdf5_flavours PREPEND include/hdf5/ OUTPUT_VARIABLE hdf5_suffixes)
list(APPEND hdf5_modules ${hdf5_plain})
list(APPEND hdf5_names ${hdf5_plain})
set(hdf5_hl_names ${hdf5_names})
list(TRANSFORM hdf5_hl_names APPEND _hl)
crackle_library(HDF5 OLDEST 1.10 HEADER hdf5.h LIBRARY ${hdf5_names} MODULE ${hdf5_modules} SUFFIXES ${hdf5_suffixes}
                PACKAGES "libhdf5-openmpi-dev, hdf5-openmpi-devel, hdf5 with MPI")
get_filename_component(hdf5_folder ${HDF5_LIBRARY} DIRECTORY)
find_library(HDF5_HL_LIBRARY NAMES ${hdf5_hl_names} HINTS ${hdf5_folder})
if(NOT HDF5_HL_LIBRARY)
  message(FATAL_ERROR "${HDF5_LIBRARY} comes without HDF5's high-level library (hdf5_hl): name the folder of a complete one in "
                      "HDF5_DIR or CMAKE_PREFIX_PATH.")
endif()
target_link_libraries(crackle::HDF5 INTERFACE ${HDF5_HL_LIBRARY} MPI::MPI_C)
find_file(HDF5_CONFIG_HEADER NAMES H5pubconf.h H5pubconf-64.h HINTS ${HDF5_INCLUDE_DIR} NO_DEFAULT_PATH)
crackle_version_of(HDF5_VERSION ${HDF5_INCLUDE_DIR}/H5public.h H5_VERS_MAJOR H5_VERS_MINOR H5_VERS_RELEASE)
crackle_require(HDF5 "${HDF5_VERSION}" ${HDF5_OLDEST})
if(HDF5_CONFIG_HEADER)
  file(STRINGS ${HDF5_CONFIG_HEADER} hdf5_parallel REGEX "#define[ \t]+H5_HAVE_PARALLEL[ \t]+1")
  if(NOT hdf5_parallel)
    message(FATAL_ERROR "${HDF5_LIBRARY} is an HDF5 without MPI (${HDF5_CONFIG_HEADER} does not define H5_HAVE_PARALLEL): "
                        "name the folder of a parallel one in HDF5_DIR or CMAKE_PREFIX_PATH.")
  endif()
endif()

# PETSc often brings METIS.
crackle_library(METIS OLDEST 5.1 HEADER metis.h LIBRARY metis HINTS $ENV{PETSC_DIR}/$ENV{PETSC_ARCH} $ENV{PETSC_DIR} $ENV{PETSC_ROOT}
                PACKAGES "libmetis-dev, metis-devel, metis")
crackle_version_of(METIS_VERSION ${METIS_INCLUDE_DIR}/metis.h METIS_VER_MAJOR METIS_VER_MINOR METIS_VER_SUBMINOR)
crackle_require(METIS "${METIS_VERSION}" ${METIS_OLDEST})

# The others are seldom modules: a source bundle brings them.
if(CRACKLE_BUNDLED AND EXISTS ${PROJECT_SOURCE_DIR}/external)
  include(${CMAKE_CURRENT_LIST_DIR}/Bundled.cmake)
  return()
endif()
find_package(Eigen3 REQUIRED NO_MODULE)
crackle_require(Eigen "${Eigen3_VERSION}" 3.4)
find_package(CGAL REQUIRED)
crackle_require(CGAL "${CGAL_VERSION}" 5.5)
find_package(Boost REQUIRED)
crackle_require(Boost "${Boost_VERSION}" 1.74)
find_package(CLI11 REQUIRED)
crackle_require(CLI11 "${CLI11_VERSION}" 2.1)
find_package(fmt REQUIRED)
crackle_require(fmt "${fmt_VERSION}" 9)
find_package(nanoflann REQUIRED)
crackle_require(nanoflann "${nanoflann_VERSION}" 1.4)
find_package(nlohmann_json REQUIRED)
crackle_require(nlohmann-json "${nlohmann_json_VERSION}" 3.10)
find_package(PNG REQUIRED)
crackle_library(UDUNITS OLDEST 2.2 HEADER udunits2.h LIBRARY udunits2 MODULE udunits udunits2 SUFFIXES udunits2
                PACKAGES "libudunits2-dev, udunits2-devel, udunits")
crackle_require(UDUNITS-2 "${UDUNITS_VERSION}" ${UDUNITS_OLDEST})
find_path(toml11_INCLUDE_DIR toml.hpp HINTS ${toml11_DIR}/../../../include)
if(NOT toml11_INCLUDE_DIR)
  message(FATAL_ERROR "toml11 is missing: there is no toml.hpp. Install it (libtoml11-dev, toml11-devel, toml11), or name its "
                      "folder in CMAKE_PREFIX_PATH.")
endif()
foreach(header toml.hpp toml11/version.hpp)
  if(NOT toml11_VERSION)
    crackle_version_of(toml11_VERSION ${toml11_INCLUDE_DIR}/${header} TOML11_VERSION_MAJOR TOML11_VERSION_MINOR
                       TOML11_VERSION_PATCH)
  endif()
endforeach()
crackle_require(toml11 "${toml11_VERSION}" 3.7)
find_library(GMP_LIBRARY gmp REQUIRED)
find_library(MPFR_LIBRARY mpfr REQUIRED)
