// SPDX-License-Identifier: GPL-3.0-or-later
#include "specimen.h"

#include "crackle/geometry/outline.h"
#include "result_attributes.h"

#include <type_traits>

namespace crackle::io {

void write_specimen(hid_t file, const geometry::Body& body) {
  const hdf5::Handle group = hdf5::create_group(file, "specimen");
  geometry::for_each_member(
      geometry::outline_of(body),
      [&](const char* name, const auto& shape, const auto& values, const char* units, const char* meaning) {
        using Value = typename std::remove_cvref_t<decltype(values)>::value_type;
        hdf5::write_dataset<Value>(group.get(), name, hdf5::Shape(shape.begin(), shape.end()), values, units);
        describe_dataset(group.get(), name, meaning);
      });
}

}  // namespace crackle::io
