// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/section_crossings.h"
#include "geometry/body.h"

#include "projection.h"

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::cracks {

/// The projection of an open facet along the crack advance: a segment through the thickness (x) and across.
struct Trace {
  double x[2];       ///< ends, x[0] <= x[1] [m]
  double across[2];  ///< at these ends [m]
  double spacing;    ///< local mesh spacing [m]
  double time;       ///< [s]
  std::size_t facet;
};

/// Indices in ascending order, each once.
using Indices = std::vector<std::size_t>;

void sort_unique(Indices& numbers);
bool intersects(const Indices& a, const Indices& b);
void add(Indices& to, const Indices& from);

/// The facets of cracks that belong to this crack start, in order of breaking; -1 for cracks that started
/// elsewhere.
Indices facets_from(const CrackSurface& surface, std::int32_t start);

/// Those of cracks that touched this start first (Crack::origin).
Indices facets_begun_at(const CrackSurface& surface, std::int32_t start);

/// The facets of each branch, ascending; see CrackBranches.
std::map<std::int32_t, Indices> by_branch(std::span<const std::size_t> facets, const CrackBranches& branches);

/// Mean local spacing of facets [m]; 0 without facets.
double mean_spacing(const CrackSurface& surface, std::span<const std::size_t> facets);

/// Where a plane passes a side of a facet.
struct Passage {
  std::size_t from, to;  ///< corners of the side
  double share;          ///< of the side, from the first corner
};

/// The two passages of the plane dot(p, normal) = position through a facet; empty if it misses the facet.
std::optional<std::array<Passage, 2>> passages(const CrackFacet& facet, const Vector& normal,
                                               double position);

/// Segments in which facets intersect the plane, by its coordinate across; also beyond the plane's ends.
std::vector<Trace> intersect(const CrackSurface& surface, std::span<const std::size_t> facets,
                             const geometry::CrossPlane& plane);

/// Separate groups of traces (see section_crossings), excluding those that cover less than
/// min_thickness_share of the thickness; each ascending, groups ordered by their first member.
std::vector<std::vector<std::size_t>> group(std::span<const Trace> traces, double thickness);

/// Smallest and largest advance of a facet's corners [m].
std::pair<double, double> advances(const CrackFacet& facet, const geometry::CrackStart& start);

/// The crossing of a plane by a crack, projected through the thickness.
struct Crossing {
  double mean;    ///< over the covered x, of the mean of the traces at equal x [m]
  double spread;  ///< standard deviation of that mean over the covered x [m]
  double time;    ///< at which the first facet of its group opened [s]
  /// Mean over the covered x of the first opening time; if part of it opened in the last dynamic phase,
  /// earlier openings count as at its start [s].
  double arrival;
  std::vector<BranchCrossing> branches;  ///< all separate crossings, ascending
};

/// The main crossing (see section_crossings); empty if no group counts.
/// @param branch of each facet; if empty, all belong to the main branch
/// @param plane crossings beyond its ends do not count
std::optional<Crossing> main_crossing(std::span<const Trace> traces, double thickness,
                                      std::span<const std::int32_t> branch = {},
                                      const geometry::CrossPlane* plane = nullptr);

/// The facets of a crack without a gap between them at one level, such as in one slab across its advance.
struct Piece {
  Indices facets;
  double low = 0, high = 0;  ///< extent across [m]
  Indices next;              ///< connected pieces of the next level
};

/// Pieces of a crack that follow one another.
struct PathLink {
  std::size_t level;
  Indices facets;
};
using Path = std::vector<PathLink>;

/// A crack as a graph: its pieces at levels along a line, each connected to pieces of the next level.
class CrackGraph {
public:
  /// Pieces through the thickness in slabs across a line, from its tip on. In a slab, facets form pieces as
  /// in section_crossings; pieces of neighbouring slabs are connected if they share a facet.
  /// @param spacing thickness of a slab [m]
  CrackGraph(const Projection& projection, const CrackSurface& surface, std::span<const std::size_t> facets,
             const geometry::CrackStart& line, double spacing);
  /// Pieces as seen at stations: the facets between two planes through the thickness at a station and those
  /// beside it, without a gap of branch_gap across. Pieces that overlap across are connected.
  /// @param spacing local mesh spacing at every station [m]
  /// @param traces of the crack at every station
  CrackGraph(std::span<const double> spacing, const std::vector<std::vector<Trace>>& traces, double x_low,
             double x_high);

  std::size_t n_levels() const { return levels_.size(); }
  const std::vector<Piece>& at(std::size_t level) const { return levels_[level]; }
  /// The pieces of the next level that are connected to one of these.
  Indices ahead(std::size_t level, const Indices& pieces) const;

  /// The longest path; among equals the one nearest to the first level.
  /// @param from_first start at the first level that has pieces
  Path longest_path(bool from_first) const;

private:
  void connect(const auto& are_connected);

  std::vector<std::vector<Piece>> levels_;
};

}  // namespace crackle::cracks
