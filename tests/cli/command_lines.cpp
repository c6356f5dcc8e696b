// SPDX-License-Identifier: GPL-3.0-or-later
// Runs many command lines in one process, for tests that would otherwise start the program for each of them.
//
// Each line of standard input is a request, a JSON object: `words` of the command line, the `folder` to work
// in, the `environment` that it has besides that of this process, and the files `out` and `err` for its
// standard output and error. The answer to each is a line on standard output: the exit status. A command line
// leaves nothing behind: the folder, the environment, the streams and their errors are as before.
#include "crackle.h"
#include "runtime.h"

#include <fcntl.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <optional>
#include <string>
#include <system_error>

namespace {

using crackle::apps::CommandLine;

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// Environment variables, while this exists.
class Environment {
public:
  explicit Environment(const std::map<std::string, std::string>& variables) {
    for (const auto& [name, value] : variables) {
      const char* const now = std::getenv(name.c_str());
      before_[name] = now != nullptr ? std::optional<std::string>(now) : std::nullopt;
      ::setenv(name.c_str(), value.c_str(), 1);
    }
  }
  ~Environment() {
    for (const auto& [name, value] : before_) {
      if (value)
        ::setenv(name.c_str(), value->c_str(), 1);
      else
        ::unsetenv(name.c_str());
    }
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

private:
  std::map<std::string, std::optional<std::string>> before_;
};

/// Standard output or error goes to a file, while this exists.
class Redirected {
public:
  Redirected(int descriptor, const std::string& file)
      : descriptor_(descriptor), before_(::fcntl(descriptor, F_DUPFD_CLOEXEC, 3)) {
    const int opened = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (before_ < 0 || opened < 0 || ::dup2(opened, descriptor) < 0) fail(file);
    ::close(opened);
  }
  ~Redirected() {
    std::cout.flush();
    std::fflush(nullptr);
    std::cout.clear();
    std::clearerr(stdout);
    std::clearerr(stderr);
    ::dup2(before_, descriptor_);
    ::close(before_);
  }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

private:
  int descriptor_, before_;
};

}  // namespace

int main() {
  std::signal(SIGXFSZ, SIG_IGN);  // as the program's main function does
  // A command may read its standard input, and writes to standard output.
  std::ifstream requests("/proc/self/fd/" + std::to_string(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 3)));
  std::ofstream answers("/proc/self/fd/" + std::to_string(::fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3)));
  if (!requests || !answers || std::freopen("/dev/null", "r", stdin) == nullptr)
    fail("the streams of requests");
  std::optional<crackle::apps::Runtime> runtime;
  for (std::string line; std::getline(requests, line);) {
    const auto request = nlohmann::json::parse(line);
    int status = 0;
    {
      const Environment environment(request.at("environment"));
      const Redirected out(STDOUT_FILENO, request.at("out"));
      const Redirected err(STDERR_FILENO, request.at("err"));
      if (::chdir(request.at("folder").get<std::string>().c_str()) != 0) fail(request.at("folder"));
      status = crackle::apps::crackle(MPI_COMM_WORLD, request.at("words").get<CommandLine>(), [&runtime] {
        if (!runtime) runtime.emplace();
      });
    }
    if (::chdir("/") != 0) fail("/");
    answers << status << std::endl;
  }
}
