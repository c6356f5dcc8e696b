// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace crackle::ensemble {

/// Samples first..last of an ensemble.
struct SampleRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// Keeps other runs away from samples of a folder while it lives: a file "lock-<first>-<last>" that names
/// host, process and SLURM job, created exclusively. Runs of ranges that do not overlap do not mind each
/// other.
///
/// A lock is stale, and taken over, when its process on this host is gone, when it is of this SLURM job's
/// own earlier start, or when its owner has not touched it for `lifetime`; an owner touches it every 30 s.
class FolderLock {
public:
  static constexpr double lifetime = 600;  ///< [s]

  /// Makes the folder if needed.
  /// @throws std::runtime_error naming the lock's file and its owner, when another run has it; or when the
  ///   lock cannot be written
  FolderLock(const std::filesystem::path& folder, SampleRange range);
  /// Removes the lock.
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// One line for each stale lock that was taken over.
  const std::vector<std::string>& taken_over() const { return taken_over_; }

private:
  void create();
  void clear_others(const std::filesystem::path& folder, SampleRange range);
  void keep_touching(const std::stop_token& stop);

  std::filesystem::path file_;
  std::vector<std::string> taken_over_;
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;  ///< last: it ends before what it uses
};

}  // namespace crackle::ensemble
