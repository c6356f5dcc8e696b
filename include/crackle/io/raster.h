// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/box.h"
#include "crackle/geometry/point.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace crackle::io {

/// A raster of numbers, with its place in the body (input::MaterialMap).
class Raster {
public:
  /// Reads the file of a sample: a dataset of an HDF5 file, an array of NumPy or a picture.
  /// @throws std::runtime_error naming the file when it cannot be read, has another number of dimensions than
  ///   the map has axes, does not cover the body, or is not the one whose checksum the map has
  Raster(const input::MaterialMap& map, std::uint64_t sample, const geometry::Box& body);

  /// Value of the cell that contains a point of the body, times the map's scale.
  double at(const geometry::Point& p) const;

  const std::filesystem::path& file() const { return file_; }

private:
  std::filesystem::path file_;
  std::vector<std::size_t> shape_;
  std::vector<double> values_;  // the last dimension varies fastest
  std::vector<std::size_t> axes_;
  std::vector<double> origin_, spacing_;
};

}  // namespace crackle::io
