// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/point.h"

#include <nanoflann.hpp>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace crackle::geometry {

/// A k-d tree over fixed points, for queries by radius.
class PointTree {
public:
  /// Keeps a view of `points`.
  explicit PointTree(std::span<const Point> points) : cloud_{points}, tree_(3, cloud_) {}

  /// Sets `found` to the numbers of the points closer than `radius` to p, ascending.
  void find(const Point& p, double radius, std::vector<std::int32_t>& found) const {
    found.clear();
    Closer closer{radius * radius, found};
    tree_.findNeighbors(closer, p.data(), {});
    std::sort(found.begin(), found.end());
  }

private:
  struct Cloud {
    std::span<const Point> points;
    std::size_t kdtree_get_point_count() const { return points.size(); }
    double kdtree_get_pt(std::size_t i, std::size_t axis) const { return points[i][axis]; }
    bool kdtree_get_bbox(auto&) const { return false; }
  };

  /// Collects the points whose squared distance is below a limit. The tree rounds the distances of the
  /// branches that it skips, so it searches a little farther.
  struct Closer {
    double limit;
    std::vector<std::int32_t>& found;
    bool addPoint(double distance, std::int32_t i) {
      if (distance < limit) found.push_back(i);
      return true;
    }
    double worstDist() const { return limit * (1 + 1e-9); }
    bool full() const { return true; }
    std::size_t size() const { return found.size(); }
    void sort() const {}
  };

  Cloud cloud_;
  nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3, std::int32_t>
      tree_;
};

}  // namespace crackle::geometry
