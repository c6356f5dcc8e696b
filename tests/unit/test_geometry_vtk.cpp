// SPDX-License-Identifier: GPL-3.0-or-later
// The VTK files, read back by VTK itself if its Python module is installed.
#include "common/index.h"
#include "geometry/quality.h"
#include "io/vtk_file.h"

#include "support/geometry_bodies.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace crackle::io {
namespace CRACKLE_TEST_FILE {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

geometry::Body small_body() {
  return testing::body({1, 4, 5}, {testing::notch(plane::Face::y_min, 2, 1.5, 0.5)});
}

/// With two regions, the second of which contains the first.
input::Mesh small_mesh() {
  input::Mesh mesh = testing::mesh(0.7, 0.25);
  mesh.regions = {testing::region({plane::unbounded, {3, 4}, {3, 4}}, 0.3),
                  testing::region({plane::unbounded, plane::unbounded, {2.5, 5}}, 0.5)};
  return mesh;
}

geometry::MotherPoints small_base() {
  return geometry::make_mother_points(small_body(), small_mesh(), 1);
}

geometry::Realization small() {
  return geometry::make_realization(small_body(), small_base(), small_mesh(), 1, 0);
}

/// The system's Python, which has Debian's VTK module.
constexpr const char* interpreter = "/usr/bin/python3";

class VtkFile : public ::testing::Test {
protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / fmt::format("crackle_vtk_{}", ::getpid());
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// Output of a Python program; its argument is the file name.
  std::string python(const std::string& program, const std::filesystem::path& file) const {
    const std::filesystem::path script = folder_ / "read.py";
    std::ofstream(script) << program;
    std::FILE* const pipe =
        ::popen(fmt::format("{} {} {} 2>&1", interpreter, script.string(), file.string()).c_str(), "r");
    if (pipe == nullptr) return "popen failed";
    std::string output;
    std::array<char, 256> buffer{};
    while (std::fgets(buffer.data(), buffer.size(), pipe) != nullptr) output += buffer.data();
    if (::pclose(pipe) != 0) output += "\nexit status is not 0";
    return output;
  }
  static bool has_vtk() {
    static const bool found =
        std::system(
            fmt::format("{} -c 'from vtkmodules.vtkIOHDF import vtkHDFReader' > /dev/null 2>&1", interpreter)
                .c_str()) == 0;
    return found;
  }
  std::size_t n_files() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }
  std::filesystem::path folder_;
};

constexpr const char* reader = R"(
import sys
from vtkmodules.vtkIOHDF import vtkHDFReader
from vtkmodules.vtkFiltersVerdict import vtkCellSizeFilter
reader = vtkHDFReader()
reader.SetFileName(sys.argv[1])
reader.Update()
grid = reader.GetOutput()
size = vtkCellSizeFilter()
size.SetInputData(grid)
size.Update()
measure = size.GetOutput().GetCellData().GetArray("Volume" if grid.GetCellType(0) == 10 else "Area")
total = sum(measure.GetValue(i) for i in range(measure.GetNumberOfTuples()))
field = grid.GetCellData().GetArray(0)
print(grid.GetNumberOfPoints(), grid.GetNumberOfCells(), grid.GetCellType(0), field.GetName(),
      "%.6e %.6e" % (field.GetRange(0)[0], field.GetRange(0)[1]), "%.6e" % total)
)";

TEST_F(VtkFile, MeshIsReadByVtk) {
  const geometry::Realization mesh = small();
  const std::filesystem::path file = folder_ / "mesh.vtkhdf";
  write_vtk_mesh(file, mesh, small_body(), small_mesh(), small_base());
  EXPECT_EQ(n_files(), 1u);
  if (!has_vtk()) GTEST_SKIP() << "python3-vtk9 is not installed";
  double worst = 1;
  double best = 0;
  double volume = 0;
  for (const auto& t : mesh.tetrahedra) {
    const auto node = [&](std::size_t i) { return mesh.nodes[index(t[i])]; };
    const double quality = geometry::mean_ratio(node(0), node(1), node(2), node(3));
    worst = std::min(worst, quality);
    best = std::max(best, quality);
    volume += geometry::signed_volume(node(0), node(1), node(2), node(3));
  }
  EXPECT_EQ(python(reader, file), fmt::format("{} {} 10 quality {:.6e} {:.6e} {:.6e}\n", mesh.nodes.size(),
                                              mesh.tetrahedra.size(), worst, best, volume));
}

