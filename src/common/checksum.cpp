// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/checksum.h"

#include <fmt/format.h>

#include <fstream>
#include <vector>

namespace crackle {

namespace {

std::string digest(std::uint64_t n_bytes, std::uint64_t hash) {
  return fmt::format("{} bytes, FNV-1a {:016x}", n_bytes, hash);
}

}  // namespace

std::optional<std::string> file_digest(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return std::nullopt;
  std::vector<char> buffer(std::size_t{1} << 16);
  std::uint64_t hash = empty_checksum;
  std::uint64_t n_bytes = 0;
  while (stream) {
    stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto n_read = static_cast<std::size_t>(stream.gcount());
    hash = checksum(std::as_bytes(std::span(buffer).first(n_read)), hash);
    n_bytes += n_read;
  }
  if (stream.bad()) return std::nullopt;
  return digest(n_bytes, hash);
}

std::string digest_of(std::string_view content) {
  return digest(content.size(), checksum(content));
}

}  // namespace crackle
