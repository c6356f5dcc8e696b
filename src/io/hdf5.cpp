// SPDX-License-Identifier: GPL-3.0-or-later
#include "hdf5.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <numeric>

namespace crackle::io::hdf5 {

namespace {

constexpr unsigned deflate_level = 4;
constexpr hsize_t chunk_bytes = 1 << 20;

/// HDF5's innermost reason and what it was about, from the current error stack.
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

template <class Value>
struct Types;
template <>
struct Types<std::uint8_t> {
  static hid_t memory() { return H5T_NATIVE_UINT8; }
  static hid_t stored() { return H5T_STD_U8LE; }
};
template <>
struct Types<std::int32_t> {
  static hid_t memory() { return H5T_NATIVE_INT32; }
  static hid_t stored() { return H5T_STD_I32LE; }
};
template <>
struct Types<std::int64_t> {
  static hid_t memory() { return H5T_NATIVE_INT64; }
  static hid_t stored() { return H5T_STD_I64LE; }
};
template <>
struct Types<std::uint64_t> {
  static hid_t memory() { return H5T_NATIVE_UINT64; }
  static hid_t stored() { return H5T_STD_U64LE; }
};
template <>
struct Types<float> {
  static hid_t memory() { return H5T_NATIVE_FLOAT; }
  static hid_t stored() { return H5T_IEEE_F32LE; }
};
template <>
struct Types<double> {
  static hid_t memory() { return H5T_NATIVE_DOUBLE; }
  static hid_t stored() { return H5T_IEEE_F64LE; }
};

Handle scalar_space() {
  return Handle(H5Screate(H5S_SCALAR), H5Sclose, "HDF5 dataspace");
}

Handle make_space(const Shape& shape) {
  if (shape.empty()) return scalar_space();
  return Handle(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose,
                "HDF5 dataspace");
}

Handle text_type() {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 text type");
  check(H5Tset_size(type.get(), H5T_VARIABLE), "HDF5 text type");
  check(H5Tset_cset(type.get(), H5T_CSET_UTF8), "HDF5 text type");
  return type;
}

hsize_t count(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), hsize_t{1}, std::multiplies<>());
}

Handle creation_list(const Shape& shape, std::size_t value_size, Storage storage) {
  Handle list = property_list(H5P_DATASET_CREATE);
  check(H5Pset_obj_track_times(list.get(), false), "HDF5 object times");
  if (storage == Storage::compressed && count(shape) > 0 && !shape.empty()) {
    Shape chunk = shape;
    const hsize_t row_bytes = count(shape) / shape[0] * value_size;
    chunk[0] = std::clamp<hsize_t>(chunk_bytes / row_bytes, 1, shape[0]);
    check(H5Pset_chunk(list.get(), static_cast<int>(chunk.size()), chunk.data()), "HDF5 chunks");
    check(H5Pset_shuffle(list.get()), "HDF5 shuffle filter");
    check(H5Pset_deflate(list.get(), deflate_level), "HDF5 deflate filter");
  } else {
    check(H5Pset_alloc_time(list.get(), H5D_ALLOC_TIME_EARLY), "HDF5 allocation time");
  }
  return list;
}

template <class Value>
void write_scalar_attribute(hid_t object, const std::string& name, Value value) {
  const Handle space = scalar_space();
  const Handle attribute(
      H5Acreate2(object, name.c_str(), Types<Value>::stored(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose, "attribute " + name);
  check(H5Awrite(attribute.get(), Types<Value>::memory(), &value), "attribute " + name);
}

template <class Value>
Value read_scalar_attribute(hid_t object, const std::string& name) {
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "attribute " + name);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose, "attribute " + name);
  if (H5Sget_simple_extent_npoints(space.get()) != 1) throw Error("attribute " + name + " is not one value");
  Value value{};
  check(H5Aread(attribute.get(), Types<Value>::memory(), &value), "attribute " + name);
  return value;
}

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
  check(H5Pset_file_locking(list.get(), false, true), "HDF5 file locking");
  return list;
}

Handle open_for_reading(const std::filesystem::path& file) {
  const Handle access = unlocked_access();
  return Handle(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access.get()), H5Fclose, "no whole HDF5 file");
}

Handle create_group(hid_t parent, const std::string& name) {
  const Handle creation = property_list(H5P_GROUP_CREATE);
  check(H5Pset_obj_track_times(creation.get(), false), "HDF5 object times");
  return Handle(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, creation.get(), H5P_DEFAULT), H5Gclose,
                "group " + name);
}

Handle open_group(hid_t parent, const std::string& name) {
  return Handle(H5Gopen2(parent, name.c_str(), H5P_DEFAULT), H5Gclose, "group " + name);
}

void write_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type = text_type();
  const Handle space = scalar_space();
  const Handle attribute(H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, "attribute " + name);
  const char* data = text.c_str();
  check(H5Awrite(attribute.get(), type.get(), &data), "attribute " + name);
}

void write_attribute(hid_t object, const std::string& name, std::int64_t value) {
  write_scalar_attribute(object, name, value);
}
void write_attribute(hid_t object, const std::string& name, std::uint64_t value) {
  write_scalar_attribute(object, name, value);
}
void write_attribute(hid_t object, const std::string& name, double value) {
  write_scalar_attribute(object, name, value);
}

