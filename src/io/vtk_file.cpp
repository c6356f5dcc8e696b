// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/vtk_file.h"

#include "common/failure.h"
#include "common/index.h"
#include "geometry/mesh_regions.h"
#include "geometry/mother_points.h"
#include "geometry/pre_crack.h"
#include "geometry/quality.h"

#include "hdf5.h"
#include "partial_file.h"
#include "result_attributes.h"

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <variant>

namespace crackle::io {

namespace {

constexpr std::uint8_t vtk_quad = 9;
constexpr std::uint8_t vtk_tetra = 10;

void write_list(hid_t group, const char* name, const std::vector<geometry::Point>& points) {
  std::vector<double> values;
  hdf5::flatten(points, values);
  hdf5::write_dataset<double>(group, name, {points.size(), 3}, values, "");
}

template <class Value>
void write_list(hid_t group, const char* name, const std::vector<Value>& values) {
  hdf5::write_dataset<Value>(group, name, {values.size()}, values, "");
}

/// A name with one value per point or cell.
using Field =
    std::pair<const char*,
              std::variant<std::vector<double>, std::vector<std::int32_t>, std::vector<geometry::Point>>>;

struct Fields {
  std::vector<Field> of_points;
  std::vector<Field> of_cells;
};

void write_fields(hid_t parent, const char* name, const std::vector<Field>& fields) {
  if (fields.empty()) return;
  const hdf5::Handle group = hdf5::create_group(parent, name);
  for (const auto& [field_name, field] : fields)
    std::visit([&, field_name = field_name](const auto& values) { write_list(group, field_name, values); },
               field);
}

/// @param add writes additional data that VTK ignores
void write_grid(const std::filesystem::path& path, const std::vector<geometry::Point>& points,
                const std::vector<std::array<std::int32_t, 4>>& cells, std::uint8_t cell_type,
                const Fields& fields, const std::function<void(hid_t)>& add = {}) {
  const std::filesystem::path folder = path.parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder))
    fail("cannot write '{}': there is no folder '{}'", path.string(), folder.string());
  std::vector<std::int64_t> connectivity, offsets;
  hdf5::flatten(cells, connectivity);
  for (std::size_t i = 0; i <= cells.size(); ++i) offsets.push_back(static_cast<std::int64_t>(4 * i));
  const auto count = [](std::size_t n) { return std::vector<std::int64_t>{static_cast<std::int64_t>(n)}; };

  const hdf5::QuietErrors quiet;
  hdf5::MemoryFile file;
  {
    const hdf5::Handle group = hdf5::create_group(file, "VTKHDF");
    hdf5::write_attribute<std::int64_t>(group, "Version", std::array<std::int64_t, 2>{1, 0}, {2});
    hdf5::write_fixed_text_attribute(group, "Type", "UnstructuredGrid");
    write_list(group, "NumberOfPoints", count(points.size()));
    write_list(group, "NumberOfCells", count(cells.size()));
    write_list(group, "NumberOfConnectivityIds", count(connectivity.size()));
    write_list(group, "Points", points);
    write_list(group, "Connectivity", connectivity);
    write_list(group, "Offsets", offsets);
    write_list(group, "Types", std::vector<std::uint8_t>(cells.size(), cell_type));
    write_fields(group, "PointData", fields.of_points);
    write_fields(group, "CellData", fields.of_cells);
  }
  if (add) add(file);
  make_folders_of(path);
  write_whole_file(path, file.finish());
}

/// Writes the part of the body covered by each region, and its spacing.
void write_regions(hid_t root, const geometry::Body& body, const input::Mesh& mesh) {
  const hdf5::Handle group = hdf5::create_group(root, "regions");
  std::vector<double> boxes;
  std::vector<double> spacings;
  for (const input::MeshRegion& region : mesh.regions) {
    const geometry::Box box = geometry::box_of(region, body.bounds());
    for (std::size_t i = 0; i < 3; ++i) boxes.insert(boxes.end(), {box.lower[i], box.upper[i]});
    spacings.push_back(region.spacing);
  }
  hdf5::write_dataset<double>(group, "box", {spacings.size(), 3, 2}, boxes, "m");
  hdf5::write_dataset<double>(group, "spacing", {spacings.size()}, spacings, "m");
}

/// For each node the number of its face's name, in the order of the names; -1 inside the body.
std::vector<std::int32_t> face_numbers(std::span<const geometry::Point> nodes, const geometry::Body& body) {
  std::map<std::string, std::int32_t> numbers;
  for (const geometry::Face& face : body.faces())
    numbers.emplace(face.names.front(), static_cast<std::int32_t>(numbers.size()));
  std::vector<std::int32_t> result;
  for (const geometry::Point& p : nodes) {
    std::int32_t number = -1;
    for (const geometry::FaceId face : body.faces_at(body.place_of(p))) {
      const auto own = numbers.at(body.faces()[index(face)].names.front());
      number = number < 0 ? own : std::min(number, own);
    }
    result.push_back(number);
  }
  return result;
}

}  // namespace

void write_vtk_mesh(const std::filesystem::path& file, const geometry::Realization& realization,
                    const geometry::Body& body, const input::Mesh& mesh, const geometry::MotherPoints& base,
                    std::vector<double> strength_factor) {
  const geometry::SpacingField wanted(body, mesh);
  std::vector<double> spacing;
  spacing.reserve(realization.nodes.size());
  for (const geometry::Point& p : realization.nodes) spacing.push_back(wanted(p));
  std::vector<double> quality;
  quality.reserve(realization.tetrahedra.size());
  const auto node = [&](std::int32_t i) { return realization.nodes[index(i)]; };
  for (const geometry::Tetrahedron& t : realization.tetrahedra)
    quality.push_back(geometry::mean_ratio(node(t[0]), node(t[1]), node(t[2]), node(t[3])));
  Fields fields{
      {{"spacing", std::move(spacing)}, {"region", geometry::region_numbers(realization.nodes, body, mesh)}},
      {{"quality", std::move(quality)}, {"refined", geometry::refined_interior(realization, body, mesh)}}};
  if (body.outline().empty()) fields.of_points.emplace_back("face", face_numbers(realization.nodes, body));
  if (mesh.perturbation > 0)
    fields.of_points.emplace_back("displacement",
                                  geometry::relative_displacements(body, base, realization, mesh));
  if (!strength_factor.empty()) fields.of_cells.emplace_back("strength_factor", std::move(strength_factor));
  if (!realization.material.empty())
    fields.of_cells.emplace_back(
        "material", std::vector<std::int32_t>(realization.material.begin(), realization.material.end()));
  if (!realization.interface.empty())
    fields.of_cells.emplace_back(
        "interface", std::vector<std::int32_t>(realization.interface.begin(), realization.interface.end()));
  if (!realization.pre_crack.empty()) {
    std::vector<std::int32_t> crack;
    for (const std::int32_t code : realization.pre_crack)
      crack.push_back(code == 0 ? -1 : geometry::PreCrackCut::from(code).crack);
    fields.of_cells.emplace_back("pre_crack", std::move(crack));
  }
  write_grid(file, realization.nodes, realization.tetrahedra, vtk_tetra, fields, [&](hid_t root) {
    write_specimen(root, body);
    write_regions(root, body, mesh);
  });
}

void write_vtk_dual_surface(const std::filesystem::path& file, const geometry::DualSurface& surface) {
  write_grid(file, surface.points, surface.quadrilaterals, vtk_quad,
             {{}, {{"tetrahedron", surface.tetrahedron}}});
}

}  // namespace crackle::io
