// SPDX-License-Identifier: GPL-3.0-or-later
#include "hdf5.h"

#include "common/failure.h"
#include "common/regular_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5_hl.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace crackle::io::hdf5 {

namespace {

constexpr unsigned deflate_level = 4;
constexpr hsize_t chunk_bytes = 1 << 20;

/// The innermost reason in HDF5's current error stack, and its object.
std::string stack_text() {
  std::vector<std::string> lines;
  const auto append = [](unsigned, const H5E_error2_t* entry, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(entry->desc ? entry->desc : "");
    return 0;
  };
  if (H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, append, &lines) < 0 || lines.empty()) return "HDF5 failed";
  if (lines.size() == 1) return lines.front();
  return lines.front() + " (" + lines.back() + ")";
}

/// HDF5's types for a number.
struct Types {
  hid_t memory;
  hid_t stored;
};

template <class Value>
Types types() {
  if constexpr (std::is_same_v<Value, std::uint8_t>) return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
  if constexpr (std::is_same_v<Value, std::int32_t>) return {H5T_NATIVE_INT32, H5T_STD_I32LE};
  if constexpr (std::is_same_v<Value, std::int64_t>) return {H5T_NATIVE_INT64, H5T_STD_I64LE};
  if constexpr (std::is_same_v<Value, std::uint64_t>) return {H5T_NATIVE_UINT64, H5T_STD_U64LE};
  if constexpr (std::is_same_v<Value, float>) return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
  if constexpr (std::is_same_v<Value, double>) return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
}

Handle make_space(const Shape& shape) {
  if (shape.empty()) return Handle(H5Screate(H5S_SCALAR), H5Sclose, "HDF5 dataspace");
  return Handle(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose,
                "HDF5 dataspace");
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 text type");
  check(H5Tset_size(type, H5T_VARIABLE), "HDF5 text type");
  check(H5Tset_cset(type, H5T_CSET_UTF8), "HDF5 text type");
  return type;
}

/// @throws Error for more values than any memory has
hsize_t count(const Shape& shape) {
  constexpr hsize_t most = hsize_t{1} << 60;
  hsize_t n = 1;
  for (const hsize_t extent : shape) {
    if (extent > 0 && n > most / extent) fail<Error>("the shape ({}) is too large", fmt::join(shape, ", "));
    n *= extent;
  }
  return n;
}

Handle creation_list(const Shape& shape, std::size_t value_size, Storage storage) {
  Handle list = property_list(H5P_DATASET_CREATE);
  check(H5Pset_obj_track_times(list, false), "HDF5 object times");
  if (storage == Storage::compressed && count(shape) > 0 && !shape.empty()) {
    Shape chunk = shape;
    const hsize_t row_bytes = count(shape) / shape[0] * value_size;
    chunk[0] = std::clamp<hsize_t>(chunk_bytes / row_bytes, 1, shape[0]);
    check(H5Pset_chunk(list, static_cast<int>(chunk.size()), chunk.data()), "HDF5 chunks");
    check(H5Pset_shuffle(list), "HDF5 shuffle filter");
    check(H5Pset_deflate(list, deflate_level), "HDF5 deflate filter");
  } else {
    check(H5Pset_alloc_time(list, H5D_ALLOC_TIME_EARLY), "HDF5 allocation time");
  }
  return list;
}

/// @param type of the values in the file and, unless `memory` is given, in memory
void create_attribute(hid_t object, const std::string& name, hid_t type, const Shape& shape,
                      const void* values, hid_t memory = H5I_INVALID_HID) {
  const Handle space = make_space(shape);
  const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
                         "attribute " + name);
  check(H5Awrite(attribute, memory < 0 ? type : memory, values), "attribute " + name);
}

/// Opens an attribute with a single value. @param kind "value" or "text"
Handle open_attribute(hid_t object, const std::string& name, const char* kind) {
  Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "attribute " + name);
  const Handle space(H5Aget_space(attribute), H5Sclose, "attribute " + name);
  if (H5Sget_simple_extent_npoints(space) != 1) fail<Error>("attribute {} is not one {}", name, kind);
  return attribute;
}

