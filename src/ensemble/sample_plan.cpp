// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/sample_plan.h"

#include "common/checksum.h"
#include "common/failure.h"
#include "common/regular_file.h"
#include "ensemble/results.h"
#include "input/reader.h"
#include "io/checkpoint_file.h"
#include "io/sample_file.h"
#include "io/text_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <map>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

constexpr const char* advice_for_others = "use that input, or another folder";

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
  return is_taken(input_copy(folder)) || is_taken(results_file(folder)) ||
         holds_anything(sample_folder(folder));
}

/// A setting in two inputs; empty if it is absent.
struct Difference {
  std::string key;
  std::string expected;
  std::string actual;
};

/// The settings ("key = value") that differ, each once, in the order of their keys.
std::vector<Difference> differences(const std::vector<std::string>& expected,
                                    const std::vector<std::string>& actual) {
  std::map<std::string, std::pair<std::string, std::string>> values;  // by key: expected, actual
  const auto sort_in = [&](const std::vector<std::string>& settings, auto member) {
    for (const auto& setting : settings) {
      const auto equals = setting.find(" = ");
      values[setting.substr(0, equals)].*member = setting.substr(equals + 3);
    }
  };
  sort_in(expected, &std::pair<std::string, std::string>::first);
  sort_in(actual, &std::pair<std::string, std::string>::second);
  std::vector<Difference> found;
  for (const auto& [key, value] : values)
    if (value.first != value.second) found.push_back({key, value.first, value.second});
  return found;
}

/// "mesh.spacing is 3 mm, not 2 mm" for each setting; "... differs" where a value is a long list.
std::string describe(const std::vector<Difference>& found) {
  constexpr std::size_t longest = 200;
  std::string text;
  const auto shown = [](const std::string& value) { return value.empty() ? "absent" : value; };
  for (const auto& [key, expected, actual] : found) {
    if (!text.empty()) text += ", ";
    text += expected.size() + actual.size() > longest
                ? key + " differs"
                : fmt::format("{} is {}, not {}", key, shown(actual), shown(expected));
  }
  return text;
}

/// Advice on settings that differ. The existing samples can be kept when these do not affect how they break.
/// @param wanted sections of the input that differs from the folder's
std::string advice(const fs::path& folder, const std::vector<Difference>& found,
                   const input::Sections& wanted) {
  bool has_sections = false, has_records = false;
  for (const auto& [key, expected, actual] : found) {
    const input::Affects affected = input::affects(key);
    has_sections = has_sections || affected == input::Affects::reading;
    has_records = has_records || affected == input::Affects::records;
    if (affected != input::Affects::reading && affected != input::Affects::records) return advice_for_others;
  }
  std::string text =
      fmt::format("keep the {} of the folder, or use another folder", !has_sections  ? "output"
                                                                      : !has_records ? "sections"
                                                                                     : "sections and output");
  if (has_sections)
    text += fmt::format("; use other sections later, with crackle stats {} --sections {}", folder.string(),
                        fmt::join(input::as_given(wanted), " --sections "));
  if (has_records) text += "; what is recorded cannot be changed afterwards";
  return text;
}

/// Differences between two inputs that matter for existing samples, with advice; empty if there are none.
std::optional<std::string> difference(const fs::path& folder, const std::string& text, const fs::path& file,
                                      const input::Parameters& parameters) {
  if (text == parameters.text) return std::nullopt;
  std::string found;
  try {
    const input::Parameters there = input::parse(text, file, copied_files(file.parent_path()));
    const auto settings = differences(input::sample_settings(there), input::sample_settings(parameters));
    if (!settings.empty()) return describe(settings) + "; " + advice(folder, settings, parameters.sections);
    if (parameters.ensemble.samples >= there.ensemble.samples) return std::nullopt;
    found = fmt::format("ensemble.samples is {}, fewer than {}", parameters.ensemble.samples,
                        there.ensemble.samples);
  } catch (const input::InputError&) {
    found = first_difference(text, parameters.text).value_or("");
  }
  return found + "; " + advice_for_others;
}

[[noreturn]] void refuse_older(const fs::path& folder, const io::OlderFormat& error) {
  fail(
      "{}: {}; continue with the program that started this ensemble, or start again in another folder; "
      "crackle stats and the report can still read this one",
      folder.string(), error.what());
}

/// Refuses to replace an existing file of the sample.
void check_is_free(const fs::path& file, const input::Parameters& parameters, std::uint64_t sample) {
  if (!fs::exists(fs::symlink_status(file))) return;
  bool has_failed = false;
  try {
    has_failed = summary_reader(parameters)(file, sample).status == analysis::SampleStatus::failed;
  } catch (const std::exception&) {
    // Damaged files are not silently replaced either.
  }
  fail("{} already holds this sample{}; keep it with --resume, or compute it again with {}--overwrite",
       file.string(), has_failed ? ", as one that failed" : "", has_failed ? "--retry-failed or " : "");
}

