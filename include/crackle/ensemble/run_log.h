// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/ensemble/folder_lock.h"
#include "crackle/ensemble/progress.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <string>

namespace crackle::ensemble {

/// What people see of a run, on rank 0. On a terminal the last line is the progress and renews itself; a log
/// has plain lines, with the progress at most every 30 s.
class RunLog {
public:
  using Clock = std::function<double()>;  ///< seconds

  /// @param out must outlive this
  /// @param terminal_width columns of the terminal that `out` is, which the progress line is cut to; 0 for a
  /// log
  RunLog(std::ostream& out, int terminal_width, Clock clock);
  /// Ends the progress line.
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// From now on, also appends every line to this file, and the progress every 30 s, so that the run can be
  /// watched from elsewhere. A run goes on when the file cannot be written.
  void keep(const std::filesystem::path& file);

  void line(const std::string& text);
  /// Shows the progress when it is time to; `news` when it has changed since the last call.
  void show(const Progress& progress, bool news);
  /// The same for any line, which is made when it is shown.
  void show(const std::function<std::string()>& line, bool news);
  /// Takes the progress off the terminal's last line.
  void end_progress();

private:
  void clear();
  /// To the file, which is closed again: a sweep has as many logs as cases.
  void append(const std::string& text) const;

  static constexpr double terminal_interval = 1;  ///< [s]
  static constexpr double log_interval = 30;      ///< [s]
  std::ostream& out_;
  std::size_t terminal_width_;
  Clock clock_;
  std::string shown_;  ///< progress that stands on the terminal's last line
  double shown_at_ = 0;
  bool anything_shown_ = false;
  bool news_ = false;  ///< not shown yet
  std::filesystem::path file_;
  double kept_at_ = 0;  ///< the last progress in the file
};

/// The file that a run keeps its log in: that of a part of the samples has their numbers in its name.
std::filesystem::path run_log_file(const std::filesystem::path& folder,
                                   const std::optional<SampleRange>& part);

}  // namespace crackle::ensemble
