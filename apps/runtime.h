// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <string>

namespace crackle::apps {

/// Starts PETSc, and with it MPI; ends both. One in the life of a process.
class Runtime {
public:
  /// @throws std::runtime_error
  Runtime();
  ~Runtime();
  Runtime(const Runtime&) = delete;
  Runtime& operator=(const Runtime&) = delete;

private:
  bool start();

  // PETSc keeps pointers to these; it must not see the program's own arguments.
  std::string name_ = "crackle";
  std::string skip_option_ = "-skip_petscrc";
  std::array<char*, 3> argument_list_{name_.data(), skip_option_.data(), nullptr};
  char** arguments_ = argument_list_.data();
  int n_arguments_ = 2;
};

}  // namespace crackle::apps
