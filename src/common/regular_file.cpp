// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/regular_file.h"

#include "common/failure.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <system_error>

namespace crackle {

namespace fs = std::filesystem;

std::string other_kind(const fs::path& file) {
  std::error_code error;
  const fs::file_type link = fs::symlink_status(file, error).type();
  if (link == fs::file_type::not_found || link == fs::file_type::none) return {};
  switch (fs::status(file, error).type()) {
    case fs::file_type::directory:
      return "a folder";
    case fs::file_type::fifo:
      return "a named pipe";
    case fs::file_type::socket:
      return "a socket";
    case fs::file_type::block:
    case fs::file_type::character:
      return "a device";
    case fs::file_type::not_found:
    case fs::file_type::none:  // a loop of links
      return link == fs::file_type::symlink ? "a broken link" : std::string();
    case fs::file_type::regular:
    case fs::file_type::symlink:
    case fs::file_type::unknown:
      break;
  }
  return {};
}

bool is_taken(const fs::path& file) {
  std::error_code error;
  return fs::exists(fs::symlink_status(file, error));
}

void require_regular(const fs::path& file) {
  if (const std::string kind = other_kind(file); !kind.empty())
    fail("{} is {}, not a file", file.string(), kind);
}

std::string cannot_write(const fs::path& file, const std::string& reason) {
  const std::string prefix = "cannot write '" + file.string() + "'";
  return reason.starts_with(prefix) ? reason : prefix + ": " + reason;
}

std::string read_text_if_any(const fs::path& file) {
  require_regular(file);
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  if (!stream) {
    if (errno == ENOENT || errno == ENOTDIR) return {};
    fail("cannot read '{}': {}", file.string(), std::strerror(errno));
  }
  std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (stream.bad()) fail("cannot read '{}' to the end", file.string());
  return text;
}

}  // namespace crackle
