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

/// The process that holds a lock, as recorded in the lock file. Files of earlier versions lack boot,
/// namespace, restart and step.
struct LockOwner {
  std::string host;
  std::string boot;           ///< boot id of the kernel; empty: not recorded
  std::string pid_namespace;  ///< PID namespace of `process`; empty: not recorded
  long process = 0;
  std::string start;          ///< start time of the process [clock ticks]; "0": unknown
  std::string job;            ///< SLURM job; "-" outside SLURM
  std::uint64_t restart = 0;  ///< how often SLURM has requeued the job
  std::string step = "-";     ///< job step; "-" in the batch script

  static LockOwner self();
  /// Empty if the text names no process.
  static std::optional<LockOwner> parse(std::string_view text);
  std::string text() const;
  std::string describe() const;

  bool operator==(const LockOwner&) const = default;
};

/// Why the owner of a lock cannot be running any more; empty if it may be. If the owner is on `self`'s host
/// and in its PID namespace, its process number decides. Otherwise the owner has ended if it belongs to an
/// earlier start of `self`'s SLURM job (two steps of the same start may both be running), or if it has not
/// touched the lock for LockFile::lifetime.
/// @param owner empty: the lock names none
std::optional<std::string> why_stale(const std::optional<LockOwner>& owner, const LockOwner& self,
                                     double seconds_untouched);

/// A lock as seen by another rank.
struct LockMark {
  std::filesystem::path file;
  std::string text;

  /// Refuses to write into a folder that is no longer the locked one. Call it before creating files:
  /// otherwise a folder that was moved away would be recreated.
  /// @throws std::runtime_error when the lock is missing or names another owner
  void require() const;
};

/// A file that names its owner and is created exclusively, so that only one process holds it at a time. The
/// owner touches it every 30 s; a stale one (why_stale) is taken over. The lock moves along with its folder.
class LockFile {
public:
  static constexpr double lifetime = 600;  ///< [s]

  /// @param file in an existing folder
  /// @param taken message when another process holds it: "another run is active in out"
  /// @param patience how long to wait for another process' lock [s]
  /// @throws std::runtime_error naming the file and its owner, when another process keeps it; when the name
  ///   is taken by something other than a lock; or when it cannot be written
  LockFile(std::filesystem::path file, const std::string& taken, double patience);
  /// Removes the file, unless another process has taken it over.
  ~LockFile();
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;

  const std::filesystem::path& file() const { return file_; }
  LockMark mark() const { return {file_, self_.text()}; }

  /// Removes another lock of the folder when it is stale.
  /// @throws std::runtime_error as the constructor, when it is not
  void clear(const std::filesystem::path& other, const std::string& taken);

  /// One line for each stale lock taken over.
  const std::vector<std::string>& taken_over() const { return taken_over_; }

private:
  /// False if the lock exists already.
  bool try_to_create() const;
  /// Removes the file if it is this lock's; closes the folder.
  void release() const;
  void create(const std::string& taken, double patience);
  /// Removes files of processes that were killed while waiting for the lock.
  void remove_leftovers() const;
  /// True if the process that created a file beside the lock is gone.
  bool is_left_over(const std::string& name, const char* mark) const;
  void keep_touching(const std::stop_token& stop);

  std::filesystem::path file_;
  std::string name_;
  int folder_;  ///< descriptor
  LockOwner self_ = LockOwner::self();
  std::vector<std::string> taken_over_;
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread thread_;  ///< last member: joined before the others are destroyed
};

/// Samples first..last of an ensemble.
struct SampleRange {
  std::uint64_t first = 0;
  std::uint64_t last = 0;
};

/// A folder that exists at least as long as this object; if created by it and empty at the end, it is
/// removed.
class MadeFolder {
public:
  /// @throws std::runtime_error naming the folder that cannot be created
  explicit MadeFolder(std::filesystem::path folder);
  ~MadeFolder();
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;

private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_;  ///< innermost first
};

/// Locks a range of samples of a folder against other runs, with a lock file "lock-<first>-<last>". Runs on
/// disjoint ranges can proceed concurrently.
class FolderLock {
public:
  /// Creates the folder if needed.
  /// @throws std::runtime_error naming the lock file and its owner, when another run holds it; or when the
  ///   lock cannot be written
  FolderLock(const std::filesystem::path& folder, SampleRange range);

  /// One line for each stale lock taken over.
  const std::vector<std::string>& taken_over() const { return lock_.taken_over(); }
  LockMark mark() const { return lock_.mark(); }

private:
  MadeFolder folder_;
  LockFile lock_;
};

/// Processes at work in a folder, according to its locks; stale locks are ignored.
std::vector<std::string> owners_at_work(const std::filesystem::path& folder);

}  // namespace crackle::ensemble
