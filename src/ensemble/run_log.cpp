// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/run_log.h"

#include "common/regular_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

namespace crackle::ensemble {

RunLog::RunLog(std::ostream& out, int terminal_width, Clock clock)
    : out_(out), terminal_width_(static_cast<std::size_t>(terminal_width)), clock_(std::move(clock)) {}

RunLog::~RunLog() {
  if (!shown_.empty()) out_ << std::endl;
}

void RunLog::end_progress() {
  clear();
  out_ << std::flush;
  shown_.clear();
}

void RunLog::clear() {
  if (!shown_.empty()) out_ << '\r' << std::string(shown_.size(), ' ') << '\r';
}

void RunLog::keep(const std::filesystem::path& file) {
  if (const std::string kind = other_kind(file); !kind.empty())
    return line(fmt::format("{} is {}: the log is not kept", file.string(), kind));
  file_ = file;
}

void RunLog::append(const std::string& text) const {
  if (!file_.empty() && other_kind(file_).empty()) std::ofstream(file_, std::ios::app) << text << '\n';
}

void RunLog::line(const std::string& text) {
  clear();
  out_ << text << '\n' << shown_ << std::flush;
  append(text);
}

void RunLog::show(const Progress& progress, bool news) {
  show([&] { return progress.line(clock_()); }, news);
}

void RunLog::show(const std::function<std::string()>& line, bool news) {
  news_ = news_ || news;
  const bool terminal = terminal_width_ > 0;
  const double since = clock_() - shown_at_;
  if (!file_.empty() && clock_() - kept_at_ >= log_interval) {
    append(line());
    kept_at_ = clock_();
  }
  const bool due = !anything_shown_ || since >= (terminal ? terminal_interval : log_interval);
  if (terminal ? !(due || news) : !(due && news_)) return;
  std::string text = line();
  if (terminal) {
    clear();
    text.resize(std::min(text.size(), terminal_width_ - 1));
    out_ << text << std::flush;
    shown_ = std::move(text);
  } else {
    out_ << text << std::endl;
  }
  shown_at_ = clock_();
  anything_shown_ = true;
  news_ = false;
}

std::filesystem::path run_log_file(const std::filesystem::path& folder,
                                   const std::optional<SampleRange>& part) {
  return folder / (part ? fmt::format("run-{:04}-{:04}.log", part->first, part->last) : "run.log");
}

}  // namespace crackle::ensemble
