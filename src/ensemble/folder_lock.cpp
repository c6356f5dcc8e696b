// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/folder_lock.h"

#include "common/failure.h"
#include "common/regular_file.h"
#include "common/stopwatch.h"
#include "common/whole_number.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <ctime>
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
/// Time for a run that was just killed to disappear.
constexpr double patience = 3;  // [s]
/// Pauses between two checks of another process' lock; long ones keep the load on the file system low.
constexpr double short_wait = 3;  // [s] with short pauses
constexpr std::chrono::milliseconds short_pause{100};
constexpr std::chrono::milliseconds long_pause{1000};

/// Contents of a file in /proc; empty if it does not exist.
std::string kernel_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Target of a link in /proc; empty if there is none.
std::string link_target(const char* link) {
  std::error_code ignored;
  return fs::read_symlink(link, ignored).string();
}

constexpr const char* unknown_start = "0";
constexpr const char* ended = "ended";

/// Start time of a process of this namespace, in clock ticks since boot: distinguishes it from a later
/// process with the same number.
std::string start_of(long process) {
  // /proc may belong to another PID namespace, such as that of the container's host.
  if (link_target("/proc/self") != std::to_string(::getpid())) return unknown_start;
  const std::string text = kernel_text(fmt::format("/proc/{}/stat", process));
  const auto name_end = text.rfind(')');
  if (name_end == std::string::npos) return unknown_start;
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  fields >> field;
  // A process that has ended remains a zombie until its parent collects its status.
  if (field == "Z" || field == "X") return ended;
  constexpr int starttime = 22 - 2;  // index among the fields after the name
  for (int i = 1; i < starttime; ++i) fields >> field;
  return field.empty() ? unknown_start : field;
}

/// True if a process of this host and namespace is running.
bool is_at_work(const LockOwner& owner) {
  if (::kill(static_cast<pid_t>(owner.process), 0) != 0 && errno == ESRCH) return false;
  const std::string start = start_of(owner.process);
  if (start == ended) return false;
  return start == unknown_start || owner.start == unknown_start || start == owner.start;
}

/// A word from the environment; `absent` if unset.
std::string environment_word(const char* name, const char* absent) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0 ? value : absent;
}

/// RAII owner of a file descriptor.
class OpenFile {
public:
  explicit OpenFile(int id) : id_(id) {}
  ~OpenFile() { close(); }
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int id() const { return id_; }
  bool is_open() const { return id_ >= 0; }
  bool close() { return id_ < 0 || ::close(std::exchange(id_, -1)) == 0; }

private:
  int id_;
};

/// @throws std::runtime_error when the name is taken by something other than a lock
void require_lock(const fs::path& file) {
  std::error_code ignored;
  const bool is_link = fs::is_symlink(fs::symlink_status(file, ignored));
  const std::string kind = is_link ? "a symbolic link" : other_kind(file);
  if (!kind.empty()) fail("{} is {}, not a lock; remove it if no run is active here", file.string(), kind);
}

