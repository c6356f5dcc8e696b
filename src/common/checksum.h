// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace crackle {

inline constexpr std::uint64_t empty_checksum = 0xCBF29CE484222325u;

/// FNV-1a in 64 bits. Every step is a bijection of the state, so one changed byte always changes the value.
/// @param value checksum of the preceding bytes, to continue from
inline std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t value = empty_checksum) {
  for (const std::byte byte : bytes) value = (value ^ static_cast<std::uint64_t>(byte)) * 0x00000100000001B3u;
  return value;
}

inline std::uint64_t checksum(std::string_view text) {
  return checksum(std::as_bytes(std::span(text)));
}

/// Size and 64-bit FNV-1a hash of a file's contents, as text: detects accidental, not deliberate differences.
/// Empty if the file cannot be read.
std::optional<std::string> file_digest(const std::filesystem::path& file);

/// The same of a content.
std::string digest_of(std::string_view content);

}  // namespace crackle
