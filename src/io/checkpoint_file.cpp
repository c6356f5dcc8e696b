// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/checkpoint_file.h"

#include "common/packing.h"
#include "input/reader.h"
#include "version.h"

#include "partial_file.h"

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::io {

namespace {

constexpr std::uint32_t schema = 11;

/// Items that must agree, each with its error message.
std::vector<std::pair<std::string, std::string>> identity(const std::string& input, std::uint64_t sample) {
  return {{fmt::format("crackle checkpoint {}", schema), "is not a checkpoint of this format"},
          {git_commit() + " " + program_version(), "was made by another build of the program"},
          {input, "was made from another input"},
          {fmt::format("sample {}", sample), "is of another sample"}};
}

}  // namespace

std::filesystem::path checkpoint_path(const std::filesystem::path& folder, std::uint64_t sample) {
  return folder / "samples" / fmt::format("{:04}.checkpoint", sample);
}

void write_checkpoint(const std::filesystem::path& file, const std::string& input, std::uint64_t sample,
                      std::span<const std::byte> checkpoint) {
  Packer packer;
  for (const auto& [text, complaint] : identity(input, sample)) packer.put(text);
  std::vector<std::byte> bytes = packer.bytes();
  bytes.insert(bytes.end(), checkpoint.begin(), checkpoint.end());
  write_checked_file(file, std::move(bytes));
}

std::vector<std::byte> read_checkpoint(const std::filesystem::path& file, const std::string& input,
                                       std::uint64_t sample) {
  std::vector<std::byte> bytes = read_checked_file(file);
  Unpacker unpacker(bytes);
  std::size_t length = 0;
  for (const auto& [text, complaint] : identity(input, sample)) {
    if (unpacker.get<std::string>() != text) throw std::runtime_error(complaint);
    length += sizeof(std::uint64_t) + text.size();
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length));
  return bytes;
}

}  // namespace crackle::io
