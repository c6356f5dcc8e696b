// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "hdf5.h"

#include <cstddef>
#include <vector>

namespace crackle::io::hdf5 {

/// A file that is built in memory and then written in one piece, so that a disk error can neither leave a
/// partial file nor confuse HDF5. Its bytes depend on its contents only: no times are stored.
class MemoryFile {
public:
  MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;
  operator hid_t() const { return file_; }
  /// Closes the file and returns its bytes.
  std::vector<std::byte> finish();

private:
  std::vector<std::byte> bytes_;  ///< filled when the file is closed
  Handle file_;
};

}  // namespace crackle::io::hdf5