/// Copies texts allocated by HDF5, and frees them.
std::vector<std::string> take_texts(std::vector<char*>& data, hid_t type, hid_t space,
                                    const std::string& what) {
  std::vector<std::string> texts;
  for (const char* text : data) texts.emplace_back(text ? text : "");
  check(H5Dvlen_reclaim(type, space, H5P_DEFAULT, data.data()), what);
  return texts;
}

Shape shape_of(const Handle& dataset, const std::string& name) {
  const Handle space(H5Dget_space(dataset), H5Sclose, "dataset " + name);
  const int rank = H5Sget_simple_extent_ndims(space);
  check(rank, "dataset " + name);
  Shape shape(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space, shape.data(), nullptr), "dataset " + name);
  return shape;
}

/// Names of the objects in a group, in alphabetical order.
std::vector<std::string> names_in(hid_t group) {
  std::vector<std::string> names;
  const auto append = [](hid_t, const char* link, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(link);
    return 0;
  };
  check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, append, &names), "HDF5 group");
  return names;
}

std::size_t n_dimensions(hid_t dataset) {
  const Handle space(H5Dget_space(dataset), H5Sclose, "HDF5 dataspace");
  const int n = H5Sget_simple_extent_ndims(space);
  check(n, "HDF5 dataspace");
  return static_cast<std::size_t>(n);
}

constexpr std::size_t increment = 1 << 20;  // by which a file grows [byte]

}  // namespace

QuietErrors::QuietErrors() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietErrors::~QuietErrors() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

void check(herr_t status, const std::string& what) {
  if (status < 0) throw Error(what + ": " + stack_text());
}

Handle::Handle(hid_t id, Close close, const std::string& what) : id_(id), close_(close) {
  if (id_ < 0) throw Error(what + ": " + stack_text());
}

Handle::~Handle() {
  if (id_ >= 0) close_(id_);
}

void Handle::close(const std::string& what) {
  const hid_t id = std::exchange(id_, -1);
  if (id >= 0) check(close_(id), what);
}

Handle property_list(hid_t list_class) {
  return Handle(H5Pcreate(list_class), H5Pclose, "HDF5 property list");
}

Handle unlocked_access() {
  Handle list = property_list(H5P_FILE_ACCESS);
  check(H5Pset_file_locking(list, false, true), "HDF5 file locking");
  return list;
}

Handle open_for_reading(const std::filesystem::path& file) {
  if (const std::string kind = other_kind(file); !kind.empty()) throw Error("is " + kind);
  const Handle access = unlocked_access();
  return Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access), H5Fclose, "not a complete HDF5 file");
}

Handle create_group(hid_t parent, const std::string& name) {
  const Handle creation = property_list(H5P_GROUP_CREATE);
  check(H5Pset_obj_track_times(creation, false), "HDF5 object times");
  return Handle(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose,
                "group " + name);
}

Handle open_group(hid_t parent, const std::string& name) {
  return Handle(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "group " + name);
}

Handle open_dataset(hid_t parent, const std::string& name) {
  return Handle(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "dataset " + name);
}

void write_attribute(hid_t object, const std::string& name, const std::string& text) {
  const char* data = text.c_str();
  create_attribute(object, name, text_type(), {}, &data);
}

template <class Value>
void write_attribute(hid_t object, const std::string& name, std::span<const Value> values,
                     const Shape& shape) {
  create_attribute(object, name, types<Value>().stored, shape, values.data(), types<Value>().memory);
}

void write_fixed_text_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 text type");
  check(H5Tset_size(type, text.size()), "HDF5 text type");
  check(H5Tset_strpad(type, H5T_STR_NULLPAD), "HDF5 text type");
  create_attribute(object, name, type, {}, text.data());
}

std::string read_text_attribute(hid_t object, const std::string& name) {
  const Handle attribute = open_attribute(object, name, "text");
  const Handle type = text_type();
  std::vector<char*> data(1, nullptr);
  check(H5Aread(attribute, type, data.data()), "attribute " + name);
  return take_texts(data, type, make_space({}), "attribute " + name).front();
}

std::int64_t read_integer_attribute(hid_t object, const std::string& name) {
  std::int64_t value = 0;
  check(H5Aread(open_attribute(object, name, "value"), H5T_NATIVE_INT64, &value), "attribute " + name);
  return value;
}

template <class Value>
hid_t memory_type() {
  return types<Value>().memory;
}

