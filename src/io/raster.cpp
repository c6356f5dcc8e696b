// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/raster.h"

#include "crackle/common/failure.h"
#include "crackle/common/file_digest.h"
#include "crackle/common/printable.h"
#include "crackle/common/quantity_text.h"
#include "crackle/common/whole_number.h"

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
#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace crackle::io {

namespace {

namespace fs = std::filesystem;

struct Array {
  std::vector<std::size_t> shape;
  RasterValues values;
};

/// What a file says of its array before the numbers.
struct Header {
  std::vector<std::size_t> shape;
  std::size_t bytes_per_value = 1;  ///< while it is read
};

/// @throws std::runtime_error for more numbers than fit into a file with room for `most`
std::size_t product(const std::vector<std::size_t>& shape, std::size_t most) {
  std::size_t n = 1;
  for (const std::size_t extent : shape) {
    if (extent > 0 && n > most / extent) fail("is truncated");
    n *= extent;
  }
  return n;
}

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
Header header_of_hdf5(const hdf5::Handle& file, const std::string& name) {
  const hdf5::Handle dataset = hdf5::open_dataset(file, name);
  require_own_values(file, dataset, name);
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, "dataset " + name);
  const std::size_t size = H5Tget_size(type);
  const bool is_integer = H5Tget_class(type) == H5T_INTEGER;
  const hdf5::Shape shape = hdf5::read_shape(file, name);
  const bool is_byte = is_integer && size == 1 && H5Tget_sign(type) == H5T_SGN_NONE;
  return {{shape.begin(), shape.end()}, is_byte ? 1U : size <= (is_integer ? 2 : sizeof(float)) ? 4U : 8U};
}

Array read_hdf5(const fs::path& file, const std::string& dataset) {
  const hdf5::QuietErrors quiet;
  const hdf5::Handle handle = hdf5::open_for_reading(file);
  Header header = header_of_hdf5(handle, dataset);
  const hdf5::Shape shape(header.shape.begin(), header.shape.end());
  RasterValues values;
  if (header.bytes_per_value == 1)
    values = hdf5::read_dataset<std::uint8_t>(handle, dataset, shape);
  else if (header.bytes_per_value == sizeof(float))
    values = hdf5::read_dataset<float>(handle, dataset, shape);
  else
    values = hdf5::read_dataset<double>(handle, dataset, shape);
  return {std::move(header.shape), std::move(values)};
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
  if (depth != 16) return {{height, width}, std::move(bytes)};
  std::vector<float> values(width * height);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::uint16_t sample = 0;
    std::memcpy(&sample, &bytes[2 * i], 2);
    values[i] = sample;
  }
  return {{height, width}, std::move(values)};
}

/// As the header of the file says.
Header header_of_png(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::array<unsigned char, 25> bytes{};
  stream.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
  if (!stream) fail("is not a readable PNG picture");
  const auto extent = [&](std::size_t at) {
    return std::size_t{bytes[at]} << 24 | std::size_t{bytes[at + 1]} << 16 | std::size_t{bytes[at + 2]} << 8 |
           bytes[at + 3];
  };
  const std::size_t depth = bytes[24];
  return {{extent(20), extent(16)}, depth == 16 ? 2 + sizeof(float) : 1};
}

/// A NumPy file up to its numbers.
struct NumpyFile {
  std::ifstream stream;
  std::vector<std::size_t> shape;
  std::string kind;         ///< "u1", "f8"
  std::size_t n_bytes = 0;  ///< of the numbers
};

std::vector<std::size_t> numpy_shape(std::string_view text) {
  std::vector<std::size_t> shape;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(','), text.size());
    std::string_view number = text.substr(0, end);
    number.remove_prefix(std::min(number.find_first_not_of(' '), number.size()));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (number.empty() && text.empty()) break;
    const auto extent = whole_number<std::size_t>(number);
    if (!extent) fail("is not a NumPy array: \"{}\" is no number of cells", number);
    shape.push_back(*extent);
  }
  return shape;
}

