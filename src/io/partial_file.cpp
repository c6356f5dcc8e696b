// SPDX-License-Identifier: GPL-3.0-or-later
#include "partial_file.h"

#include "common/checksum.h"
#include "common/regular_file.h"
#include "io/text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

namespace crackle::io {

namespace {

[[noreturn]] void throw_failure(const std::filesystem::path& file, int error) {
  throw std::runtime_error("cannot write '" + file.string() + "': " + std::strerror(error));
}

/// The file to be replaced: for a link, its target, so that the link stays.
std::filesystem::path target(std::filesystem::path file) {
  std::error_code error;
  if (!std::filesystem::is_symlink(std::filesystem::symlink_status(file, error))) return file;
  auto led_to = std::filesystem::canonical(file, error);
  return error ? file : led_to;
}

/// RAII owner of a file descriptor.
class Descriptor {
public:
  Descriptor(const std::filesystem::path& path, int flags)
      : id_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {}
  ~Descriptor() {
    if (id_ >= 0) ::close(id_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return id_; }
  int close() { return ::close(std::exchange(id_, -1)); }

private:
  int id_;
};

constexpr std::size_t trailer_length = 32;

std::string trailer(std::span<const std::byte> bytes) {
  return fmt::format("\ncrackle FNV-1a {:016x}", checksum(bytes));
}

}  // namespace

PartialFile::PartialFile(std::filesystem::path file, const std::string& tag)
    : file_(target(std::move(file))), partial_(std::filesystem::path(file_) += tag + ".partial") {}

PartialFile::~PartialFile() {
  if (!committed_) ::unlink(partial_.c_str());
}

void PartialFile::write(std::span<const std::byte> bytes) {
  // Renaming would replace whatever is there.
  if (const std::string kind = other_kind(file_); !kind.empty())
    throw std::runtime_error("cannot write '" + file_.string() + "': it is " + kind);
  const std::filesystem::path folder = file_.parent_path();
  std::error_code error;
  if (!folder.empty() && !std::filesystem::is_directory(folder, error))
    std::filesystem::create_directory(folder, error);  // also clears the error
  if (error) throw_failure(file_, error == std::errc::file_exists ? ENOTDIR : error.value());
  Descriptor descriptor(partial_, O_WRONLY | O_CREAT | O_TRUNC);
  if (descriptor.get() < 0) throw_failure(file_, errno);
  while (!bytes.empty()) {
    // Linux writes at most 2 GiB at a time.
    const std::size_t part = std::min<std::size_t>(bytes.size(), std::size_t{1} << 30);
    const ssize_t written = ::write(descriptor.get(), bytes.data(), part);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw_failure(file_, errno);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  if (descriptor.close() != 0) throw_failure(file_, errno);
}

void PartialFile::commit() {
  Descriptor descriptor(partial_, O_RDONLY);
  if (descriptor.get() < 0 || ::fsync(descriptor.get()) != 0) throw_failure(file_, errno);
  if (::rename(partial_.c_str(), file_.c_str()) != 0) throw_failure(file_, errno);
  committed_ = true;
  const std::filesystem::path folder = file_.has_parent_path() ? file_.parent_path() : ".";
  Descriptor folder_descriptor(folder, O_RDONLY | O_DIRECTORY);
  // Some file systems cannot sync a folder (EINVAL); the file itself is already on disk.
  if (folder_descriptor.get() < 0 || (::fsync(folder_descriptor.get()) != 0 && errno != EINVAL)) {
    throw_failure(file_, errno);
  }
}

std::string tag_of_this_process() {
  std::array<char, 256> host{}, space{};
  ::gethostname(host.data(), host.size() - 1);
  // "pid:[4026531836]": containers on one host may have equal process numbers.
  const auto length = ::readlink("/proc/self/ns/pid", space.data(), space.size() - 1);
  std::string digits(space.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  std::erase_if(digits, [](char c) { return c < '0' || c > '9'; });
  return fmt::format(".{}-{}-{}", host.data(), digits, ::getpid());
}

void make_folders_of(const std::filesystem::path& file) {
  std::error_code error;
  if (file.has_parent_path()) std::filesystem::create_directories(file.parent_path(), error);
  if (error) throw_failure(file, error.value());
}

void write_whole_file(const std::filesystem::path& file, std::span<const std::byte> bytes) {
  PartialFile partial(file);
  partial.write(bytes);
  partial.commit();
}

void write_text_file(const std::filesystem::path& file, const std::string& text) {
  make_folders_of(file);
  // Runs of other ranges of samples may write the same file.
  PartialFile partial(file, tag_of_this_process());
  partial.write(std::as_bytes(std::span(text)));
  partial.commit();
}

void write_checked_file(const std::filesystem::path& file, std::vector<std::byte> bytes) {
  const std::string end = trailer(bytes);
  const auto end_bytes = std::as_bytes(std::span(end));
  bytes.insert(bytes.end(), end_bytes.begin(), end_bytes.end());
  write_whole_file(file, bytes);
}

std::vector<std::byte> read_checked_file(const std::filesystem::path& file) {
  if (const std::string kind = other_kind(file); !kind.empty()) throw std::runtime_error("is " + kind);
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  if (!stream) throw std::runtime_error(std::strerror(errno));
  const std::streamoff size = stream.tellg();
  if (size < 0) throw std::runtime_error("cannot be read");
  std::vector<std::byte> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) throw std::runtime_error("cannot be read");

  constexpr std::string_view mark = "\ncrackle FNV-1a ";
  const auto cut = bytes.size() < trailer_length ? bytes.size() : bytes.size() - trailer_length;
  const std::string_view end(reinterpret_cast<const char*>(bytes.data()) + cut, bytes.size() - cut);
  if (!end.starts_with(mark))
    throw std::runtime_error("damaged or truncated file: it has no checksum at its end");
  if (end != trailer(std::span(bytes).first(cut)))
    throw std::runtime_error("damaged file: its content does not match its checksum");
  bytes.resize(cut);
  return bytes;
}

}  // namespace crackle::io
