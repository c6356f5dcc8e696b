// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/body.h"
#include "geometry/point.h"

#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace crackle::geometry {

/// The part of a tessellation that fills the body.
struct TessellationContent {
  std::vector<Tetrahedron> tetrahedra;  ///< of the body, positively oriented
  std::vector<Triangle> boundary;       ///< their faces without a neighbour, normal outwards
  std::vector<Triangle> inner;          ///< their faces between two materials
};

/// The Delaunay tessellation of points of a body, supporting removal and reinsertion of points.
///
/// A cell is good if it is outside the body, or inside with at least the required quality. Results depend
/// only on the current points, not on the history of the tessellation, except for the order of lists
/// documented as unordered.
class Tessellation {
public:
  /// Tessellates all points, in about 4 microseconds per point.
  /// @param points in the closed body, pairwise different, including its corners
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

  /// The sum over a node's cells of |n|^2 / (9 V), where n is the area vector of the face opposite, over a
  /// quarter of their volume [1/m^2]. Times the squared speed of P waves it bounds the
  /// diagonal block of the node in K / m, and thus tells apart the nodes that need the shortest steps. In
  /// bodies of several materials these would count by their wave speeds, which this ignores.
  double stiffness_over_mass(std::int32_t node) const;
  /// The same of all nodes, up to rounding, in one sweep over the cells.
  std::vector<double> stiffness_over_mass() const;

  /// Evaluation of the lifted node at some point: among the cells that differ from those before it was
  /// lifted, the number of bad ones, and the worst quality, as its third power.
  struct Trial {
    int n_bad = std::numeric_limits<int>::max();
    double worst = -1;
    bool better_than(const Trial& other) const {
      return n_bad != other.n_bad ? n_bad < other.n_bad : worst > other.worst;
    }
  };

  /// Removes a node; the others are tessellated without it. One node at a time; not a corner of the body.
  void lift(std::int32_t node);
  /// @param enough the trial may stop early once it is known not to be better than this one
  Trial try_at(const Point& p, const Trial& enough) const;
  /// stiffness_over_mass of the lifted node at the point of the last trial, if that found no bad cell; up to
  /// rounding.
  double tried_stiffness_over_mass() const;
  /// Inserts the lifted node at p. Appends the bad ones among the changed cells to `bad`, unordered.
  void put(const Point& p, std::vector<Tetrahedron>& bad);

  /// The cells of the body, unordered.
  /// @pre bad_cells() is empty; otherwise cells that cross the surface are included
  TessellationContent content() const;

private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace crackle::geometry
