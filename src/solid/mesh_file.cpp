// SPDX-License-Identifier: GPL-3.0-or-later
// The boundary of volume meshes, or surface meshes, in ASCII files of Gmsh and VTK.
#include "common/failure.h"

#include "facets.h"
#include "words.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <utility>

namespace crackle::solid {

namespace {

/// A type of cells in both formats: the sides of a volume, in any orientation.
struct CellType {
  int gmsh, vtk;
  std::size_t n_nodes;
  std::vector<Polygon> sides;  ///< empty for a surface cell
};

const std::vector<CellType> cell_types{
    {2, 5, 3, {}},
    {3, 9, 4, {}},
    {4, 10, 4, {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}}},
    {5, 12, 8, {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}},
    {6, 13, 6, {{0, 1, 2}, {3, 4, 5}, {0, 1, 4, 3}, {1, 2, 5, 4}, {2, 0, 3, 5}}},
    {7, 14, 5, {{0, 1, 2, 3}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}}};

/// Types of Gmsh without a surface: lines and points, also curved ones. Number of nodes by type.
const std::map<int, std::size_t> other_gmsh_cells{{1, 2}, {8, 3}, {15, 1}, {26, 4}, {27, 5}, {28, 6}};

const CellType* type_of(int CellType::*format, int number) {
  const auto found = std::ranges::find(cell_types, number, format);
  return found == cell_types.end() ? nullptr : &*found;
}

/// Collects cells; surface cells give names to the sides of volumes.
class Cells {
public:
  void add(const CellType& type, const Polygon& nodes, int group) {
    if (type.sides.empty()) {
      surface_.emplace_back(nodes, group);
      return;
    }
    has_volumes_ = true;
    for (const Polygon& side : type.sides) {
      Polygon polygon;
      for (const std::size_t i : side) polygon.push_back(nodes[i]);
      Polygon key = sorted(polygon);
      if (const auto [entry, is_new] = sides_.emplace(std::move(key), std::move(polygon)); !is_new)
        sides_.erase(entry);  // between two cells
    }
  }

  void move_to(Facets& facets) {
    if (!has_volumes_) {
      for (auto& [nodes, group] : surface_) facets.add(std::move(nodes), group);
      return;
    }
    std::map<Polygon, int> groups;
    for (const auto& [nodes, group] : surface_) groups.emplace(sorted(nodes), group);
    for (auto& [key, polygon] : sides_) {
      const auto named = groups.find(key);
      facets.add(std::move(polygon), named == groups.end() ? -1 : named->second);
    }
  }

private:
  static Polygon sorted(Polygon nodes) {
    std::ranges::sort(nodes);
    return nodes;
  }
  bool has_volumes_ = false;
  std::map<Polygon, Polygon> sides_;
  std::vector<std::pair<Polygon, int>> surface_;
};

class GmshReader {
public:
  explicit GmshReader(const std::string& content) : words_(content) {}

  Facets read() {
    for (std::string_view word = words_.next(); !word.empty(); word = words_.next()) {
      if (word == "$MeshFormat") {
        const std::string_view version = words_.next();
        is_new_ = version.starts_with("4.1");
        if (!is_new_ && !version.starts_with("2."))
          fail("has version {} of the format; save version 4.1 or 2.2", version);
        if (words_.number<int>() != 0)
          fail("is binary; save it as ASCII, such as by gmsh FILE -save -o body.msh");
      } else if (word == "$PhysicalNames") {
        for (std::size_t n = words_.count(); n > 0; --n) {
          const int dimension = words_.number<int>(), tag = words_.number<int>();
          std::string name(words_.rest_of_line());
          std::erase(name, '"');
          if (dimension == 2) names_[tag] = name;
        }
      } else if (word == "$Entities") {
        read_entities();
      } else if (word == "$Nodes") {
        is_new_ ? read_node_blocks() : read_nodes(words_.count());
      } else if (word == "$Elements") {
        is_new_ ? read_element_blocks() : read_elements(words_.count());
        has_ended_ = words_.next() == "$EndElements";
      }
    }
    if (!has_ended_) fail("ends too early: \"$EndElements\" is missing");
    cells_.move_to(facets_);
    return std::move(facets_);
  }

private:
  /// The physical group of each surface.
  void read_entities() {
    std::array<std::size_t, 4> n{};
    for (std::size_t& each : n) each = words_.count();
    for (std::size_t dimension = 0; dimension < 4; ++dimension)
      for (std::size_t i = 0; i < n[dimension]; ++i) {
        const int tag = words_.number<int>();
        for (int k = 0; k < (dimension == 0 ? 3 : 6); ++k) words_.number<double>();
        for (std::size_t k = words_.count(); k > 0; --k) {
          const int physical = std::abs(words_.number<int>());
          if (dimension == 2) physical_[tag] = physical;
        }
        if (dimension > 0)
          for (std::size_t k = words_.count(); k > 0; --k) words_.number<int>();
      }
  }

  void add_node(std::size_t tag) {
    numbers_.emplace(tag, facets_.points.size());
    facets_.points.push_back(words_.point());
  }
  void read_nodes(std::size_t n) {
    for (; n > 0; --n) add_node(words_.number<std::size_t>());
  }
  void read_node_blocks() {
    const std::size_t n_blocks = words_.count();
    for (int k = 0; k < 3; ++k) words_.number<std::size_t>();
    for (std::size_t block = 0; block < n_blocks; ++block) {
      for (int k = 0; k < 2; ++k) words_.number<int>();
      if (words_.number<int>() != 0)
        fail("line {}: has nodes with parameters; save them without", words_.line());
      std::vector<std::size_t> tags(words_.count());
      for (std::size_t& tag : tags) tag = words_.number<std::size_t>();
      for (const std::size_t tag : tags) add_node(tag);
    }
  }