constexpr const char* point_reader = R"(
import sys
from vtkmodules.vtkIOHDF import vtkHDFReader
reader = vtkHDFReader()
reader.SetFileName(sys.argv[1])
reader.Update()
fields = reader.GetOutput().GetPointData()
spacing, region = fields.GetArray("spacing"), fields.GetArray("region")
number = [region.GetValue(i) for i in range(region.GetNumberOfTuples())]
print(len(number), spacing.GetNumberOfTuples(), "%.6e %.6e" % spacing.GetRange(),
      *(number.count(which) for which in (0, 1, -1)))
)";

TEST_F(VtkFile, PointsHaveTheSpacingAskedForAndTheirRegion) {
  const geometry::Realization mesh = small();
  const std::filesystem::path file = folder_ / "mesh.vtkhdf";
  write_vtk_mesh(file, mesh, small_body(), small_mesh(), small_base());
  if (!has_vtk()) GTEST_SKIP() << "python3-vtk9 is not installed";
  std::array<int, 3> n{};
  for (const geometry::Point& p : mesh.nodes) {
    const bool first = p[1] >= 3e-3 && p[2] >= 3e-3 && p[2] <= 4e-3;
    ++n[first ? 0 : p[2] >= 2.5e-3 ? 1 : 2];
  }
  EXPECT_GT(n[0], 10);
  const geometry::SpacingField field(small_body(), small_mesh());
  double least = 1, greatest = 0;
  for (const geometry::Point& p : mesh.nodes) {
    least = std::min(least, field(p));
    greatest = std::max(greatest, field(p));
  }
  EXPECT_EQ(python(point_reader, file), fmt::format("{0} {0} {1:.6e} {2:.6e} {3} {4} {5}\n",
                                                    mesh.nodes.size(), least, greatest, n[0], n[1], n[2]));
}

TEST_F(VtkFile, DualSurfaceIsReadByVtk) {
  const geometry::Realization mesh = small();
  const geometry::DualSurface surface = geometry::dual_surface(mesh);
  const std::filesystem::path file = folder_ / "dual.vtkhdf";
  write_vtk_dual_surface(file, surface);
  if (!has_vtk()) GTEST_SKIP() << "python3-vtk9 is not installed";
  EXPECT_THAT(python(reader, file),
              HasSubstr(fmt::format("{} {} 9 tetrahedron {:.6e} {:.6e}", surface.points.size(),
                                    surface.quadrilaterals.size(), 0.0,
                                    static_cast<double>(mesh.tetrahedra.size() - 1))));
}

TEST_F(VtkFile, ReplacesAnExistingFile) {
  const std::filesystem::path file = folder_ / "mesh.vtkhdf";
  std::ofstream(file) << "something else";
  write_vtk_mesh(file, small(), small_body(), small_mesh(), small_base());
  EXPECT_GT(std::filesystem::file_size(file), 10000u);
  EXPECT_EQ(n_files(), 1u);
}

TEST_F(VtkFile, FailuresNameTheFileAndLeaveNothing) {
  const geometry::Realization mesh = small();
  EXPECT_THAT(
      [&] {
        write_vtk_mesh(folder_ / "missing" / "mesh.vtkhdf", mesh, small_body(), small_mesh(), small_base());
      },
      ThrowsMessage<std::runtime_error>(
          AllOf(HasSubstr("missing/mesh.vtkhdf': "), HasSubstr("there is no folder"))));
  std::filesystem::create_directories(folder_ / "taken" / "inside");
  EXPECT_THAT([&] { write_vtk_mesh(folder_ / "taken", mesh, small_body(), small_mesh(), small_base()); },
              ThrowsMessage<std::runtime_error>(HasSubstr("taken': ")));
  EXPECT_EQ(n_files(), 1u);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::io
