// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

namespace crackle::ensemble {

/// The process that holds a lock, as the lock file names it. Files of earlier versions lack boot, namespace,
/// restart and step.
struct LockOwner {
  std::string host;
  std::string boot;           ///< id of the kernel's start; empty: not told
  std::string pid_namespace;  ///< in which `process` is a process number; empty: not told
  long process = 0;
  std::string start;          ///< clock ticks at which the process started; "0": not known
  std::string job;            ///< of SLURM; "-" outside
  std::uint64_t restart = 0;  ///< how often SLURM has requeued the job
  std::string step = "-";     ///< of the job; "-" in the job's script

  /// This process.
  static LockOwner self();
  /// Nothing when the text names no process.
  static std::optional<LockOwner> parse(std::string_view text);
  std::string text() const;
  std::string describe() const;

  bool operator==(const LockOwner&) const = default;
};

/// Why a lock's owner cannot be at work any more; nothing when it may be. Process numbers are looked up where
/// they are those of `self`'s host and process namespace, and decide. Elsewhere the owner has ended when it
/// belongs to an earlier start of `self`'s SLURM job (two steps of one start may both be at work), or when it
/// has not touched the lock for LockFile::lifetime.
/// @param owner nothing: of a lock that names none
std::optional<std::string> why_stale(const std::optional<LockOwner>& owner, const LockOwner& self,
                                     double seconds_untouched);

/// A file that names its owner and is created exclusively: one process has it at a time. Its owner touches it
/// every 30 s; a stale one (why_stale) is taken over.
class LockFile {
public:
  static constexpr double lifetime = 600;  ///< [s]

  /// Makes the file's folder if needed.
  /// @param taken what it means that another process has it, for the message: "another run is at work in out"
  /// @param patience for how long another process' file is waited for [s]
  /// @throws std::runtime_error naming the file and its owner, when another process keeps it; or when it
  ///   cannot be written
  LockFile(std::filesystem::path file, const std::string& taken, double patience);
  /// Removes the file, unless another process has taken it over.
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
  LockOwner self_ = LockOwner::self();
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
