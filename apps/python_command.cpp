// SPDX-License-Identifier: GPL-3.0-or-later
#include "python_command.h"

#include "common/failure.h"
#include "parallel/agreement.h"

#include <sys/wait.h>
#include <unistd.h>

#include <spawn.h>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;

/// The folder of this program's file.
fs::path folder_of_program() {
  return fs::read_symlink("/proc/self/exe").parent_path();
}

/// The package, where the program is installed or in its source tree.
fs::path package() {
  const fs::path here = folder_of_program();
  for (const char* const place : {"../share/crackle/tools/crackle", "../../tools/crackle"})
    if (fs::exists(here / place / "__main__.py")) return (here / place).lexically_normal();
  fail("the Python package crackle, which this command needs, is not beside {}; install crackle with it",
       (here / "crackle").string());
}

/// This process' environment, but without the ranks of its launcher, which Python and what it starts are not.
std::vector<std::string> environment() {
  constexpr std::array<std::string_view, 3> of_launchers{
      "OMPI_COMM_WORLD_SIZE=", "PMI_SIZE=", "SLURM_STEP_NUM_TASKS="};
  std::vector<std::string> variables{"CRACKLE=" + (folder_of_program() / "crackle").string()};
  for (char** each = environ; *each != nullptr; ++each) {
    const std::string_view variable = *each;
    bool is_kept = !variable.starts_with("CRACKLE=");
    for (const std::string_view name : of_launchers) is_kept = is_kept && !variable.starts_with(name);
    if (is_kept) variables.emplace_back(variable);
  }
  return variables;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

}  // namespace

int run_in_python(const parallel::Communicator& world, const CommandLine& typed) {
  int status = 0;
  parallel::agree_on_root(world, [&] {
    std::vector<std::string> words{"python3", "-B", package().string()};
    words.insert(words.end(), typed.begin() + 1, typed.end());
    std::vector<std::string> variables = environment();
    std::fflush(stdout);
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, "python3", nullptr, nullptr, pointers(words).data(),
                                     pointers(variables).data());
    if (error != 0)
      fail("this command needs Python 3.10 with {}, but python3 cannot be started: {}; on Debian install {}",
           "NumPy, SciPy, pandas, xarray, h5py and Matplotlib", std::strerror(error),
           "python3-scipy, python3-pandas, python3-xarray, python3-h5py and python3-matplotlib");
    while (::waitpid(child, &status, 0) < 0)
      if (errno != EINTR) fail("waiting for python3: {}", std::strerror(errno));
  });
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace crackle::apps