void write_attribute(hid_t object, const std::string& name, const std::array<std::int64_t, 2>& values) {
  const Handle space = make_space({values.size()});
  const Handle attribute(
      H5Acreate2(object, name.c_str(), H5T_STD_I64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      "attribute " + name);
  check(H5Awrite(attribute.get(), H5T_NATIVE_INT64, values.data()), "attribute " + name);
}

void write_fixed_text_attribute(hid_t object, const std::string& name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "HDF5 text type");
  check(H5Tset_size(type.get(), text.size()), "HDF5 text type");
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "HDF5 text type");
  const Handle space = scalar_space();
  const Handle attribute(H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, "attribute " + name);
  check(H5Awrite(attribute.get(), type.get(), text.data()), "attribute " + name);
}

std::string read_text_attribute(hid_t object, const std::string& name) {
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose, "attribute " + name);
  const Handle space(H5Aget_space(attribute.get()), H5Sclose, "attribute " + name);
  if (H5Sget_simple_extent_npoints(space.get()) != 1) throw Error("attribute " + name + " is not one text");
  const Handle type = text_type();
  char* data = nullptr;
  check(H5Aread(attribute.get(), type.get(), &data), "attribute " + name);
  std::string text = data ? data : "";
  check(H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, &data), "attribute " + name);
  return text;
}

std::int64_t read_integer_attribute(hid_t object, const std::string& name) {
  return read_scalar_attribute<std::int64_t>(object, name);
}
template <class Value>
hid_t memory_type() {
  return Types<Value>::memory();
}

template <class Value>
void write_dataset(hid_t parent, const std::string& name, const Shape& shape, std::span<const Value> values,
                   const std::string& units, Storage storage) {
  if (values.size() != count(shape)) {
    throw std::invalid_argument(
        fmt::format("dataset {}: {} values for shape ({})", name, values.size(), fmt::join(shape, ", ")));
  }
  const Handle space = make_space(shape);
  const Handle creation = creation_list(shape, sizeof(Value), storage);
  const Handle dataset(H5Dcreate2(parent, name.c_str(), Types<Value>::stored(), space.get(), H5P_DEFAULT,
                                  creation.get(), H5P_DEFAULT),
                       H5Dclose, "dataset " + name);
  if (!values.empty()) {
    check(H5Dwrite(dataset.get(), Types<Value>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "dataset " + name);
  }
  if (!units.empty()) write_attribute(dataset.get(), "units", units);
}

void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts) {
  const Handle type = text_type();
  const Handle space = make_space({texts.size()});
  const Handle creation = creation_list({texts.size()}, sizeof(char*), Storage::plain);
  const Handle dataset(
      H5Dcreate2(parent, name.c_str(), type.get(), space.get(), H5P_DEFAULT, creation.get(), H5P_DEFAULT),
      H5Dclose, "dataset " + name);
  std::vector<const char*> data;
  for (const std::string& text : texts) data.push_back(text.c_str());
  if (data.empty()) return;
  check(H5Dwrite(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), "dataset " + name);
}

namespace {

Handle open_dataset(hid_t parent, const std::string& name) {
  return Handle(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose, "dataset " + name);
}

Shape shape_of(const Handle& dataset, const std::string& name) {
  const Handle space(H5Dget_space(dataset.get()), H5Sclose, "dataset " + name);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  check(rank, "dataset " + name);
  Shape shape(static_cast<std::size_t>(rank));
  check(H5Sget_simple_extent_dims(space.get(), shape.data(), nullptr), "dataset " + name);
  return shape;
}

}  // namespace

std::vector<std::string> read_texts(hid_t parent, const std::string& name) {
  const Handle dataset = open_dataset(parent, name);
  const Handle type = text_type();
  const Handle space(H5Dget_space(dataset.get()), H5Sclose, "dataset " + name);
  std::vector<char*> data(count(shape_of(dataset, name)), nullptr);
  if (data.empty()) return {};
  check(H5Dread(dataset.get(), type.get(), H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data()), "dataset " + name);
  std::vector<std::string> texts;
  for (const char* text : data) texts.emplace_back(text ? text : "");
  check(H5Dvlen_reclaim(type.get(), space.get(), H5P_DEFAULT, data.data()), "dataset " + name);
  return texts;
}

Shape read_shape(hid_t parent, const std::string& name) {
  return shape_of(open_dataset(parent, name), name);
}

template <class Value>
std::vector<Value> read_dataset(hid_t parent, const std::string& name, const Shape& shape) {
  const Handle dataset = open_dataset(parent, name);
  const Shape found = shape_of(dataset, name);
  if (found != shape) {
    throw Error(fmt::format("dataset {}: shape ({}) instead of ({})", name, fmt::join(found, ", "),
                            fmt::join(shape, ", ")));
  }
  std::vector<Value> values(count(shape));
  if (!values.empty()) {
    check(H5Dread(dataset.get(), Types<Value>::memory(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()),
          "dataset " + name);
  }
  return values;
}

#define CRACKLE_INSTANTIATE(Value)                                                                    \
  template void write_dataset<Value>(hid_t, const std::string&, const Shape&, std::span<const Value>, \
                                     const std::string&, Storage);                                    \
  template std::vector<Value> read_dataset<Value>(hid_t, const std::string&, const Shape&);           \
  template hid_t memory_type<Value>();
CRACKLE_INSTANTIATE(std::uint8_t)
CRACKLE_INSTANTIATE(std::int32_t)
CRACKLE_INSTANTIATE(std::int64_t)
CRACKLE_INSTANTIATE(float)
CRACKLE_INSTANTIATE(double)
#undef CRACKLE_INSTANTIATE

}  // namespace crackle::io::hdf5
