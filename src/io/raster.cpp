// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/raster.h"

#include "common/checksum.h"
#include "common/failure.h"
#include "common/printable.h"
#include "common/quantity_text.h"

#include "hdf5.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <png.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string>
#include <utility>

namespace crackle::io {

namespace {

namespace fs = std::filesystem;

/// What a file says of its array before the numbers.
struct Header {
  std::vector<std::size_t> shape;
  std::size_t bytes_per_value = 1;  ///< while it is read
};

/// The numbers of an HDF5 dataset are in its own file, of which the checksum is taken, and all were written.
void require_own_values(const hdf5::Handle& file, const hdf5::Handle& dataset, const std::string& name) {
  const auto name_of_file = [](hid_t object) {
    std::string text(static_cast<std::size_t>(std::max<ssize_t>(H5Fget_name(object, nullptr, 0), 0)), '\0');
    H5Fget_name(object, text.data(), text.size() + 1);
    return text;
  };
  const hdf5::Handle list(H5Dget_create_plist(dataset), H5Pclose, "dataset " + name);
  const H5D_layout_t layout = H5Pget_layout(list);
  if (layout == H5D_VIRTUAL || H5Pget_external_count(list) > 0 || name_of_file(dataset) != name_of_file(file))
    fail(
        "the values of \"{}\" are in other files, which the checksum in [material.map] does not cover; copy "
        "them into this one",
        name);
  H5D_fill_value_t fill{};
  hdf5::check(H5Pfill_value_defined(list, &fill), "dataset " + name);
  if (fill == H5D_FILL_VALUE_USER_DEFINED) return;
  bool is_complete = H5Dget_storage_size(dataset) > 0;
  if (layout == H5D_CHUNKED) {
    const hdf5::Shape shape = hdf5::read_shape(file, name);
    hdf5::Shape chunk(shape.size());
    hdf5::check(H5Pget_chunk(list, static_cast<int>(chunk.size()), chunk.data()), "dataset " + name);
    hsize_t n_chunks = 1, n_written = 0;
    for (std::size_t k = 0; k < shape.size(); ++k) n_chunks *= (shape[k] + chunk[k] - 1) / chunk[k];
    const hdf5::Handle space(H5Dget_space(dataset), H5Sclose, "dataset " + name);
    hdf5::check(H5Dget_num_chunks(dataset, space, &n_written), "dataset " + name);
    is_complete = n_written == n_chunks;
  }
  if (!is_complete) fail("is not complete: values of \"{}\" were never written", name);
}

/// Without loss, numbers of one byte or two are kept in as many or in four.
Header read_hdf5(const hdf5::Handle& file, const std::string& name, RasterValues* values) {
  const hdf5::Handle dataset = hdf5::open_dataset(file, name);
  require_own_values(file, dataset, name);
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, "dataset " + name);
  const std::size_t size = H5Tget_size(type);
  const bool is_integer = H5Tget_class(type) == H5T_INTEGER;
  const bool is_byte = is_integer && size == 1 && H5Tget_sign(type) == H5T_SGN_NONE;
  const hdf5::Shape shape = hdf5::read_shape(file, name);
  const Header header{{shape.begin(), shape.end()},
                      is_byte                                    ? 1U
                      : size <= (is_integer ? 2 : sizeof(float)) ? 4U
                                                                 : 8U};
  if (values == nullptr) return header;
  if (header.bytes_per_value == 1)
    *values = hdf5::read_dataset<std::uint8_t>(file, name, shape);
  else if (header.bytes_per_value == sizeof(float))
    *values = hdf5::read_dataset<float>(file, name, shape);
  else
    *values = hdf5::read_dataset<double>(file, name, shape);
  return header;
}

/// Of a picture, with its samples as they are stored, grey levels or indices into a palette, unless `samples`
/// is null.
Header read_png(const fs::path& file, RasterValues* samples) {
  std::FILE* const stream = std::fopen(file.c_str(), "rb");
  if (stream == nullptr) fail("cannot be opened");
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> close(stream, std::fclose);
  // The caller reports the error, instead of libpng on the standard error.
  png_structp png = png_create_read_struct(
      PNG_LIBPNG_VER_STRING, nullptr, [](png_structp failed, png_const_charp) { png_longjmp(failed, 1); },
      [](png_structp, png_const_charp) {});
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  struct Owner {
    png_structp* png;
    png_infop* info;
    ~Owner() { png_destroy_read_struct(png, info, nullptr); }
  } const owner{&png, &info};
  if (info == nullptr) fail("there is not enough memory to read it");
  std::vector<png_byte> bytes;
  std::vector<png_bytep> rows;
  Header header;
  int depth = 0, kind = 0;
  if (setjmp(png_jmpbuf(png)) != 0) fail("is not a readable PNG picture");  // NOLINT: the interface of libpng
  png_init_io(png, stream);
  png_read_info(png, info);
  header.shape = {png_get_image_height(png, info), png_get_image_width(png, info)};
  kind = png_get_color_type(png, info);
  depth = png_get_bit_depth(png, info);
  if (depth == 16) header.bytes_per_value = 2 + sizeof(float);
  if (samples == nullptr) return header;
  if (depth < 8) png_set_packing(png);
  if (std::endian::native == std::endian::little && depth == 16) png_set_swap(png);
  png_read_update_info(png, info);
  bytes.resize(png_get_rowbytes(png, info) * header.shape[0]);
  for (std::size_t row = 0; row < header.shape[0]; ++row)
    rows.push_back(bytes.data() + row * png_get_rowbytes(png, info));
  png_read_image(png, rows.data());
  if (kind != PNG_COLOR_TYPE_GRAY && kind != PNG_COLOR_TYPE_PALETTE)
    fail("has colours or transparency; save the picture in grey, or with a palette");
  if (depth == 16) {
    std::vector<std::uint16_t> numbers(bytes.size() / 2);
    std::memcpy(numbers.data(), bytes.data(), bytes.size());
    *samples = std::vector<float>(numbers.begin(), numbers.end());
  } else {
    *samples = std::move(bytes);
  }
  return header;
}

/// @param values receives them unless it is null
Header read_file(const fs::path& file, const std::string& dataset, RasterValues* values) {
  if (file.extension() == ".png") return read_png(file, values);
  const hdf5::QuietErrors quiet;
  return read_hdf5(hdf5::open_for_reading(file), dataset, values);
}

}  // namespace

