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

/// A lock as another rank finds it.
struct LockMark {
  std::filesystem::path file;
  std::string text;

  /// Refuses to write into a folder that is no longer the locked one: who holds a lock looks before it makes
  /// files, which would make a folder anew that was moved away.
  /// @throws std::runtime_error when the lock is not there or names another owner
  void require() const;
};

/// A file that names its owner and is created exclusively: one process has it at a time. Its owner touches it
/// every 30 s; a stale one (why_stale) is taken over. A lock whose folder is moved goes with it.
class LockFile {
public:
  static constexpr double lifetime = 600;  ///< [s]

  /// @param file in a folder that exists
  /// @param taken what it means that another process has it, for the message: "another run is at work in out"
  /// @param patience for how long another process' file is waited for [s]
  /// @throws std::runtime_error naming the file and its owner, when another process keeps it; when something
  ///   else has its name; or when it cannot be written
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

  /// One line for each stale lock that was taken over.
  const std::vector<std::string>& taken_over() const { return taken_over_; }

private:
  /// False if there is one.
  bool try_to_create() const;
  void create(const std::string& taken, double patience);
  /// What processes that were killed while they waited for the lock have left.
  void remove_leftovers() const;
  /// Whether the process that has made a file beside the lock is gone.
  bool is_left_over(const std::string& name, const char* mark) const;
  void keep_touching(const std::stop_token& stop);

  std::filesystem::path file_;
  std::string name_;
  int folder_;  ///< descriptor
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

/// A folder that is there while this lives; one that was made for this and is empty in the end goes again.
class MadeFolder {
public:
  /// @throws std::runtime_error naming the folder that cannot be made
  explicit MadeFolder(std::filesystem::path folder);
  ~MadeFolder();
  MadeFolder(const MadeFolder&) = delete;
  MadeFolder& operator=(const MadeFolder&) = delete;

private:
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_;  ///< innermost first
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
  LockMark mark() const { return lock_.mark(); }

private:
  MadeFolder folder_;
  LockFile lock_;
};

/// The processes at work in a folder, as the locks say that a killed run has not left behind.
std::vector<std::string> owners_at_work(const std::filesystem::path& folder);

}  // namespace crackle::ensemble
