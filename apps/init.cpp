// SPDX-License-Identifier: GPL-3.0-or-later
// crackle init: writes an input to start from.
#include "commands.h"
#include "input/reader.h"
#include "io/text_file.h"
#include "parallel/agreement.h"
#include "problems.h"
#include "python_command.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <stdexcept>

namespace crackle::apps {

namespace {

constexpr const char* basis_of_template = "your-own-problem";

struct InitOptions {
  std::filesystem::path file;
  std::string from;
  std::string ensemble;  ///< folder
};

const Problem& problem(const std::string& name) {
  const auto found = std::ranges::find(problems(), name, &Problem::name);
  if (found == problems().end()) throw std::logic_error("no problem has the name " + name);
  return *found;
}

void write_new(const std::filesystem::path& file, const std::string& text) {
  refuse_existing(file);
  io::write_text_file(file, text);
}

int init(const parallel::Communicator& world, const InitOptions& options) {
  parallel::agree_on_root(world, [&] {
    write_new(options.file, options.from.empty() ? input::annotated(problem(basis_of_template).text)
                                                 : problem(options.from).text);
    fmt::print("{0}: {1}\ncrackle check {0}     # is it right, and what will it cost?\n",
               options.file.string(),
               options.from.empty() ? "a notched plate; to set another key, take away the # before it"
                                    : options.from);
  });
  return success;
}

}  // namespace

void add_init_command(CLI::App& app, const CommandLine& typed, Action& run) {
  const auto options = std::make_shared<InitOptions>();
  CLI::App* const command = app.add_subcommand(
      "init", "Write an input file to start from: a template that explains every key, or a given problem");
  command->add_option("input", options->file, "file to write (TOML); an existing one is not replaced")
      ->required();
  std::vector<std::string> names;
  for (const Problem& each : problems()) names.push_back(each.name);
  command->add_option("--from", options->from, "the problem to write instead of the template")
      ->check(CLI::IsMember(names));
  command
      ->add_option("--from-ensemble", options->ensemble,
                   "write an experiments file for crackle match instead, with values of this ensemble: an "
                   "output folder of crackle run, or the ensemble.h5 in it")
      ->excludes("--from");
  command->footer("Exit status: 0 done; 1 usage error, or the file cannot be written.");
  command->callback([options, typed, &run] {
    run.work = [options, typed](const parallel::Communicator& world) {
      return options->ensemble.empty() ? init(world, *options) : run_in_python(world, typed);
    };
  });
}

}  // namespace crackle::apps
