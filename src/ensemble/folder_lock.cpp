// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/folder_lock.h"

#include "crackle/common/failure.h"
#include "crackle/common/stopwatch.h"
#include "crackle/common/whole_number.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

constexpr std::chrono::seconds touch_interval{30};
/// For a run that was just killed to be gone.
constexpr double patience = 3;  // [s]
/// Pauses between two looks at another's lock: a waiting process should not keep a file system busy.
constexpr double short_wait = 3;  // [s] with short pauses
constexpr std::chrono::milliseconds short_pause{100};
constexpr std::chrono::milliseconds long_pause{1000};

/// Empty if the file does not exist.
std::string text_if_any(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Where a link of /proc leads; empty without one.
std::string link_target(const char* link) {
  std::error_code ignored;
  return fs::read_symlink(link, ignored).string();
}

constexpr const char* unknown_start = "0";
constexpr const char* ended = "ended";

/// Clock ticks since the machine's start at which a process of this namespace started: tells it from a later
/// one of the same number.
std::string start_of(long process) {
  // /proc may be that of another process namespace, such as the one that a container was started from.
  if (link_target("/proc/self") != std::to_string(::getpid())) return unknown_start;
  const std::string text = text_if_any(fmt::format("/proc/{}/stat", process));
  const auto name_end = text.rfind(')');
  if (name_end == std::string::npos) return unknown_start;
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  fields >> field;
  // A process that has ended stays as a zombie where nobody asks for its status.
  if (field == "Z" || field == "X") return ended;
  constexpr int starttime = 22 - 2;  // of the fields behind the name
  for (int i = 1; i < starttime; ++i) fields >> field;
  return field.empty() ? unknown_start : field;
}

/// Whether a process of this host and namespace is at work.
bool is_at_work(const LockOwner& owner) {
  if (::kill(static_cast<pid_t>(owner.process), 0) != 0 && errno == ESRCH) return false;
  const std::string start = start_of(owner.process);
  if (start == ended) return false;
  return start == unknown_start || owner.start == unknown_start || start == owner.start;
}

/// A word of the environment; `absent` without it.
std::string environment_word(const char* name, const char* absent) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0 ? value : absent;
}

/// Seconds since the lock was touched, by the file system's own clock: `mine` was just touched.
double age(const fs::path& file, const fs::path& mine) {
  struct stat theirs {};
  struct stat ours {};
  if (::stat(file.c_str(), &theirs) != 0 || ::stat(mine.c_str(), &ours) != 0) return 0;
  return std::difftime(ours.st_mtime, theirs.st_mtime);
}

std::optional<SampleRange> range_of(const fs::path& file) {
  constexpr std::string_view prefix = "lock-";
  const std::string name = file.filename().string();
  const auto dash = name.find('-', prefix.size());
  if (!name.starts_with(prefix) || dash == std::string::npos) return std::nullopt;
  const auto first =
      whole_number<std::uint64_t>(std::string_view(name).substr(0, dash).substr(prefix.size()));
  const auto last = whole_number<std::uint64_t>(std::string_view(name).substr(dash + 1));
  if (!first || !last) return std::nullopt;
  return SampleRange{*first, *last};
}

/// A name beside the lock that no other process uses, on whatever host and in whatever namespace.
fs::path beside(const fs::path& file, const char* purpose, const LockOwner& self) {
  return fmt::format("{}.{}-{}-{}-{}-{}", file.string(), purpose, self.host, self.boot, self.pid_namespace,
                     self.process);
}

/// @throws std::runtime_error: what is taken, by whom, and what to do
[[noreturn]] void refuse(const std::string& taken, const std::string& text, const fs::path& file) {
  const auto owner = LockOwner::parse(text);
  fail("{}: {}; wait until it ends, or remove {} if it is no longer running", taken,
       owner ? owner->describe() : "its lock names no owner", file.string());
}

/// Takes a stale lock away. It is renamed first and looked at again, so that of two runs that find it only
/// one succeeds and a lock that was made meanwhile is put back.
void remove_stale(const fs::path& file, const std::string& text, const LockOwner& self) {
  const fs::path aside = beside(file, "stale", self);
  if (::rename(file.c_str(), aside.c_str()) != 0) return;
  if (text_if_any(aside) != text) {
    if (::link(aside.c_str(), file.c_str()) != 0 && errno != EEXIST)
      throw std::runtime_error(file.string() + ": " + std::strerror(errno));
  }
  ::unlink(aside.c_str());
}

}  // namespace

LockOwner LockOwner::self() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name[0] = '?';
  LockOwner self;
  self.host = name.data();
  std::istringstream(text_if_any("/proc/sys/kernel/random/boot_id")) >> self.boot;
  // "pid:[4026531836]"
  const std::string space = link_target("/proc/self/ns/pid");
  if (const auto from = space.find('['); from != std::string::npos)
    self.pid_namespace = space.substr(from + 1, space.find(']') - from - 1);
  self.process = ::getpid();
  self.start = start_of(self.process);
  self.job = environment_word("SLURM_JOB_ID", "-");
  self.restart = whole_number<std::uint64_t>(environment_word("SLURM_RESTART_COUNT", "0")).value_or(0);
  self.step = environment_word("SLURM_STEP_ID", "-");
  return self;
}

