// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

/// Checkpoint files, out/samples/NNNN.checkpoint: an unfinished sample, readable by the same program on the
/// same architecture only. Deleted once the sample's own file exists.
namespace crackle::io {

/// out/samples/NNNN.checkpoint for folder = out
std::filesystem::path checkpoint_path(const std::filesystem::path& folder, std::uint64_t sample);

/// Writes the file with identity and checksum, atomically. Not collective.
/// @param input its input::sample_identity
/// @throws std::runtime_error naming the file and the reason
void write_checkpoint(const std::filesystem::path& file, const std::string& input, std::uint64_t sample,
                      std::span<const std::byte> checkpoint);

/// @throws std::runtime_error with the reason when the file is not a complete, undamaged checkpoint of this
///   input, sample number and build of the program
std::vector<std::byte> read_checkpoint(const std::filesystem::path& file, const std::string& input,
                                       std::uint64_t sample);

}  // namespace crackle::io
