// SPDX-License-Identifier: GPL-3.0-or-later
// The readers of solids under libFuzzer: any bytes after the number of a format either give a body whose
// faces have printable names, or a message. tools/fuzz-input builds and runs it.
#include "common/printable.h"
#include "solid/solid.h"

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace crackle::solid;
  if (size == 0) return 0;
  try {
    const Solid solid = read_solid({reinterpret_cast<const char*>(data) + 1, size - 1},
                                   extensions.at(data[0] % extensions.size()), "mm", 1e-3);
    if (!(solid.volume > 0) || !(sharpest(solid).angle > 0)) std::abort();
    for (const NamedFace& face : named_faces(solid))
      if (face.name.empty() || face.name != crackle::printable(face.name)) std::abort();
  } catch (const std::runtime_error& error) {
    if (std::string(error.what()).size() > 400) std::abort();
  }
  return 0;
}
