# SPDX-License-Identifier: GPL-3.0-or-later
# Sourced by the other tools: what Open MPI needs to run a few ranks on any one machine.

# Debian's name of Open MPI's launcher; plain mpirun may belong to another MPI. MPIRUN names that of another one.
if [[ -n ${MPIRUN:-} ]]; then
  :
elif command -v mpirun.openmpi >/dev/null; then
  MPIRUN=mpirun.openmpi
else
  MPIRUN=mpirun
fi
export MPIRUN

# Open MPI refuses to start as root unless told twice.
if [[ $(id -u) -eq 0 ]]; then
  export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
fi

# More ranks than cores: allow it, pin nobody, and let a waiting rank give its core away.
export OMPI_MCA_rmaps_base_oversubscribe=1
export OMPI_MCA_hwloc_base_binding_policy=none
export OMPI_MCA_mpi_yield_when_idle=1

# On one machine messages go through shared memory; looking for a fabric takes a good part of a short command's time.
export OMPI_MCA_pml=ob1
# Nor are graphics cards and other devices looked for, by plugins of hwloc: a tenth of a short command's time.
export HWLOC_PLUGINS_PATH=/none

# Containers often forbid one process to read another's memory.
export OMPI_MCA_btl_vader_single_copy_mechanism=none

# Each rank is one thread; a threaded BLAS would take the other ranks' cores.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1