/// The text of a lock; empty if there is none.
std::string lock_text(int folder, const std::string& name) {
  const OpenFile file(::openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  struct stat status {};
  if (!file.is_open() || ::fstat(file.id(), &status) != 0 || !S_ISREG(status.st_mode)) return {};
  std::array<char, 4096> text{};
  const ssize_t length = ::read(file.id(), text.data(), text.size());
  return {text.data(), length > 0 ? static_cast<std::size_t>(length) : 0};
}

/// Current time on the file system's own clock, from a probe file that is removed at once.
std::time_t time_of_folder(int folder, const std::string& probe) {
  struct stat status {};
  OpenFile file(::openat(folder, probe.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666));
  const bool is_known = file.is_open() && ::write(file.id(), "\n", 1) >= 0 && ::fsync(file.id()) == 0 &&
                        ::fstat(file.id(), &status) == 0;
  file.close();
  ::unlinkat(folder, probe.c_str(), 0);
  return is_known ? status.st_mtime : 0;
}

/// Seconds from the last touch of a lock until `now`; 0 if either is unknown.
double age(int folder, const std::string& name, std::time_t now) {
  struct stat status {};
  if (now == 0 || ::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return 0;
  return std::difftime(now, status.st_mtime);
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

constexpr const char* probe_mark = ".probe-";
constexpr const char* stale_mark = ".stale-";

/// A name beside the lock that is unique to this process, across hosts and namespaces.
std::string beside(const std::string& lock, const char* mark, const LockOwner& self) {
  return fmt::format("{}{}{}-{}-{}-{}", lock, mark, self.host, self.boot, self.pid_namespace, self.process);
}

/// @throws std::runtime_error naming what is taken, by whom, and what to do
[[noreturn]] void refuse(const std::string& taken, const std::string& text, const fs::path& file) {
  const auto owner = LockOwner::parse(text);
  fail("{}: {}; wait until it ends, or remove {} if it is no longer running", taken,
       owner ? owner->describe() : "its lock does not name its owner", file.string());
}

/// Removes a stale lock. It is renamed first and then checked again: if two runs find it, only one succeeds,
/// and a lock created in between is put back.
void remove_stale(int folder, const fs::path& file, const std::string& text, const LockOwner& self) {
  const std::string name = file.filename().string();
  const std::string aside = beside(name, stale_mark, self);
  if (::renameat(folder, name.c_str(), folder, aside.c_str()) != 0) return;
  if (lock_text(folder, aside) != text && ::linkat(folder, aside.c_str(), folder, name.c_str(), 0) != 0 &&
      errno != EEXIST && errno != ENOENT)  // ENOENT: another process removed the renamed file
    fail("{}: {}", file.string(), std::strerror(errno));
  ::unlinkat(folder, aside.c_str(), 0);
}

/// @return descriptor of the folder; files are accessed through it even if the folder is moved
int open_folder(const fs::path& folder) {
  const int id = ::open(folder.empty() ? "." : folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  if (id < 0) fail("{}: {}", folder.string(), std::strerror(errno));
  return id;
}

}  // namespace

LockOwner LockOwner::self() {
  std::array<char, 256> name{};
  if (::gethostname(name.data(), name.size() - 1) != 0) name[0] = '?';
  LockOwner self;
  self.host = name.data();
  std::istringstream(kernel_text("/proc/sys/kernel/random/boot_id")) >> self.boot;
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
  // The last lines may be missing if the disk was full.
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
  // Fields missing from older lock files compare equal.
  const auto is_same = [](const std::string& theirs, const std::string& ours) {
    return theirs.empty() || theirs == ours;
  };
  if (owner && owner->host == self.host && is_same(owner->boot, self.boot) &&
      is_same(owner->pid_namespace, self.pid_namespace)) {
    if (is_at_work(*owner)) return std::nullopt;
    return fmt::format("{} has ended without removing it", owner->describe());
  }
  if (owner && owner->job != "-" && owner->job == self.job && owner->restart < self.restart)
    return fmt::format("{} is an earlier start of this job", owner->describe());
  if (seconds_untouched > LockFile::lifetime)
    return fmt::format("{} has not updated it for {:.0f} min", owner ? owner->describe() : "its owner",
                       seconds_untouched / 60);
  return std::nullopt;
}

void LockMark::require() const {
  const auto refuse = [this](const char* state) {
    fail("the lock {} is {}: it or its folder was moved or removed during the run", file.string(), state);
  };
  const fs::path parent = file.parent_path();
  // Opening the folder for reading makes a network file system refresh it. Other errors do not indicate a
  // move.
  const OpenFile folder(::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder.is_open()) {
    if (errno == ENOENT || errno == ENOTDIR) refuse("gone");
    return;
  }
  struct stat status {};
  const std::string name = file.filename().string();
  if (::fstatat(folder.id(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) {
    if (errno == ENOENT) refuse("gone");
    return;
  }
  if (const std::string found = lock_text(folder.id(), name); !found.empty() && found != text)
    refuse("another run's");
}

LockFile::LockFile(fs::path file, const std::string& taken, double patience)
    : file_(std::move(file)), name_(file_.filename().string()), folder_(open_folder(file_.parent_path())) {
  try {
    create(taken, patience);
    remove_leftovers();
    thread_ = std::jthread([this](const std::stop_token& stop) { keep_touching(stop); });
  } catch (...) {
    release();
    throw;
  }
}

LockFile::~LockFile() {
  thread_ = {};
  release();
}

void LockFile::release() const {
  if (lock_text(folder_, name_) == self_.text()) ::unlinkat(folder_, name_.c_str(), 0);
  ::close(folder_);
}

bool LockFile::try_to_create() const {
  OpenFile file(::openat(folder_, name_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (!file.is_open()) {
    if (errno == EEXIST) return false;
    fail("cannot write '{}': {}", file_.string(), std::strerror(errno));
  }
  const std::string text = self_.text();
  errno = 0;
  const bool is_written = ::write(file.id(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int write_error = errno;
  if (file.close() && is_written) return true;
  const int error = is_written ? errno : write_error;
  ::unlinkat(folder_, name_.c_str(), 0);
  fail("cannot write '{}': {}", file_.string(),
       error != 0 ? std::strerror(error) : "only a part was written");
}

void LockFile::create(const std::string& taken, double patience) {
  const Stopwatch clock;
  while (!try_to_create()) {
    require_lock(file_);
    const std::time_t now = time_of_folder(folder_, beside(name_, probe_mark, self_));
    const std::string text = lock_text(folder_, name_);
    const auto reason_stale = why_stale(LockOwner::parse(text), self_, age(folder_, name_, now));
    if (!reason_stale && clock.seconds() < patience) {
      std::this_thread::sleep_for(clock.seconds() < short_wait ? short_pause : long_pause);
      continue;
    }
    if (!reason_stale) refuse(taken, text, file_);
    remove_stale(folder_, file_, text, self_);
    taken_over_.push_back(fmt::format("the lock {} is taken over: {}", file_.string(), *reason_stale));
  }
}

void LockFile::remove_leftovers() const {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(file_.parent_path(), ignored)) {
    const std::string name = entry.path().filename().string();
    for (const char* const mark : {probe_mark, stale_mark})
      if (name.starts_with(name_ + mark) && is_left_over(name, mark)) ::unlinkat(folder_, name.c_str(), 0);
  }
}

bool LockFile::is_left_over(const std::string& name, const char* mark) const {
  LockOwner other = self_;
  other.process = whole_number<long>(std::string_view(name).substr(name.rfind('-') + 1)).value_or(0);
  const bool is_of_this_host = other.process > 0 && name == beside(name_, mark, other);
  if (is_of_this_host) return ::kill(static_cast<pid_t>(other.process), 0) != 0 && errno == ESRCH;
  struct stat mine {};
  return ::fstatat(folder_, name_.c_str(), &mine, AT_SYMLINK_NOFOLLOW) == 0 &&
         age(folder_, name, mine.st_mtime) > lifetime;
}

void LockFile::clear(const fs::path& other, const std::string& taken) {
  const std::string name = other.filename().string();
  require_lock(other);
  const std::string text = lock_text(folder_, name);
  struct stat mine {};
  const bool is_mine_known = ::fstatat(folder_, name_.c_str(), &mine, AT_SYMLINK_NOFOLLOW) == 0;
  const auto reason =
      why_stale(LockOwner::parse(text), self_, age(folder_, name, is_mine_known ? mine.st_mtime : 0));
  if (!reason) {
    if (is_taken(other)) refuse(taken, text, other);
    return;
  }
  remove_stale(folder_, other, text, self_);
  taken_over_.push_back(fmt::format("the lock {} is taken over: {}", other.string(), *reason));
}

void LockFile::keep_touching(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!ends_.wait_for(lock, stop, touch_interval, [&] { return stop.stop_requested(); }))
    ::utimensat(folder_, name_.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

MadeFolder::MadeFolder(fs::path folder) : folder_(std::move(folder)) {
  std::error_code error;
  // Includes missing parent folders, which are created too.
  for (fs::path missing = folder_; !missing.empty() && !fs::exists(missing, error);
       missing = missing.parent_path())
    made_.push_back(missing);
  fs::create_directories(folder_, error);
  if (error) fail("cannot make the folder '{}': {}", folder_.string(), error.message());
}

MadeFolder::~MadeFolder() {
  for (const fs::path& made : made_)
    if (::rmdir(made.c_str()) != 0) return;  // in use
}

FolderLock::FolderLock(const fs::path& folder, SampleRange range)
    : folder_(folder),
      lock_(folder / fmt::format("lock-{}-{}", range.first, range.last),
            fmt::format("another run is active in {}", folder.string()), patience) {
  std::vector<fs::path> others;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const auto other = range_of(entry.path());
    if (!other || entry.path().filename() == lock_.file().filename()) continue;
    if (other->first <= range.last && range.first <= other->last) others.push_back(entry.path());
  }
  for (const auto& other : others)
    lock_.clear(other, fmt::format("another run is computing some of these samples in {}", folder.string()));
}

std::vector<std::string> owners_at_work(const fs::path& folder) {
  std::vector<std::string> owners;
  std::error_code ignored;
  const LockOwner self = LockOwner::self();
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const std::string name = entry.path().filename().string();
    const bool is_beside =
        name.find(probe_mark) != std::string::npos || name.find(stale_mark) != std::string::npos;
    if (!name.starts_with("lock-") || is_beside || !other_kind(entry.path()).empty()) continue;
    std::optional<LockOwner> owner;
    try {
      owner = LockOwner::parse(read_text_if_any(entry.path()));
    } catch (const std::runtime_error&) {
      // Another user's unreadable lock.
    }
    const auto touched = fs::last_write_time(entry.path(), ignored);
    const std::chrono::duration<double> untouched = fs::file_time_type::clock::now() - touched;
    if (ignored || why_stale(owner, self, untouched.count())) continue;
    owners.push_back(owner ? owner->describe() : name);
  }
  std::ranges::sort(owners);
  return owners;
}

}  // namespace crackle::ensemble