double raster_memory(const input::MaterialMap& map) {
  try {
    const Header header = read_file(map.path(0), map.dataset, nullptr);
    auto bytes = static_cast<double>(header.bytes_per_value);
    for (const std::size_t extent : header.shape) bytes *= static_cast<double>(extent);
    return bytes;
  } catch (const std::exception&) {
    return 0;  // reading it reports the error
  }
}

Raster::Raster(const input::MaterialMap& map, std::uint64_t sample, const geometry::Box& body)
    : file_(map.path(sample)), origin_(map.origin), spacing_(map.spacing), scale_(map.scale) {
  const auto refuse = [&](const std::string& reason) { fail("{}: {}", file_.string(), reason); };
  if (!map.has_file_per_sample() && file_digest(file_) != map.checksum)
    refuse("has other contents than the checksum in [material.map] says, or cannot be read");
  for (const int axis : map.axes) axes_.push_back(static_cast<std::size_t>(axis));
  try {
    shape_ = read_file(file_, map.dataset, &values_).shape;
  } catch (const std::exception& error) {
    refuse(reason_of(error));
  }
  if (shape_.size() != axes_.size())
    refuse(fmt::format("has the shape {}, but [material.map] names {} axes", fmt::join(shape_, " x "),
                       axes_.size()));
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const double first = origin_[k] - 0.5 * spacing_[k];
    const auto [low, high] = std::minmax({first, first + static_cast<double>(shape_[k]) * spacing_[k]});
    const double tolerance = 1e-9 * (high - low);
    if (body.lower[axes_[k]] < low - tolerance || body.upper[axes_[k]] > high + tolerance)
      refuse(fmt::format("covers {} = {} to {}, but the body reaches from {} to {}", "xyz"[axes_[k]],
                         quantity_text(low, "m"), quantity_text(high, "m"),
                         quantity_text(body.lower[axes_[k]], "m"), quantity_text(body.upper[axes_[k]], "m")));
  }
}

double Raster::at(const geometry::Point& p) const {
  std::size_t place = 0;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const double cell = std::round((p[axes_[k]] - origin_[k]) / spacing_[k]);
    place = place * shape_[k] +
            static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(shape_[k] - 1)));
  }
  return scale_ * std::visit([=](const auto& values) { return static_cast<double>(values[place]); }, values_);
}

}  // namespace crackle::io