template <class Value>
void write_dataset(hid_t parent, const std::string& name, const Shape& shape, std::span<const Value> values,
                   const std::string& units, Storage storage) {
  if (values.size() != count(shape))
    fail<std::invalid_argument>("dataset {}: {} values for shape ({})", name, values.size(),
                                fmt::join(shape, ", "));
  const Handle space = make_space(shape);
  const Handle creation = creation_list(shape, sizeof(Value), storage);
  const Handle dataset(
      H5Dcreate2(parent, name.c_str(), types<Value>().stored, space, H5P_DEFAULT, creation, H5P_DEFAULT),
      H5Dclose, "dataset " + name);
  if (!values.empty()) {
    check(H5Dwrite(dataset, types<Value>().memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "dataset " + name);
  }
  if (!units.empty()) write_attribute(dataset, "units", units);
}

void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts) {
  const Handle type = text_type();
  const Handle space = make_space({texts.size()});
  const Handle creation = creation_list({texts.size()}, sizeof(char*), Storage::plain);
  const Handle dataset(H5Dcreate2(parent, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                       H5Dclose, "dataset " + name);
  std::vector<const char*> data;
  for (const std::string& text : texts) data.push_back(text.c_str());
  if (data.empty()) return;
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), "dataset " + name);
}

std::vector<std::string> read_texts(hid_t parent, const std::string& name) {
  const Handle dataset = open_dataset(parent, name);
  const Handle type = text_type();
  const Handle space(H5Dget_space(dataset), H5Sclose, "dataset " + name);
  std::vector<char*> data(count(shape_of(dataset, name)), nullptr);
  if (data.empty()) return {};
  check(H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), "dataset " + name);
  return take_texts(data, type, space, "dataset " + name);
}

void label_dimensions(hid_t dataset, std::span<const std::string> names) {
  const std::size_t n = std::min(n_dimensions(dataset), names.size());
  for (std::size_t i = 0; i < n; ++i)
    check(H5DSset_label(dataset, static_cast<unsigned>(i), names[i].c_str()), "HDF5 dimension label");
}

void attach_scale(hid_t dataset, hid_t scale, unsigned dimension) {
  if (H5DSis_scale(scale) == 0) check(H5DSset_scale(scale, nullptr), "HDF5 dimension scale");
  check(H5DSattach_scale(dataset, scale, dimension), "HDF5 dimension scale");
}

void label_datasets(hid_t group, const std::vector<std::string>& names, const std::string& scale) {
  for (const std::string& name : names_in(group)) {
    const Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT), H5Oclose, name);
    if (H5Iget_type(object) != H5I_DATASET || n_dimensions(object) == 0) continue;
    label_dimensions(object, names);
    if (!scale.empty() && name != scale) attach_scale(object, open_dataset(group, scale), 0);
  }
}

Shape read_shape(hid_t parent, const std::string& name) {
  return shape_of(open_dataset(parent, name), name);
}

template <class Value>
std::vector<Value> read_dataset(hid_t parent, const std::string& name, const Shape& shape) {
  const Handle dataset = open_dataset(parent, name);
  const Shape found = shape_of(dataset, name);
  if (found != shape)
    fail<Error>("dataset {}: shape ({}) instead of ({})", name, fmt::join(found, ", "),
                fmt::join(shape, ", "));
  std::vector<Value> values(count(shape));
  if (!values.empty()) {
    check(H5Dread(dataset, types<Value>().memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "dataset " + name);
  }
  return values;
}

#define CRACKLE_INSTANTIATE(Value)                                                                       \
  template void write_dataset<Value>(hid_t, const std::string&, const Shape&, std::span<const Value>,    \
                                     const std::string&, Storage);                                       \
  template std::vector<Value> read_dataset<Value>(hid_t, const std::string&, const Shape&);              \
  template void write_attribute<Value>(hid_t, const std::string&, std::span<const Value>, const Shape&); \
  template hid_t memory_type<Value>();
CRACKLE_INSTANTIATE(std::uint8_t)
CRACKLE_INSTANTIATE(std::int32_t)
CRACKLE_INSTANTIATE(std::int64_t)
CRACKLE_INSTANTIATE(std::uint64_t)
CRACKLE_INSTANTIATE(float)
CRACKLE_INSTANTIATE(double)
#undef CRACKLE_INSTANTIATE

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
