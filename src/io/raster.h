// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/box.h"
#include "geometry/point.h"
#include "input/model.h"

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

namespace crackle::io {

/// Numbers in the smallest of these types that has all values of the file's type.
using RasterValues = std::variant<std::vector<std::uint8_t>, std::vector<float>, std::vector<double>>;

/// Memory for reading and keeping the raster of the first sample [byte]; 0 if the file is not readable.
double raster_memory(const input::MaterialMap& map);

/// A raster of numbers, with its place in the body (input::MaterialMap).
class Raster {
public:
  /// Reads the file of a sample: a dataset of an HDF5 file, or a picture.
  /// @throws std::runtime_error naming the file when it cannot be read, has another number of dimensions than
  ///   the map has axes, does not cover the body, is not the one whose checksum the map has, or has values in
  ///   other files, or values that were never written
  Raster(const input::MaterialMap& map, std::uint64_t sample, const geometry::Box& body);

  /// Value of the cell that contains a point of the body, times the map's scale.
  double at(const geometry::Point& p) const;

  const std::filesystem::path& file() const { return file_; }

private:
  std::filesystem::path file_;
  std::vector<std::size_t> shape_;
  RasterValues values_;  // the last dimension varies fastest
  std::vector<std::size_t> axes_;
  std::vector<double> origin_, spacing_;
  double scale_;
};

}  // namespace crackle::io
