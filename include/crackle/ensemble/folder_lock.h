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

/// A file that names host, process and SLURM job and is created exclusively: one process has it at a time.
///
/// It is stale, and taken over, when its process on this host is gone, when it is of this SLURM job's own
/// earlier start, or when its owner has not touched it for `lifetime`; an owner touches it every 30 s.
class LockFile {
public:
  static constexpr double lifetime = 600;  ///< [s]

  /// Makes the file's folder if needed.
  /// @param taken what it means that another process has it, for the message: "another run is at work in out"
  /// @param patience for how long another process' file is waited for [s]
  /// @throws std::runtime_error naming the file and its owner, when another process keeps it; or when it
  ///   cannot be written
  LockFile(std::filesystem::path file, const std::string& taken, double patience);
  /// Removes the file.
  ~LockFile();
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;

  const std::filesystem::path& file() const { return file_; }

  /// Removes another lock when it is stale.
  /// @throws std::runtime_error as the constructor, when it is not
  void clear(const std::filesystem::path& other, const std::string& taken);

  /// One line for each stale lock that was taken over.
  const std::vector<std::string>& taken_over() const { return taken_over_; }

private:
  void create(const std::string& taken, double patience);
  void keep_touching(const std::stop_token& stop);

  std::filesystem::path file_;
  std::vector<std::string> taken_over_;
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;  ///< last: it ends before what it uses
};

/// Samples first..last of an ensemble.
struct SampleRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// Keeps other runs away from samples of a folder while it lives: a lock file "lock-<first>-<last>". Runs of
/// ranges that do not overlap do not mind each other.
class FolderLock {
public:
  /// Makes the folder if needed.
  /// @throws std::runtime_error naming the lock's file and its owner, when another run has it; or when the
  ///   lock cannot be written
  FolderLock(const std::filesystem::path& folder, SampleRange range);

  /// One line for each stale lock that was taken over.
  const std::vector<std::string>& taken_over() const { return lock_.taken_over(); }

private:
  LockFile lock_;
};

}  // namespace crackle::ensemble
