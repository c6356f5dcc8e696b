// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace crackle::io {

/// A file that gets its final name only when complete: until commit() it is called "<name><tag>.partial", in
/// the same folder, and is removed if not committed. If the name is a link, its target is written.
class PartialFile {
public:
  /// @param tag precedes ".partial", for files that several processes may write at once
  explicit PartialFile(std::filesystem::path file, const std::string& tag = {});
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// The temporary name.
  const std::filesystem::path& partial_name() const { return partial_; }

  /// Rewrites the partial file. Creates its folder if needed, but not the parent folders: an ensemble's
  /// folder may have been moved away.
  /// @throws std::runtime_error naming the file and the reason; also when its name is taken by a folder, a
  ///   device or the like
  void write(std::span<const std::byte> bytes);

  /// Flushes the partial file to disk and renames it. @throws as write
  void commit();

private:
  std::filesystem::path file_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

/// Creates the folders for a file. @throws std::runtime_error naming the file and the reason
void make_folders_of(const std::filesystem::path& file);

/// A tag unique to this process across hosts and containers.
std::string tag_of_this_process();

/// Writes a file atomically. @throws as PartialFile
void write_whole_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

/// Writes the file with its checksum, atomically.
/// @throws std::runtime_error naming the file and the reason
void write_checked_file(const std::filesystem::path& file, std::vector<std::byte> bytes);

/// The bytes without the checksum.
/// @throws std::runtime_error with the reason when the file cannot be read, is truncated, modified or damaged
std::vector<std::byte> read_checked_file(const std::filesystem::path& file);

}  // namespace crackle::io
