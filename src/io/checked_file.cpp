// SPDX-License-Identifier: GPL-3.0-or-later
#include "checked_file.h"

#include "crackle/common/checksum.h"
#include "crackle/common/regular_file.h"

#include "partial_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace crackle::io {

namespace {

constexpr std::size_t trailer_length = 32;

std::string trailer(std::span<const std::byte> bytes) {
  return fmt::format("\ncrackle FNV-1a {:016x}", checksum(bytes));
}

}  // namespace

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