/// NumPy's format, version 1 to 3: a magic text, the length of the header, a Python dictionary, the numbers.
NumpyFile open_numpy(const fs::path& file) {
  constexpr std::size_t longest_header = 10'000;  // that NumPy itself reads
  NumpyFile opened{std::ifstream(file, std::ios::binary), {}, {}, 0};
  std::array<char, 8> magic{};
  opened.stream.read(magic.data(), magic.size());
  if (!opened.stream || std::string_view(magic.data(), 6) != "\x93NUMPY") fail("is not a NumPy array");
  std::array<unsigned char, 4> length{};
  opened.stream.read(reinterpret_cast<char*>(length.data()), magic[6] == 1 ? 2 : 4);
  const std::size_t n_header = length[0] + (std::size_t{length[1]} << 8) + (std::size_t{length[2]} << 16) +
                               (std::size_t{length[3]} << 24);
  if (n_header > longest_header)
    fail("has a header of {} bytes; that of an array of numbers has about a hundred", n_header);
  std::string header(n_header, '\0');
  opened.stream.read(header.data(), static_cast<std::streamsize>(header.size()));
  const auto value_of = [&](std::string_view key) {
    const std::size_t at = header.find(key);
    std::string_view value = header;
    value.remove_prefix(at == std::string::npos ? value.size() : at + key.size());
    value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
    return value;
  };
  const std::string_view type = value_of("'descr':"), order = value_of("'fortran_order':"),
                         shape = value_of("'shape':");
  const bool is_number = type.size() > 4 && type[0] == '\'' && type[4] == '\'' && shape.starts_with('(');
  if (!opened.stream || !is_number || shape.find(')') == std::string_view::npos)
    fail("is not a NumPy array of numbers");
  if (type[1] == '>') fail("has numbers in big-endian order; save the array in native order");
  if (!order.starts_with("False")) fail("is in Fortran order; save numpy.ascontiguousarray of it");
  opened.kind = type.substr(2, 2);
  opened.shape = numpy_shape(shape.substr(1, shape.find(')') - 1));
  const auto start = opened.stream.tellg();
  opened.stream.seekg(0, std::ios::end);
  opened.n_bytes = static_cast<std::size_t>(opened.stream.tellg() - start);
  opened.stream.seekg(start);
  return opened;
}

/// Numbers of the type `Stored`, kept without loss as `Kept`.
template <class Stored, class Kept>
RasterValues numbers_of(NumpyFile& file) {
  std::vector<Kept> values(product(file.shape, file.n_bytes / sizeof(Stored)));
  std::vector<Stored> piece(std::min<std::size_t>(values.size(), 1 << 16));
  for (std::size_t begin = 0; begin < values.size(); begin += piece.size()) {
    piece.resize(std::min(piece.size(), values.size() - begin));
    file.stream.read(reinterpret_cast<char*>(piece.data()),
                     static_cast<std::streamsize>(piece.size() * sizeof(Stored)));
    if (!file.stream) fail("cannot be read to the end");
    std::ranges::copy(piece, values.begin() + static_cast<std::ptrdiff_t>(begin));
  }
  return values;
}

/// A type of numbers in NumPy files.
struct NumpyType {
  std::string_view kind;
  std::size_t kept;  ///< bytes of each in memory
  RasterValues (*read)(NumpyFile&);
};

constexpr std::array<NumpyType, 11> numpy_types{{{"u1", 1, numbers_of<std::uint8_t, std::uint8_t>},
                                                 {"b1", 1, numbers_of<std::uint8_t, std::uint8_t>},
                                                 {"i1", 4, numbers_of<std::int8_t, float>},
                                                 {"u2", 4, numbers_of<std::uint16_t, float>},
                                                 {"i2", 4, numbers_of<std::int16_t, float>},
                                                 {"u4", 8, numbers_of<std::uint32_t, double>},
                                                 {"i4", 8, numbers_of<std::int32_t, double>},
                                                 {"u8", 8, numbers_of<std::uint64_t, double>},
                                                 {"i8", 8, numbers_of<std::int64_t, double>},
                                                 {"f4", 4, numbers_of<float, float>},
                                                 {"f8", 8, numbers_of<double, double>}}};

const NumpyType& type_of(const NumpyFile& file) {
  const auto* const type = std::ranges::find(numpy_types, file.kind, &NumpyType::kind);
  if (type == numpy_types.end())
    fail("has numbers of the type {}; save integers, float32 or float64", file.kind);
  return *type;
}

Array read_numpy(const fs::path& path) {
  NumpyFile file = open_numpy(path);
  RasterValues values = type_of(file).read(file);
  return {std::move(file.shape), std::move(values)};
}

Array read_array(const fs::path& file, const std::string& dataset) {
  const std::string suffix = file.extension().string();
  if (suffix == ".npy") return read_numpy(file);
  if (suffix == ".png") return read_png(file);
  return read_hdf5(file, dataset);
}

Header header_of(const fs::path& file, const std::string& dataset) {
  const std::string suffix = file.extension().string();
  if (suffix == ".png") return header_of_png(file);
  if (suffix == ".npy") {
    NumpyFile opened = open_numpy(file);
    product(opened.shape, opened.n_bytes);
    return {std::move(opened.shape), type_of(opened).kept};
  }
  const hdf5::QuietErrors quiet;
  return header_of_hdf5(hdf5::open_for_reading(file), dataset);
}

}  // namespace

double raster_memory(const input::MaterialMap& map) {
  try {
    const Header header = header_of(map.path(0), map.dataset);
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
    Array array = read_array(file_, map.dataset);
    shape_ = std::move(array.shape);
    values_ = std::move(array.values);
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
