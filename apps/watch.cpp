// SPDX-License-Identifier: GPL-3.0-or-later
// crackle watch: repeatedly shows the results of a running ensemble so far. Reads only.
#include "analysis/result_list.h"
#include "commands.h"
#include "common/regular_file.h"
#include "ensemble/folder_lock.h"
#include "ensemble/progress.h"
#include "ensemble/sample_report.h"
#include "io/checkpoint_file.h"
#include "io/sample_file.h"
#include "parallel/agreement.h"

#include "ensemble_folder.h"
#include "parallel_command.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <deque>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;
using analysis::ResultInfo;
using analysis::SampleStatus;
using analysis::SampleSummary;

struct WatchOptions {
  fs::path folder;
  double interval = 2;  // [s]
  int log_lines = 8;
  bool once = false;
};

constexpr std::size_t rows_without_terminal = 1'000'000;

/// The newest samples, from their files; each file is read once.
class Folder {
public:
  Folder(fs::path folder, const input::Parameters& parameters)
      : folder_(std::move(folder)), parameters_(&parameters) {}

  struct Sample {
    fs::file_time_type ended;
    SampleSummary row;
  };

  void update() {
    std::error_code ignored;
    std::optional<io::SampleReader> reader;
    for (std::uint64_t i = 0; i < n_samples(); ++i) {
      const fs::path file = io::sample_path(folder_, i);
      const auto time = fs::last_write_time(file, ignored);
      if (ignored) {
        samples_.erase(i);
      } else if (const auto known = samples_.find(i);
                 known == samples_.end() || known->second.ended != time) {
        if (!reader) reader.emplace(folder_, *parameters_);
        SampleSummary row = reader->row(i);
        samples_.insert_or_assign(i, Sample{time, std::move(row)});
      }
    }
  }

  std::uint64_t n_samples() const { return static_cast<std::uint64_t>(parameters_->ensemble.samples); }
  const std::map<std::uint64_t, Sample>& samples() const { return samples_; }
  /// Counts over the samples 0 to n - 1.
  std::size_t count(SampleStatus status, std::uint64_t n) const {
    return static_cast<std::size_t>(std::ranges::count_if(
        samples_, [&](const auto& entry) { return entry.first < n && entry.second.row.status == status; }));
  }
  const fs::path& path() const { return folder_; }

  /// Samples with a checkpoint, and its age [s].
  std::map<std::uint64_t, double> checkpoints() const {
    std::map<std::uint64_t, double> ages;
    std::error_code ignored;
    for (std::uint64_t i = 0; i < n_samples(); ++i) {
      if (samples_.contains(i)) continue;
      const auto time = fs::last_write_time(io::checkpoint_path(folder_, i), ignored);
      if (!ignored) ages[i] = std::chrono::duration<double>(fs::file_time_type::clock::now() - time).count();
    }
    return ages;
  }

  /// The last lines of the most recently written log of the run.
  std::deque<std::string> log(int n_lines) const {
    fs::path newest;
    fs::file_time_type time{};
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with("run") || entry.path().extension() != ".log") continue;
      if (!other_kind(entry.path()).empty()) continue;
      const auto written = fs::last_write_time(entry.path(), ignored);
      if (newest.empty() || written > time) newest = entry.path(), time = written;
    }
    std::deque<std::string> lines;
    std::ifstream file(newest);
    for (std::string line; std::getline(file, line);) {
      lines.push_back(line);
      if (std::ssize(lines) > n_lines) lines.pop_front();
    }
    return lines;
  }

private:
  fs::path folder_;
  const input::Parameters* parameters_;
  std::map<std::uint64_t, Sample> samples_;
};

template <class Value>
std::string cell(const ResultInfo& info, Value SampleSummary::*member, const SampleSummary& row) {
  if (row.status != SampleStatus::done) return "";
  const Value value = row.*member;
  if (*info.categories != 0)
    return analysis::category_name(info.categories, static_cast<std::int64_t>(value));
  if constexpr (std::is_floating_point_v<Value>) {
    return analysis::shown(
        std::isnan(value) ? analysis::Observation{} : analysis::observed(info, member, row), info.format,
        info.shown_factor);
  } else {
    return fmt::format("{}", value);
  }
}

/// @param headline the most important result, which comes first if it is the peak load
std::string table(const std::vector<const Folder::Sample*>& samples,
                  const std::vector<std::uint64_t>& numbers, std::string_view headline) {
  TextTable columns{{"sample"}, {"status"}};
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const auto status = static_cast<std::int64_t>(samples[k]->row.status);
    columns[0].push_back(fmt::format("{}", numbers[k]));
    columns[1].push_back(analysis::category_name(analysis::status_categories, status));
  }
  analysis::for_each_result([&](const ResultInfo& info, auto member) {
    if ((info.short_tables & analysis::in_watch) == 0) return;
    std::vector<std::string> column{with_unit(info.label, info.shown_units)};
    for (const auto* sample : samples) column.push_back(cell(info, member, sample->row));
    // Columns without any value are omitted.
    const auto is_value = [](const std::string& text) { return !text.empty() && text != "-"; };
    if (std::any_of(column.begin() + 1, column.end(), is_value))
      columns.insert(info.name == headline && headline == "peak_load" ? columns.begin() + 2 : columns.end(),
                     std::move(column));
  });
  columns.push_back({"took"});
  for (const auto* sample : samples)
    columns.back().push_back(sample->row.status == SampleStatus::failed
                                 ? sample->row.error
                                 : duration_text(sample->row.wall_time));
  TextTable rows(samples.size() + 1);
  for (const auto& column : columns)
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k].push_back(column[k]);
  return aligned(rows, 0, true);
}

