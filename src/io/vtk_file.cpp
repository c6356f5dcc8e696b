// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/io/vtk_file.h"

#include "crackle/geometry/quality.h"

#include <fmt/format.h>
#include <hdf5.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace crackle::io {

namespace {

constexpr std::uint8_t vtk_quad = 9;
constexpr std::uint8_t vtk_tetra = 10;

/// Owns one HDF5 identifier.
class Handle {
public:
  Handle(hid_t id, herr_t (*close)(hid_t), const char* call) : id_(id), close_(close) {
    if (id_ < 0) throw std::runtime_error(std::string(call) + " failed");
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  hid_t get() const { return id_; }
  /// Closes now, where a failure (a full disk) can still be reported.
  void close(const char* call) {
    const hid_t id = id_;
    id_ = -1;
    if (close_(id) < 0) throw std::runtime_error(std::string(call) + " failed");
  }

private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

void check(herr_t status, const char* call) {
  if (status < 0) throw std::runtime_error(std::string(call) + " failed");
}

/// Keeps HDF5 from printing its error stack: failures are exceptions here.
class QuietErrors {
public:
  QuietErrors() {
    H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~QuietErrors() { H5Eset_auto2(H5E_DEFAULT, function_, data_); }
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

private:
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

hid_t native(double) {
  return H5T_NATIVE_DOUBLE;
}
hid_t native(std::int64_t) {
  return H5T_NATIVE_INT64;
}
hid_t native(std::int32_t) {
  return H5T_NATIVE_INT32;
}
hid_t native(std::uint8_t) {
  return H5T_NATIVE_UINT8;
}

/// Writes a dataset of values.size() / columns rows; one-dimensional for columns = 1.
template <class T>
void write_dataset(const Handle& group, const char* name, const std::vector<T>& values, hsize_t columns = 1) {
  const std::array<hsize_t, 2> shape{values.size() / columns, columns};
  const Handle space(H5Screate_simple(columns == 1 ? 1 : 2, shape.data(), nullptr), H5Sclose,
                     "H5Screate_simple");
  const Handle dataset(
      H5Dcreate2(group.get(), name, native(T{}), space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose, "H5Dcreate2");
  check(H5Dwrite(dataset.get(), native(T{}), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), "H5Dwrite");
}

void write_type(const Handle& group) {
  const std::string_view name = "UnstructuredGrid";
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, "H5Tcopy");
  check(H5Tset_size(type.get(), name.size()), "H5Tset_size");
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "H5Tset_strpad");
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose, "H5Screate");
  const Handle attribute(H5Acreate2(group.get(), "Type", type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, "H5Acreate2");
  check(H5Awrite(attribute.get(), type.get(), name.data()), "H5Awrite");
}

void write_version(const Handle& group) {
  const std::array<std::int64_t, 2> version{1, 0};
  const hsize_t size = version.size();
  const Handle space(H5Screate_simple(1, &size, nullptr), H5Sclose, "H5Screate_simple");
  const Handle attribute(
      H5Acreate2(group.get(), "Version", H5T_NATIVE_INT64, space.get(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose,
      "H5Acreate2");
  check(H5Awrite(attribute.get(), H5T_NATIVE_INT64, version.data()), "H5Awrite");
}

template <class T>
void write_grid(const std::filesystem::path& file, const std::vector<geometry::Point>& points,
                const std::vector<std::array<std::int32_t, 4>>& cells, std::uint8_t cell_type,
                const char* field_name, const std::vector<T>& field) {
  std::vector<double> coordinates;
  coordinates.reserve(3 * points.size());
  for (const geometry::Point& p : points) coordinates.insert(coordinates.end(), p.begin(), p.end());
  std::vector<std::int64_t> connectivity;
  std::vector<std::int64_t> offsets{0};
  connectivity.reserve(4 * cells.size());
  for (const auto& cell : cells) {
    connectivity.insert(connectivity.end(), cell.begin(), cell.end());
    offsets.push_back(static_cast<std::int64_t>(connectivity.size()));
  }
  const auto count = [](std::size_t n) { return std::vector<std::int64_t>{static_cast<std::int64_t>(n)}; };

  Handle output(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, "H5Fcreate");
  {
    const Handle group(H5Gcreate2(output.get(), "VTKHDF", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                       "H5Gcreate2");
    write_version(group);
    write_type(group);
    write_dataset(group, "NumberOfPoints", count(points.size()));
    write_dataset(group, "NumberOfCells", count(cells.size()));
    write_dataset(group, "NumberOfConnectivityIds", count(connectivity.size()));
    write_dataset(group, "Points", coordinates, 3);
    write_dataset(group, "Connectivity", connectivity);
    write_dataset(group, "Offsets", offsets);
    write_dataset(group, "Types", std::vector<std::uint8_t>(cells.size(), cell_type));
    const Handle fields(H5Gcreate2(group.get(), "CellData", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose,
                        "H5Gcreate2");
    write_dataset(fields, field_name, field);
  }
  check(H5Fflush(output.get(), H5F_SCOPE_GLOBAL), "H5Fflush");
  output.close("H5Fclose");
}

/// Runs write(path) on a file of another name in the same folder, then renames it.
template <class Write>
void replace_file(const std::filesystem::path& file, const Write& write) {
  const std::filesystem::path folder = file.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder)) {
    throw std::runtime_error(
        fmt::format("{}: cannot be written: there is no folder {}", file.string(), folder.string()));
  }
  const QuietErrors quiet;
  std::filesystem::path partial = file;
  partial += fmt::format(".partial.{}", ::getpid());
  try {
    write(partial);
    std::filesystem::rename(partial, file);
  } catch (const std::exception& failure) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw std::runtime_error(fmt::format("{}: cannot be written: {}", file.string(), failure.what()));
  }
}

}  // namespace

void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization) {
  std::vector<double> quality;
  quality.reserve(realization.tetrahedra.size());
  const auto node = [&](std::int32_t i) { return realization.nodes[static_cast<std::size_t>(i)]; };
  for (const geometry::Tetrahedron& t : realization.tetrahedra)
    quality.push_back(geometry::mean_ratio(node(t[0]), node(t[1]), node(t[2]), node(t[3])));
  replace_file(file, [&](const std::filesystem::path& path) {
    write_grid(path, realization.nodes, realization.tetrahedra, vtk_tetra, "quality", quality);
  });
}

void write_vtk_dual_surface(const std::filesystem::path& file, const geometry::DualSurface& surface) {
  replace_file(file, [&](const std::filesystem::path& path) {
    write_grid(path, surface.points, surface.quadrilaterals, vtk_quad, "tetrahedron", surface.tetrahedron);
  });
}

}  // namespace crackle::io
