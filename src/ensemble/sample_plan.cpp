// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_plan.h"

#include "crackle/io/sample_file.h"
#include "crackle/io/text_file.h"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

fs::path input_copy(const fs::path& folder) {
  return folder / "input.toml";
}
fs::path sample_folder(const fs::path& folder) {
  return folder / "samples";
}

bool holds_anything(const fs::path& folder) {
  return fs::is_directory(folder) && fs::directory_iterator(folder) != fs::directory_iterator();
}

bool holds_ensemble(const fs::path& folder) {
  return fs::exists(input_copy(folder)) || fs::exists(folder / "ensemble.h5") ||
         holds_anything(sample_folder(folder));
}

/// @throws std::runtime_error with the first line in which `ours` differs from the folder's `theirs`
void check_same_text(const fs::path& folder, const fs::path& theirs, const std::string& their_text,
                     const std::string& our_text) {
  if (const auto difference = first_difference(their_text, our_text)) {
    throw std::runtime_error(fmt::format(
        "{} holds an ensemble of another input: compared with {}, {}; use that input, or another folder",
        folder.string(), theirs.string(), *difference));
  }
}

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream.good() && !stream.eof()) throw std::runtime_error(file.string() + ": cannot be read");
  return text;
}

fs::path free_name(const fs::path& file) {
  for (int i = 1;; ++i) {
    fs::path name = fmt::format("{}.invalid-{}", file.string(), i);
    if (!fs::exists(fs::symlink_status(name))) return name;
  }
}

}  // namespace

std::optional<std::string> first_difference(const std::string& expected, const std::string& actual) {
  if (expected == actual) return std::nullopt;
  std::istringstream expected_lines(expected), actual_lines(actual);
  for (int number = 1;; ++number) {
    std::string expected_line, actual_line;
    const bool has_expected = static_cast<bool>(std::getline(expected_lines, expected_line));
    const bool has_actual = static_cast<bool>(std::getline(actual_lines, actual_line));
    if (!has_expected && !has_actual) return "the last line's end";
    if (has_expected && has_actual && expected_line == actual_line) continue;
    const auto quote = [](bool there, const std::string& line) {
      return there ? "'" + line + "'" : std::string("missing");
    };
    return fmt::format("line {} is {}, not {}", number, quote(has_actual, actual_line),
                       quote(has_expected, expected_line));
  }
}

fs::path points_copy(const fs::path& folder) {
  return folder / "points.txt";
}

void check_same_input(const fs::path& folder, const input::Parameters& parameters) {
  const fs::path file = input_copy(folder);
  if (!fs::exists(file)) return;
  check_same_text(folder, file, read_text(file), parameters.text);
  const fs::path points = points_copy(folder);
  if (!parameters.mesh.points || !fs::exists(points)) return;
  check_same_text(folder, points, read_text(points), read_text(*parameters.mesh.points));
}

SummaryReader summary_reader(const input::Parameters& parameters) {
  return [&parameters](const fs::path& file, std::uint64_t sample) {
    return io::read_summary(file, parameters, sample);
  };
}

SamplePlan make_plan(const fs::path& folder, const input::Parameters& parameters, bool resume,
                     const SummaryReader& read) {
  if (fs::exists(folder) && !fs::is_directory(folder)) {
    throw std::runtime_error(folder.string() + " is no folder; the results need one, or a name that is free");
  }
  if (!resume && holds_ensemble(folder)) {
    throw std::runtime_error(folder.string() +
                             " holds an ensemble already; continue it with --resume, or use another folder");
  }
  check_same_input(folder, parameters);

  SamplePlan plan;
  const auto n_samples = static_cast<std::uint64_t>(parameters.ensemble.samples);
  for (std::uint64_t sample = 0; sample < n_samples; ++sample) {
    const fs::path file = io::sample_path(folder, sample);
    if (fs::exists(fs::symlink_status(file))) {
      try {
        auto summary = read(file, sample);
        if (summary.status != analysis::SampleStatus::pending) {
          plan.kept.push_back({sample, std::move(summary)});
          continue;
        }
        plan.invalid.push_back({file, "it holds no result"});
      } catch (const std::exception& error) {
        plan.invalid.push_back({file, error.what()});
      }
    }
    plan.to_do.push_back(sample);
  }
  return plan;
}

void make_sample_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(sample_folder(folder), error);
  if (error) {
    throw std::runtime_error(
        fmt::format("{}: the folder cannot be made: {}", sample_folder(folder).string(), error.message()));
  }
}

std::vector<std::string> prepare_folder(const fs::path& folder, const input::Parameters& parameters,
                                        const SamplePlan& plan) {
  make_sample_folder(folder);
  std::vector<std::string> lines;
  for (const auto& invalid : plan.invalid) {
    const fs::path name = free_name(invalid.file);
    fs::rename(invalid.file, name);
    lines.push_back(fmt::format("{} is set aside as {} and computed again: {}", invalid.file.string(),
                                name.filename().string(), invalid.reason));
  }
  if (parameters.mesh.points) io::write_text_file(points_copy(folder), read_text(*parameters.mesh.points));
  io::write_text_file(input_copy(folder), parameters.text);
  return lines;
}

}  // namespace crackle::ensemble