/// The current state of the ensemble.
struct Standing {
  std::string text;
  bool is_over = false;  ///< no sample left and no run active
};

/// @param n_rows of the terminal
Standing standing(const Folder& folder, const input::Parameters& parameters, const WatchOptions& options,
                  std::size_t n_rows) {
  ensemble::Progress progress(0, 1, parameters);
  for (const auto& [number, sample] : folder.samples())
    if (sample.row.status != SampleStatus::pending) progress.kept(number, sample.row);
  const std::uint64_t n_needed = progress.statistics().stopped_at().value_or(folder.n_samples());
  const auto n_done = folder.count(SampleStatus::done, n_needed);
  const auto n_failed = folder.count(SampleStatus::failed, n_needed);
  const auto n_left = n_needed - n_done - n_failed;
  std::string text = fmt::format("{}: {} done, {} failed, {} pending of {}\n", folder.path().string(), n_done,
                                 n_failed, n_left, n_needed);
  if (n_needed < folder.n_samples())
    text += fmt::format("stopped early: these samples suffice, {} were planned\n", folder.n_samples());
  const auto owners = ensemble::owners_at_work(folder.path());
  if (owners.empty()) text += "no run is active here\n";
  for (const auto& owner : owners) text += fmt::format("active: {}\n", owner);
  if (const auto means = progress.means(); !means.empty()) text += means + "\n";
  for (const auto& [number, age] : folder.checkpoints())
    text += fmt::format("sample {} has a checkpoint, {} old\n", number, duration_text(age));

  const std::deque<std::string> log = folder.log(options.log_lines);
  const auto n_used = static_cast<std::size_t>(std::ranges::count(text, '\n')) + log.size() + 5;
  std::vector<std::pair<fs::file_time_type, std::uint64_t>> newest;
  for (const auto& [number, sample] : folder.samples()) newest.emplace_back(sample.ended, number);
  std::ranges::sort(newest, std::greater());
  newest.resize(std::min(newest.size(), n_rows > n_used + 3 ? n_rows - n_used : std::size_t{3}));
  std::vector<std::uint64_t> numbers;
  for (const auto& [time, number] : newest) numbers.push_back(number);
  std::ranges::sort(numbers);
  std::vector<const Folder::Sample*> samples;
  for (const auto number : numbers) samples.push_back(&folder.samples().at(number));
  if (!samples.empty()) {
    text += samples.size() < folder.samples().size()
                ? fmt::format("\nthe last {} samples that ended\n", samples.size())
                : "\n";
    text += table(samples, numbers, progress.statistics().median_load().name);
  }
  if (!log.empty()) {
    text += "\n";
    for (const auto& line : log) text += line + "\n";
  }
  return {std::move(text), n_left == 0 && owners.empty()};
}

std::size_t terminal_height() {
  winsize size{};
  if (::isatty(STDOUT_FILENO) == 0 || ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_row == 0)
    return rows_without_terminal;
  return size.ws_row;
}

/// Truncates lines to the width of the terminal.
std::string cut(const std::string& text, int width) {
  if (width <= 0) return text;
  std::string result;
  std::size_t start = 0;
  while (start < text.size()) {
    const std::size_t end = text.find('\n', start);
    result += text.substr(start, std::min(end - start, static_cast<std::size_t>(width))) + "\n";
    start = end + 1;
  }
  return result;
}

void watch(const WatchOptions& options, const input::Parameters& parameters) {
  Folder folder(options.folder, parameters);
  const int width = terminal_width(STDOUT_FILENO);
  for (;;) {
    folder.update();
    const auto [text, is_over] = standing(folder, parameters, options, terminal_height());
    // On a terminal each output replaces the previous one.
    fmt::print("{}{}", width > 0 && !options.once ? "\033[H\033[2J" : "", cut(text, width));
    std::fflush(stdout);
    if (options.once || is_over) return;
    std::this_thread::sleep_for(std::chrono::duration<double>(options.interval));
    if (width <= 0) fmt::print("\n");
  }
}

}  // namespace

void add_watch_command(CLI::App& app, Action& run) {
  auto options = std::make_shared<WatchOptions>();
  auto* command = app.add_subcommand(
      "watch",
      "Show the progress of a running ensemble, updated regularly: its samples, means and last log lines");
  command->add_option("folder", options->folder, "output folder of crackle run, or the ensemble.h5 in it")
      ->required();
  command->add_option("--interval", options->interval, "seconds between two updates")
      ->check(CLI::Range(0.1, 86400.0))
      ->capture_default_str();
  command->add_option("--log", options->log_lines, "last lines of the run's log to show")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command->add_flag("--once", options->once, "update once");
  command->footer("Reads only, and ends with the ensemble. Ctrl-C ends it at any time; the run goes on.");
  command->callback([options, &run] {
    run.work = [options](const parallel::Communicator& world) {
      options->folder = folder_of(world, options->folder);
      const input::Parameters parameters = input_of(world, options->folder);
      parallel::agree_on_root(world, [&] { watch(*options, parameters); });
      return static_cast<int>(success);
    };
  });
}

}  // namespace crackle::apps
