// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

namespace crackle::io {

/// A file that gets its name when it is whole: until commit() it is called "<name><tag>.partial", in the
/// same folder, and it is removed when it is not committed. Where the name is a link's, the file that it
/// leads to is written.
class PartialFile {
public:
  /// @param tag goes before ".partial", where several processes may write the same file at once
  explicit PartialFile(std::filesystem::path file, const std::string& tag = {});
  ~PartialFile();
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;

  /// The name that the file has until it is whole.
  const std::filesystem::path& partial_name() const { return partial_; }

  /// Writes the partial file anew. Makes its folder if needed, but not those above: that of an ensemble may
  /// have been moved away.
  /// @throws std::runtime_error naming the file and the reason; also when its name is that of a folder, a
  /// device or the like
  void write(std::span<const std::byte> bytes);

  /// Brings the partial file to the disk and gives it its name. @throws as write
  void commit();

private:
  std::filesystem::path file_;
  std::filesystem::path partial_;
  bool committed_ = false;
};

/// Makes the folders that a file is to be in. @throws std::runtime_error naming the file and the reason
void make_folders_of(const std::filesystem::path& file);

/// A tag that no other process has, on whatever host and in whatever container.
std::string tag_of_this_process();

/// Writes a file in one piece: as a whole, or not at all. @throws as PartialFile
void write_whole_file(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace crackle::io
