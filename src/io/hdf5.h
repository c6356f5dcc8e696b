// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <hdf5.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

/// RAII owners and checked calls for HDF5. Every failure throws an Error with text from HDF5's error stack.
namespace crackle::io::hdf5 {

class Error : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Disables HDF5's automatic error printing during its lifetime.
class QuietErrors {
public:
  QuietErrors();
  ~QuietErrors();
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// @throws Error "what: HDF5's reason" for a negative status
void check(herr_t status, const std::string& what);

/// Move-only owner of an HDF5 identifier.
class Handle {
public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  /// @throws Error "what: HDF5's reason" for a negative identifier
  Handle(hid_t id, Close close, const std::string& what);
  ~Handle();
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;

  operator hid_t() const { return id_; }
  /// Closes now. @throws Error on failure, which the destructor cannot report
  void close(const std::string& what);

private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

using Shape = std::vector<hsize_t>;

/// How a dataset is stored.
enum class Storage {
  plain,       ///< contiguous, allocated in the file on creation
  compressed,  ///< in chunks of about a megabyte, with shuffle and deflate filters
};

Handle property_list(hid_t list_class);

/// File access without locks: files are complete before they get their name, and locks fail on some parallel
/// file systems.
Handle unlocked_access();

/// @throws Error naming the file when it is missing, truncated or not HDF5
Handle open_for_reading(const std::filesystem::path& file);

Handle create_group(hid_t parent, const std::string& name);
Handle open_group(hid_t parent, const std::string& name);
Handle open_dataset(hid_t parent, const std::string& name);

void write_attribute(hid_t object, const std::string& name, const std::string& text);
/// Value is one of the types of write_dataset. An empty shape is a scalar.
template <class Value>
void write_attribute(hid_t object, const std::string& name, std::span<const Value> values,
                     const Shape& shape);
template <class Value>
requires std::is_arithmetic_v<Value>
void write_attribute(hid_t object, const std::string& name, Value value) {
  write_attribute<Value>(object, name, std::span(&value, 1), {});
}
/// As fixed-length text without terminator, required by some readers.
void write_fixed_text_attribute(hid_t object, const std::string& name, const std::string& text);
std::string read_text_attribute(hid_t object, const std::string& name);
std::int64_t read_integer_attribute(hid_t object, const std::string& name);

/// Creates and fills a dataset; an empty shape is a scalar. `units` is stored as an attribute, "" for none.
/// Value is one of std::uint8_t, std::int32_t, std::int64_t, std::uint64_t, float, double.
/// @throws std::invalid_argument when the size of `values` does not match `shape`
template <class Value>
void write_dataset(hid_t parent, const std::string& name, const Shape& shape, std::span<const Value> values,
                   const std::string& units, Storage storage = Storage::plain);

/// Variable-length texts.
void write_texts(hid_t parent, const std::string& name, const std::vector<std::string>& texts);
std::vector<std::string> read_texts(hid_t parent, const std::string& name);

/// Names the dimensions of a dataset, as HDF5's dimension labels; a dataset may have fewer.
void label_dimensions(hid_t dataset, std::span<const std::string> names);

/// Names the dimensions of every dataset of a group, excluding subgroups.
/// @param scale dataset of the group that holds the coordinates of the first dimension, as HDF5 dimension
///   scale; "" for none
void label_datasets(hid_t group, const std::vector<std::string>& names, const std::string& scale = "");

/// Makes `scale` a dimension scale of a dataset.
void attach_scale(hid_t dataset, hid_t scale, unsigned dimension);

Shape read_shape(hid_t parent, const std::string& name);

/// @throws Error when the dataset is missing or its shape is not `shape`
template <class Value>
std::vector<Value> read_dataset(hid_t parent, const std::string& name, const Shape& shape);

/// A scalar, as a dataset without dimensions.
template <class Value>
void write_scalar(hid_t parent, const std::string& name, Value value, const std::string& units) {
  write_dataset<Value>(parent, name, {}, std::span<const Value>(&value, 1), units);
}
template <class Value>
Value read_scalar(hid_t parent, const std::string& name) {
  return read_dataset<Value>(parent, name, {}).front();
}

/// Appends the numbers in nested arrays one after the other.
template <class Value, class From>
void flatten(const From& from, std::vector<Value>& to) {
  if constexpr (std::is_arithmetic_v<From>) {
    to.push_back(static_cast<Value>(from));
  } else {
    for (const auto& one : from) flatten(one, to);
  }
}

/// HDF5's in-memory type for Value.
template <class Value>
hid_t memory_type();

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