  void read_cell(int type, int physical) {
    const CellType* const known = type_of(&CellType::gmsh, type);
    const auto other = other_gmsh_cells.find(type);
    if (known == nullptr && other == other_gmsh_cells.end())
      fail("line {}: has elements of type {}; save linear triangles or tetrahedra", words_.line(), type);
    Polygon nodes(known != nullptr ? known->n_nodes : other->second);
    for (std::size_t& node : nodes) {
      const auto found = numbers_.find(words_.number<std::size_t>());
      if (found == numbers_.end()) fail("line {}: an element has a node that is not there", words_.line());
      node = found->second;
    }
    if (known == nullptr) return;
    const auto name = names_.find(physical);
    cells_.add(*known, nodes,
               physical == 0
                   ? -1
                   : facets_.group_named(name == names_.end() ? "physical-" + std::to_string(physical)
                                                              : name->second));
  }
  void read_elements(std::size_t n) {
    for (; n > 0; --n) {
      words_.number<std::size_t>();
      const int type = words_.number<int>();
      const std::size_t n_tags = words_.count();
      int physical = 0;
      for (std::size_t k = 0; k < n_tags; ++k) {
        const int tag = words_.number<int>();
        if (k == 0) physical = std::abs(tag);
      }
      const CellType* const known = type_of(&CellType::gmsh, type);
      read_cell(type, known != nullptr && known->sides.empty() ? physical : 0);
    }
  }
  void read_element_blocks() {
    const std::size_t n_blocks = words_.count();
    for (int k = 0; k < 3; ++k) words_.number<std::size_t>();
    for (std::size_t block = 0; block < n_blocks; ++block) {
      const int dimension = words_.number<int>(), entity = words_.number<int>(), type = words_.number<int>();
      const int physical = dimension == 2 && physical_.contains(entity) ? physical_.at(entity) : 0;
      for (std::size_t n = words_.count(); n > 0; --n) {
        words_.number<std::size_t>();
        read_cell(type, physical);
      }
    }
  }

  Words words_;
  bool is_new_ = false, has_ended_ = false;
  std::map<int, std::string> names_;
  std::map<int, int> physical_;
  std::map<std::size_t, std::size_t> numbers_;
  Facets facets_;
  Cells cells_;
};

}  // namespace

Facets read_gmsh(const std::string& content) {
  return GmshReader(content).read();
}

Facets read_vtk(const std::string& content) {
  Facets facets;
  Words words(content);
  if (!content.starts_with("# vtk DataFile"))
    fail("is no legacy VTK file; save it as .vtk in ASCII, with ParaView's Save Data or meshio convert");
  const bool is_new = words.rest_of_line().find("5.") != std::string_view::npos;
  words.next();
  words.rest_of_line();  // the title
  if (words.next() != "ASCII")
    fail("is binary; save it as ASCII, with ParaView's Save Data or meshio convert");
  std::vector<Polygon> cells;
  std::vector<int> types;
  for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
    if (word == "POINTS") {
      const std::size_t n = words.count();
      words.next();
      for (std::size_t i = 0; i < n; ++i) facets.points.push_back(words.point());
    } else if (word == "CELLS" || word == "POLYGONS") {
      const bool are_polygons = word == "POLYGONS";
      std::size_t n = words.count();
      const std::size_t size = words.count();
      if (is_new) {
        words.rest_of_line();
        if (words.next() != "OFFSETS") fail("line {}: OFFSETS are missing", words.line());
        words.rest_of_line();
        std::vector<std::size_t> offsets(n);
        for (std::size_t& offset : offsets) offset = words.number<std::size_t>();
        words.next();  // CONNECTIVITY
        words.rest_of_line();
        for (std::size_t i = 0; i + 1 < n; ++i) {
          if (offsets[i + 1] < offsets[i] || offsets[i + 1] > size) fail("has wrong OFFSETS");
          Polygon& cell = cells.emplace_back(offsets[i + 1] - offsets[i]);
          for (std::size_t& node : cell) node = words.number<std::size_t>();
        }
      } else {
        for (; n > 0; --n) {
          Polygon& cell = cells.emplace_back(words.count());
          for (std::size_t& node : cell) node = words.number<std::size_t>();
        }
      }
      if (are_polygons) types.assign(cells.size(), 7);
    } else if (word == "CELL_TYPES") {
      types.clear();
      for (std::size_t n = words.count(); n > 0; --n) types.push_back(words.number<int>());
    } else if (word == "POINT_DATA" || word == "CELL_DATA") {
      break;
    }
  }
  if (types.size() != cells.size())
    fail("ends too early: it has {} cells and {} types", cells.size(), types.size());
  Cells collected;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (const std::size_t node : cells[i])
      if (node >= facets.points.size()) fail("cell {} has a point that is not there", i);
    const CellType* const known = type_of(&CellType::vtk, types[i]);
    const CellType polygon{0, 7, cells[i].size(), {}};
    if (types[i] == 7)
      collected.add(polygon, cells[i], -1);
    else if (known != nullptr && known->n_nodes == cells[i].size())
      collected.add(*known, cells[i], -1);
    else if (types[i] > 4)
      fail("cell {} has type {}; save linear triangles or tetrahedra", i, types[i]);
  }
  collected.move_to(facets);
  return facets;
}

}  // namespace crackle::solid
