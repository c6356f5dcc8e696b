// SPDX-License-Identifier: GPL-3.0-or-later
#include "memory_file.h"

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace crackle::io::hdf5 {

namespace {

constexpr std::size_t increment = 1 << 20;  // by which a file grows [byte]

}  // namespace

// The contents of an in-memory file are taken over when HDF5 frees them, after the file was closed: the image
// of an open file (H5Fget_file_image, HDF5 1.10.8) has a wrong checksum in its superblock.
MemoryFile::MemoryFile() {
  const QuietErrors quiet;
  const Handle creation = property_list(H5P_FILE_CREATE);
  check(H5Pset_obj_track_times(creation, false), "HDF5 object times");
  const Handle access = unlocked_access();
  check(H5Pset_fapl_core(access, increment, false), "file in memory");
  H5FD_file_image_callbacks_t callbacks{};
  callbacks.image_malloc = [](size_t size, H5FD_file_image_op_t, void*) { return std::malloc(size); };
  callbacks.image_memcpy = [](void* to, const void* from, size_t size, H5FD_file_image_op_t, void*) {
    return std::memcpy(to, from, size);
  };
  callbacks.image_realloc = [](void* data, size_t size, H5FD_file_image_op_t, void*) {
    return std::realloc(data, size);
  };
  callbacks.image_free = [](void* data, H5FD_file_image_op_t operation, void* owner) -> herr_t {
    auto& bytes = *static_cast<std::vector<std::byte>*>(owner);
    if (operation == H5FD_FILE_IMAGE_OP_FILE_CLOSE && !bytes.empty()) {
      std::memcpy(bytes.data(), data, bytes.size());
    }
    std::free(data);
    return 0;
  };
  callbacks.udata_copy = [](void* owner) { return owner; };
  callbacks.udata_free = [](void*) -> herr_t { return 0; };
  callbacks.udata = &bytes_;
  check(H5Pset_file_image_callbacks(access, &callbacks), "file in memory");
  // The 1.8 format has metadata checksums, so that damage is detected.
  check(H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18), "HDF5 file format");
  file_ = Handle(H5Fcreate("in memory", H5F_ACC_TRUNC, creation, access), H5Fclose, "file in memory");
}

std::vector<std::byte> MemoryFile::finish() {
  const QuietErrors quiet;
  check(H5Fflush(file_, H5F_SCOPE_GLOBAL), "file in memory");
  const ssize_t size = H5Fget_file_image(file_, nullptr, 0);
  if (size < 48) check(-1, "file in memory");
  bytes_.resize(static_cast<std::size_t>(size));
  file_.close("file in memory");
  // Closing may release unused space at the end: the superblock (version 2) stores the end of file at byte
  // 28.
  constexpr std::size_t end_address = 28;
  std::uint64_t end = 0;
  std::memcpy(&end, bytes_.data() + end_address, sizeof end);
  if (end < end_address || end > bytes_.size()) throw Error("file in memory: no end of file");
  bytes_.resize(end);
  return std::move(bytes_);
}

}  // namespace crackle::io::hdf5
