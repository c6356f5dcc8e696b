// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/geometry/point.h"

#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace crackle::geometry {

/// The part of a tessellation that fills the body.
struct TessellationContent {
  std::vector<Tetrahedron> tetrahedra;  ///< of the body, positively oriented
  std::vector<Triangle> boundary;       ///< their faces without a neighbour, normal outwards
};

/// The Delaunay tessellation of points of a body, which points can be taken out of and put back into.
///
/// A cell is good when it is no part of the body, or lies in the body with at least the quality that was
/// asked for. Nothing that this class returns depends on the history of the tessellation, only on where the
/// points are, except the order of lists that are documented as unordered.
class Tessellation {
public:
  /// Tessellates all points. Some 4 microseconds for each point.
  /// @param points in the closed body, pairwise different, among them its corners
  Tessellation(const Body& body, std::span<const Point> points, double min_quality);
  ~Tessellation();
  Tessellation(const Tessellation&) = delete;
  Tessellation& operator=(const Tessellation&) = delete;

  void set_min_quality(double min_quality);
  std::span<const Point> points() const;

  /// All cells that are not good: their nodes ascending, the list ascending.
  std::vector<Tetrahedron> bad_cells() const;

  /// True while the four nodes, ascending, are the corners of a cell that is not good.
  bool has_bad_cell(const Tetrahedron& nodes) const;

  /// The nodes that share a cell with `node`, ascending.
  std::vector<std::int32_t> neighbours(std::int32_t node) const;

  /// What the tessellation would be like with the lifted node at some point: among the cells that differ from
  /// those before the node was lifted, the number of bad ones, and the worst quality, as its third power.
  struct Trial {
    int n_bad = std::numeric_limits<int>::max();
    double worst = -1;
    bool better_than(const Trial& other) const {
      return n_bad != other.n_bad ? n_bad < other.n_bad : worst > other.worst;
    }
  };

  /// Takes a node out; the others are tessellated without it. One node at a time; not a corner of the body.
  void lift(std::int32_t node);
  /// @param enough the trial may be cut short as soon as it is known not to be better than this one
  Trial try_at(const Point& p, const Trial& enough) const;
  /// Puts the lifted node in at p. Appends the bad ones of the changed cells to `bad`, unordered.
  void put(const Point& p, std::vector<Tetrahedron>& bad);

  /// The cells of the body, unordered.
  /// @pre bad_cells() is empty, or cells that reach through the surface are counted as cells of the body
  TessellationContent content() const;

private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace crackle::geometry