/// Removes temporary files of the samples in the range; all of them if the range is the whole ensemble, since
/// then no other run is active. Those of ensemble.h5 stay: another process may be recomputing the statistics
/// (write_results).
void remove_partial_files(const fs::path& folder, const input::Ensemble& ensemble, SampleRange range) {
  const auto n_samples = static_cast<std::uint64_t>(ensemble.samples);
  const bool is_whole = range.first == 0 && range.last + 1 == n_samples;
  std::error_code ignored;
  const auto is_partial = [](const fs::path& file) { return file.extension() == ".partial"; };
  for (const auto& entry : fs::directory_iterator(sample_folder(folder), ignored)) {
    std::uint64_t sample = 0;
    const std::string name = entry.path().filename().string();
    const bool has_number = std::from_chars(name.data(), name.data() + name.size(), sample).ec == std::errc{};
    const bool is_mine = is_whole || (has_number && range.first <= sample && sample <= range.last);
    if (is_mine && is_partial(entry.path())) fs::remove(entry.path(), ignored);
  }
  if (!is_whole) return;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (is_partial(entry.path()) && !is_of_results(entry.path())) fs::remove(entry.path(), ignored);
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

fs::path solid_copy(const fs::path& folder, const std::string& extension) {
  return folder / ("solid" + extension);
}

input::GivenFiles copied_files(const fs::path& folder) {
  input::GivenFiles files;
  if (is_taken(points_copy(folder))) files.points = points_copy(folder);
  for (const char* const extension : solid::extensions)
    if (const fs::path copy = solid_copy(folder, extension); is_taken(copy)) files.solid = copy;
  return files;
}

fs::path set_aside(const fs::path& file) {
  for (int i = 1;; ++i) {
    fs::path name = fmt::format("{}.invalid-{}", file.string(), i);
    if (is_taken(name)) continue;
    fs::rename(file, name);
    return name;
  }
}

void check_same_input(const fs::path& folder, const input::Parameters& parameters) {
  const fs::path file = input_copy(folder);
  if (!is_taken(file)) return;
  if (const auto found = difference(folder, read_text_if_any(file), file, parameters)) {
    fail("{} holds an ensemble of another input: compared with {}, {}", folder.string(), file.string(),
         *found);
  }
  const fs::path points = points_copy(folder);
  if (parameters.mesh.points && is_taken(points))
    if (const auto found =
            first_difference(read_text_if_any(points), read_text_if_any(*parameters.mesh.points)))
      fail("{} holds an ensemble of another input: compared with {}, {}; {}", folder.string(),
           points.string(), *found, advice_for_others);
  const auto& solid = parameters.specimen.solid;
  const fs::path other = copied_files(folder).solid;
  if (solid && is_taken(other))
    if (const auto there = file_digest(other); there != solid->digest)
      fail("{} holds an ensemble of another input: {} has {}, not {}; {}", folder.string(), other.string(),
           there.value_or("no content"), solid->digest, advice_for_others);
}

SummaryReader summary_reader(const input::Parameters& parameters) {
  return [&parameters](const fs::path& file, std::uint64_t sample) {
    return io::read_summary(file, parameters, sample);
  };
}

SampleRange part_of_samples(std::uint64_t number, std::uint64_t n_parts, std::uint64_t n_samples) {
  if (n_parts > n_samples)
    fail("{} parts are more than ensemble.samples = {}; give at most as many", n_parts, n_samples);
  return {n_samples * number / n_parts, n_samples * (number + 1) / n_parts - 1};
}

void check_folder(const fs::path& folder, const input::Parameters& parameters, const PlanOptions& options) {
  std::error_code error;
  if (is_taken(folder) && !fs::is_directory(folder, error)) {
    throw std::runtime_error(folder.string() + " is not a folder; give a folder, or a new name");
  }
  if (is_taken(folder / "sweep.toml")) fail("{} holds a sweep; use another folder", folder.string());
  if (!options.resume && holds_ensemble(folder)) {
    throw std::runtime_error(folder.string() +
                             " already holds an ensemble; continue it with --resume, or use another folder");
  }
  check_results(folder);
  try {
    io::check_model(folder);
  } catch (const io::OlderFormat& error) {
    refuse_older(folder, error);
  }
  check_same_input(folder, parameters);
  const auto n_samples = static_cast<std::uint64_t>(parameters.ensemble.samples);
  if (options.range && (options.range->first > options.range->last || options.range->last >= n_samples)) {
    fail("there are no samples {}-{}: ensemble.samples = {} has samples 0 to {}", options.range->first,
         options.range->last, n_samples, n_samples - 1);
  }
}

SamplePlan make_plan(const fs::path& folder, const input::Parameters& parameters, const PlanOptions& options,
                     const SummaryReader& read) {
  check_folder(folder, parameters, options);
  SamplePlan plan;
  const auto n_samples = static_cast<std::uint64_t>(parameters.ensemble.samples);
  const SampleRange range = options.range.value_or(SampleRange{0, n_samples - 1});
  plan.range = range;
  for (std::uint64_t sample = range.first; sample <= range.last; ++sample) {
    const fs::path file = io::sample_path(folder, sample);
    if (is_taken(file)) {
      try {
        auto summary = read(file, sample);
        if (summary.status == analysis::SampleStatus::failed && options.retry_failed) {
          plan.to_do.push_back(sample);
          plan.anew.push_back(sample);
          continue;
        }
        if (summary.status != analysis::SampleStatus::pending) {
          plan.kept.push_back({sample, std::move(summary)});
          continue;
        }
        plan.invalid.push_back({file, "it holds no result"});
      } catch (const io::OlderFormat& error) {
        refuse_older(folder, error);
      } catch (const std::exception& error) {
        plan.invalid.push_back({file, error.what()});
      }
    }
    plan.to_do.push_back(sample);
    const fs::path checkpoint = io::checkpoint_path(folder, sample);
    if (!is_taken(checkpoint)) continue;
    try {
      io::read_checkpoint(checkpoint, input::sample_identity(parameters), sample);
      plan.suspended.push_back(sample);
    } catch (const std::exception& error) {
      plan.invalid.push_back({checkpoint, error.what()});
    }
  }
  return plan;
}

void require_sample(const input::Ensemble& ensemble, std::uint64_t sample) {
  const auto n_samples = static_cast<std::uint64_t>(ensemble.samples);
  if (sample >= n_samples)
    fail("there is no sample {}: ensemble.samples = {} has samples 0 to {}", sample, n_samples,
         n_samples - 1);
}

SamplePlan plan_sample(const fs::path& folder, const input::Parameters& parameters,
                       const PlanOptions& options) {
  const std::uint64_t sample = options.single.value();
  require_sample(parameters.ensemble, sample);
  const PlanOptions as_range{
      .resume = true, .retry_failed = options.retry_failed, .range = SampleRange{sample, sample}};
  if (options.resume) return make_plan(folder, parameters, as_range, summary_reader(parameters));
  check_folder(folder, parameters, as_range);
  SamplePlan plan;
  plan.range = {sample, sample};
  plan.to_do = {sample};
  if (options.overwrite) {
    plan.anew = {sample};
    return plan;
  }
  check_is_free(io::sample_path(folder, sample), parameters, sample);
  const auto checkpoint = io::checkpoint_path(folder, sample);
  if (fs::exists(fs::symlink_status(checkpoint))) {
    throw std::runtime_error(
        checkpoint.string() +
        " is a checkpoint of this sample; continue with --resume, or start again with --overwrite");
  }
  return plan;
}

void make_sample_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(sample_folder(folder), error);
  if (error) fail("cannot make the folder '{}': {}", sample_folder(folder).string(), error.message());
}

