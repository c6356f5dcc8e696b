// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/folder_lock.h"

#include "crackle/stopwatch.h"

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
#include <optional>
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

/// Clock ticks since the machine's start at which a process started: tells it from a later one of the same
/// number. "0" where it cannot be found out, "ended" for one that is no more than an entry.
std::string start_of(long process) {
  std::ifstream stream(fmt::format("/proc/{}/stat", process));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  const auto name_end = text.rfind(')');
  if (name_end == std::string::npos) return "0";
  std::istringstream fields(text.substr(name_end + 1));
  std::string field;
  fields >> field;
  // A process that has ended stays as a zombie where nobody asks for its status.
  if (field == "Z" || field == "X") return "ended";
  constexpr int starttime = 22 - 2;  // of the fields behind the name
  for (int i = 1; i < starttime; ++i) fields >> field;
  return field.empty() ? "0" : field;
}

struct Owner {
  std::string host, start, job;  // job: "-" outside SLURM
  long process = 0;

  static Owner self() {
    std::array<char, 256> name{};
    if (::gethostname(name.data(), name.size() - 1) != 0) name[0] = '?';
    const char* job = std::getenv("SLURM_JOB_ID");
    return {name.data(), start_of(::getpid()), job != nullptr && *job != 0 ? job : "-", ::getpid()};
  }
  static std::optional<Owner> parse(const std::string& text) {
    std::istringstream stream(text);
    std::array<std::string, 4> label;
    Owner owner;
    stream >> label[0] >> owner.host >> label[1] >> owner.process >> label[2] >> owner.start >> label[3] >>
        owner.job;
    if (!stream || label[0] != "host" || owner.process <= 0) return std::nullopt;
    return owner;
  }
  std::string text() const {
    return fmt::format("host {}\nprocess {}\nstart {}\njob {}\n", host, process, start, job);
  }
  std::string describe() const {
    return fmt::format("process {} on {}{}", process, host, job == "-" ? "" : ", SLURM job " + job);
  }
};

std::string read_text(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Seconds since the lock was touched, by the file system's own clock: `mine` was just touched.
double age(const fs::path& file, const fs::path& mine) {
  struct stat theirs {};
  struct stat ours {};
  if (::stat(file.c_str(), &theirs) != 0 || ::stat(mine.c_str(), &ours) != 0) return 0;
  return std::difftime(ours.st_mtime, theirs.st_mtime);
}

/// Why nobody can hold this lock any more; nothing when its owner may be alive.
std::optional<std::string> staleness(const std::string& text, double seconds_untouched) {
  const Owner self = Owner::self();
  const auto owner = Owner::parse(text);
  if (owner && owner->host == self.host) {
    const bool is_gone = ::kill(static_cast<pid_t>(owner->process), 0) != 0 && errno == ESRCH;
    if (is_gone || start_of(owner->process) != owner->start)
      return fmt::format("{} has ended without removing it", owner->describe());
    return std::nullopt;
  }
  if (owner && owner->job != "-" && owner->job == self.job)
    return fmt::format("{} was an earlier start of this job", owner->describe());
  if (seconds_untouched > LockFile::lifetime)
    return fmt::format("{} has not touched it for {:.0f} min", owner ? owner->describe() : "its owner",
                       seconds_untouched / 60);
  return std::nullopt;
}

std::optional<SampleRange> range_of(const fs::path& file) {
  SampleRange range;
  int end = 0;
  const std::string name = file.filename().string();
  if (std::sscanf(name.c_str(), "lock-%lu-%lu%n", &range.first, &range.last, &end) != 2) return std::nullopt;
  if (static_cast<std::size_t>(end) != name.size()) return std::nullopt;
  return range;
}

/// @throws std::runtime_error: what is taken, by whom, and what to do
[[noreturn]] void refuse(const std::string& taken, const std::string& text, const fs::path& file) {
  const auto owner = Owner::parse(text);
  throw std::runtime_error(fmt::format("{}: {}; wait for its end, or remove {} if it is not running any more",
                                       taken, owner ? owner->describe() : "its lock says not whose",
                                       file.string()));
}

/// Takes a stale lock away. It is renamed first and looked at again, so that of two runs that find it only
/// one succeeds and a lock that was made meanwhile is put back.
void remove_stale(const fs::path& file, const std::string& text) {
  const fs::path aside = fmt::format("{}.stale-{}", file.string(), ::getpid());
  if (::rename(file.c_str(), aside.c_str()) != 0) return;
  if (read_text(aside) != text) {
    if (::link(aside.c_str(), file.c_str()) != 0 && errno != EEXIST)
      throw std::runtime_error(file.string() + ": " + std::strerror(errno));
  }
  ::unlink(aside.c_str());
}

}  // namespace

LockFile::LockFile(fs::path file, const std::string& taken, double patience) : file_(std::move(file)) {
  const fs::path folder = file_.parent_path();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw std::runtime_error(
        fmt::format("{}: the folder cannot be made: {}", folder.string(), error.message()));
  create(taken, patience);
  thread_ = std::jthread([this](const std::stop_token& stop) { keep_touching(stop); });
}

LockFile::~LockFile() {
  ::unlink(file_.c_str());
}

void LockFile::create(const std::string& taken, double patience) {
  const Stopwatch clock;
  for (;;) {
    const int id = ::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    const int reason = errno;
    if (id >= 0) {
      const std::string text = Owner::self().text();
      const bool is_written = ::write(id, text.data(), text.size()) == static_cast<ssize_t>(text.size());
      const int write_error = errno;
      if (::close(id) == 0 && is_written) return;
      ::unlink(file_.c_str());
      throw std::runtime_error(
          fmt::format("cannot write '{}': {}", file_.string(), std::strerror(write_error)));
    }
    if (reason != EEXIST)
      throw std::runtime_error(fmt::format("cannot write '{}': {}", file_.string(), std::strerror(reason)));
    const fs::path probe = fmt::format("{}.probe-{}", file_.string(), ::getpid());
    std::ofstream(probe) << "\n";
    const std::string text = read_text(file_);
    const auto reason_stale = staleness(text, age(file_, probe));
    ::unlink(probe.c_str());
    if (!reason_stale && clock.seconds() < patience) {
      std::this_thread::sleep_for(clock.seconds() < short_wait ? short_pause : long_pause);
      continue;
    }
    if (!reason_stale) refuse(taken, text, file_);
    remove_stale(file_, text);
    taken_over_.push_back(fmt::format("the lock {} is taken over: {}", file_.string(), *reason_stale));
  }
}

void LockFile::clear(const fs::path& other, const std::string& taken) {
  const std::string text = read_text(other);
  const auto reason = staleness(text, age(other, file_));
  if (!reason) {
    if (fs::exists(other)) refuse(taken, text, other);
    return;
  }
  remove_stale(other, text);
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
