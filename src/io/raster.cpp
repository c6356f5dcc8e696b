// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/raster.h"

#include "crackle/common/failure.h"
#include "crackle/common/file_digest.h"
#include "crackle/common/quantity_text.h"

#include "hdf5.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

namespace crackle::io {

namespace {

namespace fs = std::filesystem;

struct Array {
  std::vector<std::size_t> shape;
  std::vector<double> values;
};

std::size_t product(const std::vector<std::size_t>& shape) {
  std::size_t n = 1;
  for (const std::size_t extent : shape) n *= extent;
  return n;
}

Array read_hdf5(const fs::path& file, const std::string& dataset) {
  const hdf5::Handle handle = hdf5::open_for_reading(file);
  const hdf5::Shape shape = hdf5::read_shape(handle, dataset);
  return {{shape.begin(), shape.end()}, hdf5::read_dataset<double>(handle, dataset, shape)};
}

/// Samples as they are stored: grey levels, or indices into a palette.
Array read_png(const fs::path& file) {
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
  std::size_t width = 0, height = 0;
  int depth = 0, kind = 0;
  if (setjmp(png_jmpbuf(png)) != 0) fail("is not a readable PNG picture");  // NOLINT: the interface of libpng
  png_init_io(png, stream);
  png_read_info(png, info);
  width = png_get_image_width(png, info);
  height = png_get_image_height(png, info);
  kind = png_get_color_type(png, info);
  if (png_get_bit_depth(png, info) < 8) png_set_packing(png);
  if (std::endian::native == std::endian::little && png_get_bit_depth(png, info) == 16) png_set_swap(png);
  png_read_update_info(png, info);
  depth = png_get_bit_depth(png, info);
  bytes.resize(png_get_rowbytes(png, info) * height);
  for (std::size_t row = 0; row < height; ++row)
    rows.push_back(bytes.data() + row * png_get_rowbytes(png, info));
  png_read_image(png, rows.data());
  if (kind != PNG_COLOR_TYPE_GRAY && kind != PNG_COLOR_TYPE_PALETTE)
    fail("has colours or transparency; save the picture in grey, or with a palette");
  Array array{{height, width}, {}};
  array.values.reserve(width * height);
  for (std::size_t i = 0; i < width * height; ++i) {
    std::uint16_t sample = bytes[depth == 16 ? 2 * i : i];
    if (depth == 16) std::memcpy(&sample, &bytes[2 * i], 2);
    array.values.push_back(sample);
  }
  return array;
}

template <class Value>
std::vector<double> converted(const std::string& bytes) {
  std::vector<double> values;
  values.reserve(bytes.size() / sizeof(Value));
  for (std::size_t at = 0; at + sizeof(Value) <= bytes.size(); at += sizeof(Value)) {
    Value value;
    std::memcpy(&value, bytes.data() + at, sizeof(Value));
    values.push_back(static_cast<double>(value));
  }
  return values;
}

/// NumPy's format, version 1 to 3: a magic text, the length of the header, a Python dictionary, the numbers.
Array read_numpy(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<char, 8> magic{};
  stream.read(magic.data(), magic.size());
  if (!stream || std::string_view(magic.data(), 6) != "\x93NUMPY") fail("is not a NumPy array");
  std::array<unsigned char, 4> length{};
  const int n_length = magic[6] == 1 ? 2 : 4;
  stream.read(reinterpret_cast<char*>(length.data()), n_length);
  std::string header(length[0] + (std::size_t{length[1]} << 8) + (std::size_t{length[2]} << 16), '\0');
  stream.read(header.data(), static_cast<std::streamsize>(header.size()));
  std::smatch found;
  const std::regex form(
      R"('descr':\s*'([<>|=])([a-z])(\d)'.*'fortran_order':\s*(True|False).*'shape':\s*\(([^)]*)\))");
  if (!stream || !std::regex_search(header, found, form)) fail("is not a NumPy array of numbers");
  if (found[1] == ">") fail("has numbers in big-endian order; save the array in native order");
  if (found[4] == "True") fail("is in Fortran order; save numpy.ascontiguousarray of it");
  Array array;
  const std::string shape = found[5];
  const std::regex number("\\d+");
  for (std::sregex_iterator i(shape.begin(), shape.end(), number), end; i != end; ++i)
    array.shape.push_back(std::stoul(i->str()));
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  const std::string kind = found[2].str() + found[3].str();
  if (kind == "u1" || kind == "b1")
    array.values = converted<std::uint8_t>(bytes);
  else if (kind == "i1")
    array.values = converted<std::int8_t>(bytes);
  else if (kind == "u2")
    array.values = converted<std::uint16_t>(bytes);
  else if (kind == "i2")
    array.values = converted<std::int16_t>(bytes);
  else if (kind == "u4")
    array.values = converted<std::uint32_t>(bytes);
  else if (kind == "i4")
    array.values = converted<std::int32_t>(bytes);
  else if (kind == "u8")
    array.values = converted<std::uint64_t>(bytes);
  else if (kind == "i8")
    array.values = converted<std::int64_t>(bytes);
  else if (kind == "f4")
    array.values = converted<float>(bytes);
  else if (kind == "f8")
    array.values = converted<double>(bytes);
  else
    fail("has numbers of the type {}; save integers, float32 or float64", kind);
  if (array.values.size() < product(array.shape)) fail("is truncated");
  return array;
}

Array read_array(const fs::path& file, const std::string& dataset) {
  const std::string suffix = file.extension().string();
  if (suffix == ".npy") return read_numpy(file);
  if (suffix == ".png") return read_png(file);
  return read_hdf5(file, dataset);
}

}  // namespace

Raster::Raster(const input::MaterialMap& map, std::uint64_t sample, const geometry::Box& body)
    : file_(map.path(sample)), origin_(map.origin), spacing_(map.spacing) {
  const auto refuse = [&](const std::string& reason) { fail("{}: {}", file_.string(), reason); };
  if (!map.has_file_per_sample() && file_digest(file_) != map.checksum)
    refuse("has other contents than the checksum in [material.map] says, or cannot be read");
  for (const int axis : map.axes) axes_.push_back(static_cast<std::size_t>(axis));
  try {
    Array array = read_array(file_, map.dataset);
    shape_ = std::move(array.shape);
    values_ = std::move(array.values);
  } catch (const std::exception& error) {
    const std::string reason = error.what();
    if (reason.find(file_.string()) != std::string::npos) throw;
    refuse(reason);
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
  for (double& value : values_) value *= map.scale;
}

double Raster::at(const geometry::Point& p) const {
  std::size_t place = 0;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const double cell = std::round((p[axes_[k]] - origin_[k]) / spacing_[k]);
    place = place * shape_[k] +
            static_cast<std::size_t>(std::clamp(cell, 0.0, static_cast<double>(shape_[k] - 1)));
  }
  return values_[place];
}

}  // namespace crackle::io