bool restore_input(const fs::path& folder, const input::Parameters& parameters) {
  bool is_restored = false;
  const auto restore = [&](const fs::path& copy, const auto& text) {
    if (is_taken(copy)) return;
    io::write_text_file(copy, text());
    is_restored = true;
  };
  restore(input_copy(folder), [&] { return parameters.text; });
  if (parameters.mesh.points)
    restore(points_copy(folder), [&] { return read_text_if_any(*parameters.mesh.points); });
  if (const auto& solid = parameters.specimen.solid)
    restore(solid_copy(folder, solid->extension), [&] { return solid->content; });
  return is_restored;
}

std::vector<std::string> prepare_folder(const fs::path& folder, const input::Parameters& parameters,
                                        const SamplePlan& plan) {
  make_sample_folder(folder);
  std::vector<std::string> lines;
  for (const auto& invalid : plan.invalid) {
    const fs::path name = set_aside(invalid.file);
    lines.push_back(fmt::format("{} is renamed to {} and the sample computed again: {}",
                                invalid.file.string(), name.filename().string(), invalid.reason));
  }
  std::error_code ignored;
  for (const auto& kept : plan.kept) fs::remove(io::checkpoint_path(folder, kept.sample), ignored);
  for (const auto sample : plan.anew) {
    // The file is removed last, so that a kill in between leaves no checkpoint to continue from. Without the
    // file the sample is pending; with a checkpoint it would be suspended and --resume would continue it.
    fs::remove(io::checkpoint_path(folder, sample));
    fs::remove(io::sample_path(folder, sample));
  }
  remove_partial_files(folder, parameters.ensemble, plan.range);
  const auto keep_copy = [](const fs::path& copy, const std::string& text) {
    if (!is_taken(copy) || read_text_if_any(copy) != text) io::write_text_file(copy, text);
  };
  keep_copy(input_copy(folder), parameters.text);
  if (parameters.mesh.points) keep_copy(points_copy(folder), read_text_if_any(*parameters.mesh.points));
  if (const auto& solid = parameters.specimen.solid)
    keep_copy(solid_copy(folder, solid->extension), solid->content);
  return lines;
}

}  // namespace crackle::ensemble