std::optional<LockOwner> LockOwner::parse(std::string_view text) {
  LockOwner owner;
  std::string name, value;
  for (std::istringstream stream{std::string(text)}; stream >> name >> value;) {
    if (name == "host") owner.host = value;
    if (name == "boot") owner.boot = value;
    if (name == "namespace") owner.pid_namespace = value;
    if (name == "process") owner.process = whole_number<long>(value).value_or(0);
    if (name == "start") owner.start = value;
    if (name == "job") owner.job = value;
    if (name == "restart") owner.restart = whole_number<std::uint64_t>(value).value_or(0);
    if (name == "step") owner.step = value;
  }
  // The last lines may be missing where a disk is full.
  if (owner.host.empty() || owner.process <= 0 || owner.start.empty() || owner.job.empty())
    return std::nullopt;
  return owner;
}

std::string LockOwner::text() const {
  std::string lines = fmt::format("host {}\nprocess {}\nstart {}\njob {}\n", host, process, start, job);
  if (!boot.empty()) lines += fmt::format("boot {}\n", boot);
  if (!pid_namespace.empty()) lines += fmt::format("namespace {}\n", pid_namespace);
  return lines + fmt::format("restart {}\nstep {}\n", restart, step);
}

std::string LockOwner::describe() const {
  std::string text = fmt::format("process {} on {}", process, host);
  if (job == "-") return text;
  text += ", SLURM job " + job;
  if (step != "-") text += " step " + step;
  if (restart > 0) text += fmt::format(", restart {}", restart);
  return text;
}

std::optional<std::string> why_stale(const std::optional<LockOwner>& owner, const LockOwner& self,
                                     double seconds_untouched) {
  // What an earlier version has not told it took for the same.
  const auto is_same = [](const std::string& theirs, const std::string& ours) {
    return theirs.empty() || theirs == ours;
  };
  if (owner && owner->host == self.host && is_same(owner->boot, self.boot) &&
      is_same(owner->pid_namespace, self.pid_namespace)) {
    if (is_at_work(*owner)) return std::nullopt;
    return fmt::format("{} has ended without removing it", owner->describe());
  }
  if (owner && owner->job != "-" && owner->job == self.job && owner->restart < self.restart)
    return fmt::format("{} was an earlier start of this job", owner->describe());
  if (seconds_untouched > LockFile::lifetime)
    return fmt::format("{} has not touched it for {:.0f} min", owner ? owner->describe() : "its owner",
                       seconds_untouched / 60);
  return std::nullopt;
}

LockFile::LockFile(fs::path file, const std::string& taken, double patience) : file_(std::move(file)) {
  const fs::path folder = file_.parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail("{}: the folder cannot be made: {}", folder.string(), error.message());
  create(taken, patience);
  thread_ = std::jthread([this](const std::stop_token& stop) { keep_touching(stop); });
}

LockFile::~LockFile() {
  if (text_if_any(file_) == self_.text()) ::unlink(file_.c_str());
}

void LockFile::create(const std::string& taken, double patience) {
  const Stopwatch clock;
  for (;;) {
    const int id = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    const int reason = errno;
    if (id >= 0) {
      const std::string text = self_.text();
      const bool is_written = ::write(id, text.data(), text.size()) == static_cast<ssize_t>(text.size());
      const int write_error = errno;
      if (::close(id) == 0 && is_written) return;
      ::unlink(file_.c_str());
      fail("cannot write '{}': {}", file_.string(), std::strerror(write_error));
    }
    if (reason != EEXIST) fail("cannot write '{}': {}", file_.string(), std::strerror(reason));
    const fs::path probe = beside(file_, "probe", self_);
    std::ofstream(probe) << "\n";
    const std::string text = text_if_any(file_);
    const auto reason_stale = why_stale(LockOwner::parse(text), self_, age(file_, probe));
    ::unlink(probe.c_str());
    if (!reason_stale && clock.seconds() < patience) {
      std::this_thread::sleep_for(clock.seconds() < short_wait ? short_pause : long_pause);
      continue;
    }
    if (!reason_stale) refuse(taken, text, file_);
    remove_stale(file_, text, self_);
    taken_over_.push_back(fmt::format("the lock {} is taken over: {}", file_.string(), *reason_stale));
  }
}

void LockFile::clear(const fs::path& other, const std::string& taken) {
  const std::string text = text_if_any(other);
  const auto reason = why_stale(LockOwner::parse(text), self_, age(other, file_));
  if (!reason) {
    if (fs::exists(other)) refuse(taken, text, other);
    return;
  }
  remove_stale(other, text, self_);
  taken_over_.push_back(fmt::format("the lock {} is taken over: {}", other.string(), *reason));
}

void LockFile::keep_touching(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ends_.wait_for(lock, stop, touch_interval, [&] { return stop.stop_requested(); }))
    ::utimensat(AT_FDCWD, file_.c_str(), nullptr, 0);
}

FolderLock::FolderLock(const fs::path& folder, SampleRange range)
    : lock_(folder / fmt::format("lock-{}-{}", range.first, range.last),
            fmt::format("another run is at work in {}", folder.string()), patience) {
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto other = range_of(entry.path());
    if (!other || entry.path().filename() == lock_.file().filename()) continue;
    if (other->first <= range.last && range.first <= other->last) others.push_back(entry.path());
  }
  for (const auto& other : others)
    lock_.clear(other, fmt::format("another run is at work on some of these samples in {}", folder.string()));
}

}  // namespace crackle::ensemble
