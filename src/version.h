// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

namespace crackle {

std::string program_version();   ///< such as "1.0.0"
std::string git_commit();        ///< commit the program was built from, with "-dirty" for a modified tree
std::string library_versions();  ///< "Open MPI 4.1.4, PETSc 3.18.5, ..."

}  // namespace crackle
