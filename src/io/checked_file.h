// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

/// Files that end with a checksum of their bytes. Readers of the underlying format ignore the 32 bytes beyond
/// its end.
namespace crackle::io {

/// Writes the file with its checksum, atomically.
/// @throws std::runtime_error naming the file and the reason
void write_checked_file(const std::filesystem::path& file, std::vector<std::byte> bytes);

/// The bytes without the checksum.
/// @throws std::runtime_error with the reason when the file cannot be read, is truncated, modified or damaged
std::vector<std::byte> read_checked_file(const std::filesystem::path& file);

}  // namespace crackle::io
