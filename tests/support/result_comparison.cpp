// SPDX-License-Identifier: GPL-3.0-or-later
#include "result_comparison.h"

#include "io/hdf5.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <stdexcept>
#include <utility>

namespace crackle::io {

namespace {

/// Everything comparable in a file: kind, type, shape and bits of each object and attribute.
using Content = std::map<std::string, std::string>;

/// Reads all values through `read(memory type, buffer)` and returns them as bytes.
template <class Read>
std::string values_as_bytes(const hdf5::Handle& stored_type, const hdf5::Handle& space,
                            const std::string& name, Read read) {
  const hdf5::Handle type(H5Tget_native_type(stored_type, H5T_DIR_ASCEND), H5Tclose, name);
  const hssize_t n = H5Sget_simple_extent_npoints(space);
  hdf5::check(n < 0 ? -1 : 0, name);
  const std::size_t value_size = H5Tget_size(type);
  const int rank = H5Sget_simple_extent_ndims(space);
  hdf5::check(rank, name);
  hdf5::Shape shape(static_cast<std::size_t>(rank));
  hdf5::check(H5Sget_simple_extent_dims(space, shape.data(), nullptr), name);
  std::string text = fmt::format("class {} size {} shape ({}): ", static_cast<int>(H5Tget_class(type)),
                                 value_size, fmt::join(shape, ", "));
  if (n == 0) return text;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> data(static_cast<std::size_t>(n), nullptr);
    hdf5::check(read(type, data.data()), name);
    for (const char* entry : data) text.append(entry ? entry : "").push_back('\0');
    hdf5::check(H5Dvlen_reclaim(type, space, H5P_DEFAULT, data.data()), name);
  } else {
    std::string data(static_cast<std::size_t>(n) * value_size, '\0');
    hdf5::check(read(type, data.data()), name);
    text += data;
  }
  return text;
}

void add_attributes(hid_t object, const std::string& name, Content& content) {
  std::vector<std::string> names;
  const auto append = [](hid_t, const char* attribute, const H5A_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(attribute);
    return 0;
  };
  hdf5::check(H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_INC, nullptr, append, &names), name);
  for (const std::string& attribute_name : names) {
    // References between datasets and their dimension scales are not compared.
    if (attribute_name == "DIMENSION_LIST" || attribute_name == "REFERENCE_LIST") continue;
    const std::string full_name = name + "@" + attribute_name;
    const hdf5::Handle attribute(H5Aopen(object, attribute_name.c_str(), H5P_DEFAULT), H5Aclose, full_name);
    const hdf5::Handle type(H5Aget_type(attribute), H5Tclose, full_name);
    const hdf5::Handle space(H5Aget_space(attribute), H5Sclose, full_name);
    content[full_name] = values_as_bytes(type, space, full_name, [&](hid_t memory, void* buffer) {
      return H5Aread(attribute, memory, buffer);
    });
  }
}

void add_group(hid_t group, const std::string& path, Content& content) {
  std::vector<std::string> names;
  const auto append = [](hid_t, const char* link, const H5L_info_t*, void* data) -> herr_t {
    static_cast<std::vector<std::string>*>(data)->emplace_back(link);
    return 0;
  };
  add_attributes(group, path, content);
  hdf5::check(H5Literate(group, H5_INDEX_NAME, H5_ITER_INC, nullptr, append, &names), path);
  for (const std::string& link : names) {
    const std::string name = path + link;
    if (name == "/timing" || name == "/provenance") continue;
    const hdf5::Handle object(H5Oopen(group, link.c_str(), H5P_DEFAULT), H5Oclose, name);
    if (H5Iget_type(object) == H5I_GROUP) {
      content[name] = "group";
      add_group(object, name + "/", content);
      continue;
    }
    const hdf5::Handle type(H5Dget_type(object), H5Tclose, name);
    const hdf5::Handle space(H5Dget_space(object), H5Sclose, name);
    content[name] = values_as_bytes(type, space, name, [&](hid_t memory, void* buffer) {
      return H5Dread(object, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, buffer);
    });
    add_attributes(object, name, content);
  }
}

Content read_content(const std::filesystem::path& file) {
  try {
    const hdf5::QuietErrors quiet;
    const hdf5::Handle root = hdf5::open_for_reading(file);
    Content content;
    const hdf5::Handle group = hdf5::open_group(root, "/");
    add_group(group, "/", content);
    return content;
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot read '" + file.string() + "': " + error.what());
  }
}

}  // namespace

std::vector<std::string> differences(const std::filesystem::path& a, const std::filesystem::path& b) {
  const Content first = read_content(a);
  const Content second = read_content(b);
  // A name with different contents in both occurs twice.
  std::vector<std::pair<std::string, std::string>> either;
  std::ranges::set_symmetric_difference(first, second, std::back_inserter(either));
  std::vector<std::string> names;
  for (const auto& [name, value] : either) names.push_back(name);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

}  // namespace crackle::io
