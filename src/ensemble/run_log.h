// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/folder_lock.h"
#include "ensemble/progress.h"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <string>

namespace crackle::ensemble {

/// Messages of a run to the user, on rank 0. On a terminal the last line shows the progress and is updated in
/// place; a log gets plain lines, with the progress at most every 30 s.
class RunLog {
public:
  using Clock = std::function<double()>;  ///< seconds

  /// @param out must outlive this
  /// @param terminal_width columns of the terminal `out`, to which the progress line is truncated; 0 for a
  ///   log
  RunLog(std::ostream& out, int terminal_width, Clock clock);
  /// Ends the progress line.
  ~RunLog();
  RunLog(const RunLog&) = delete;
  RunLog& operator=(const RunLog&) = delete;

  /// From now on, also appends every line to this file, and the progress every 30 s, so that the run can be
  /// watched from elsewhere. Failures to write the file are ignored.
  void keep(const std::filesystem::path& file);

  void line(const std::string& text);
  /// Shows the progress when due; `news`: it has changed since the last call.
  void show(const Progress& progress, bool news);
  /// The same for any line, which is only built when shown.
  void show(const std::function<std::string()>& line, bool news);
  /// Clears the progress from the terminal's last line.
  void end_progress();

private:
  void clear();
  /// Opens and closes the file each time: a sweep has one log per case.
  void append(const std::string& text) const;

  static constexpr double terminal_interval = 1;  ///< [s]
  static constexpr double log_interval = 30;      ///< [s]
  std::ostream& out_;
  std::size_t terminal_width_;
  Clock clock_;
  std::string shown_;  ///< progress shown on the terminal's last line
  double shown_at_ = 0;
  bool anything_shown_ = false;
  bool news_ = false;  ///< not shown yet
  std::filesystem::path file_;
  double kept_at_ = 0;  ///< time of the last progress written to the file
};

/// The log file of a run; that of a range of samples has their numbers in its name.
std::filesystem::path run_log_file(const std::filesystem::path& folder,
                                   const std::optional<SampleRange>& part);

}  // namespace crackle::ensemble
