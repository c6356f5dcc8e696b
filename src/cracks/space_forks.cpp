// SPDX-License-Identifier: GPL-3.0-or-later
#include "cracks/space_forks.h"

#include "common/disjoint_sets.h"
#include "common/index.h"
#include "common/median.h"
#include "common/real.h"
#include "common/vector.h"
#include "fracture/release.h"
#include "geometry/dual_facets.h"
#include "geometry/pre_crack.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <functional>
#include <map>
#include <numbers>
#include <set>
#include <span>
#include <tuple>
#include <unordered_set>
#include <utility>

namespace crackle::cracks {

namespace {

using geometry::dual_facet_nodes;
using geometry::Point;
using geometry::Realization;

// In local spacings, unless they are shares.
constexpr double radius_of_balls = 4.5;
constexpr double distance_of_balls = 2.5;  // at most; at least half of it
constexpr double least_share = 0.04;       // of a ball's nodes, in a piece
constexpr std::size_t least_nodes = 5;     // likewise
constexpr double least_opened = 0.5;       // of the edges of a node that joins nothing
constexpr double line_radius = 1.8;        // of the part of a ball in which its pieces meet
constexpr double line_width = 1;           // of what belongs to several sheets
constexpr double line_gap = 2;             // between the lines of balls that show one fork
constexpr std::size_t least_edges = 6;     // of a sheet
constexpr double clear_course = 0.2;       // see course()
constexpr std::size_t least_balls = 2;     // that show a fork

constexpr double never = infinity;

/// Lists of numbers, one for each of n owners.
template <class Entry>
class Lists {
public:
  Lists() = default;
  /// @param visit calls its argument with (owner, entry) for all entries, twice the same
  template <class Visit>
  Lists(std::size_t n, const Visit& visit) : first_(n + 1, 0) {
    visit([&](auto owner, const Entry&) { ++first_[index(owner) + 1]; });
    for (std::size_t i = 0; i < n; ++i) first_[i + 1] += first_[i];
    entries_.resize(first_[n]);
    std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
    visit([&](auto owner, const Entry& entry) { entries_[next[index(owner)]++] = entry; });
  }
  std::span<const Entry> operator[](std::integral auto owner) const {
    return {entries_.data() + first_[index(owner)], entries_.data() + first_[index(owner) + 1]};
  }

private:
  std::vector<std::size_t> first_;
  std::vector<Entry> entries_;
};

struct Edge {
  std::int32_t a, b;    ///< nodes, a < b
  double time = never;  ///< when the first of its dual facets opened; -never for those of pre-cracks
};

struct Neighbour {
  std::int32_t node, edge;
};

struct Centre {
  Point place;
  double spacing;  ///< of the mesh there
  std::int32_t node;
  std::int32_t crack;
};

/// The mesh around the cracks as a graph of nodes and edges, with their own numbers.
class CutMesh {
public:
  CutMesh(const Realization& mesh, const CrackSurface& surface) {
    number_nodes(mesh, surface);
    add_edges(mesh);
    open_edges(mesh, surface);
    std::vector<char> joins;
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const auto opened =
          std::ranges::count_if(at_[i], [&](const Neighbour& next) { return time(next.edge) != never; });
      joins.push_back(static_cast<double>(opened) < least_opened * static_cast<double>(at_[i].size()) ? 1
                                                                                                      : 0);
    }
    links_ = Lists<std::int32_t>(places_.size(), [&](const auto& add) {
      for (const Edge& edge : edges_) {
        if (edge.time != never || joins[index(edge.a)] == 0 || joins[index(edge.b)] == 0) continue;
        add(edge.a, edge.b);
        add(edge.b, edge.a);
      }
    });
    choose_centres(mesh, surface);
  }

  std::size_t n_nodes() const { return places_.size(); }
  const Point& place(std::int32_t node) const { return places_[index(node)]; }
  std::size_t n_edges() const { return edges_.size(); }
  double time(std::int32_t edge) const { return edges_[index(edge)].time; }
  Point middle(std::int32_t edge) const {
    return (place(edges_[index(edge)].a) + place(edges_[index(edge)].b)) / 2;
  }
  std::span<const Neighbour> at(std::int32_t node) const { return at_[node]; }
  /// The nodes that a node is joined with.
  std::span<const std::int32_t> links(std::int32_t node) const { return links_[node]; }
  const std::vector<Centre>& centres() const { return centres_; }
  /// Calls visit(edge) for the opened edges of the broken tetrahedra at an edge.
  void for_next(std::int32_t edge, const auto& visit) const {
    for (const std::int32_t broken : broken_at_[edge])
      for (const std::int32_t next : opened_in_[broken]) visit(next);
  }

private:
  static double mean_edge(const Realization& mesh, std::int64_t tetrahedron) {
    const auto& nodes = mesh.tetrahedra[index(tetrahedron)];
    double sum = 0;
    for (const auto& [a, b] : dual_facet_nodes)
      sum += norm(mesh.nodes[index(nodes[a])] - mesh.nodes[index(nodes[b])]);
    return sum / 6;
  }

  /// Takes the nodes in and next to the cells of a grid in which something broke.
  void number_nodes(const Realization& mesh, const CrackSurface& surface) {
    double longest = 0;
    for (const CrackFacet& facet : surface.facets)
      longest = std::max(longest, mean_edge(mesh, facet.tetrahedron));
    const double size = 1.3 * radius_of_balls * longest;
    const auto cell = [&](const Point& p, const std::array<int, 3>& step) {
      std::uint64_t code = 0;
      for (std::size_t i = 0; i < 3; ++i)
        code = code << 21 | (static_cast<std::uint64_t>(std::llround(p[i] / size) + step[i]) & 0x1fffff);
      return code;
    };
    std::unordered_set<std::uint64_t> broken, near;
    for (const CrackFacet& facet : surface.facets) {
      if (!broken.insert(cell(facet.corner[2], {})).second) continue;
      for (int i = 0; i < 27; ++i) near.insert(cell(facet.corner[2], {i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1}));
    }
    number_.assign(mesh.nodes.size(), -1);
    for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
      if (!near.contains(cell(mesh.nodes[i], {}))) continue;
      number_[i] = static_cast<std::int32_t>(places_.size());
      places_.push_back(mesh.nodes[i]);
    }
  }

  void add_edges(const Realization& mesh) {
    std::vector<std::vector<std::int32_t>> above(places_.size());
    for (const auto& nodes : mesh.tetrahedra) {
      for (const auto& [i, j] : dual_facet_nodes) {
        const auto [a, b] = std::minmax(number_[index(nodes[i])], number_[index(nodes[j])]);
        if (a < 0) continue;
        auto& list = above[index(a)];
        if (std::ranges::find(list, b) == list.end()) list.push_back(b);
      }
    }
    for (std::size_t a = 0; a < above.size(); ++a)
      for (const std::int32_t b : above[a]) edges_.push_back({static_cast<std::int32_t>(a), b});
    at_ = Lists<Neighbour>(places_.size(), [&](const auto& add) {
      for (std::size_t e = 0; e < edges_.size(); ++e) {
        add(edges_[e].a, {edges_[e].b, static_cast<std::int32_t>(e)});
        add(edges_[e].b, {edges_[e].a, static_cast<std::int32_t>(e)});
      }
    });
  }

  /// The edge between two nodes of the mesh that have numbers.
  std::int32_t edge_between(std::int32_t one, std::int32_t other) const {
    return std::ranges::find(at(number_[index(one)]), number_[index(other)], &Neighbour::node)->edge;
  }

  void open_edges(const Realization& mesh, const CrackSurface& surface) {
    std::vector<std::pair<std::int32_t, std::int32_t>> opened;  // broken tetrahedron, edge
    std::int32_t n_broken = 0;
    for (std::size_t i = 0; i < surface.facets.size(); ++i) {
      const CrackFacet& facet = surface.facets[i];
      if (i > 0 && facet.tetrahedron != surface.facets[i - 1].tetrahedron) ++n_broken;
      const auto& nodes = mesh.tetrahedra[index(facet.tetrahedron)];
      // A facet's first corner is the middle of the edge that it cuts.
      const auto& [a, b] = *std::ranges::min_element(dual_facet_nodes, {}, [&](const auto& pair) {
        const Point middle = (mesh.nodes[index(nodes[pair[0]])] + mesh.nodes[index(nodes[pair[1]])]) / 2;
        return norm(middle - facet.corner[0]);
      });
      const std::int32_t edge = edge_between(nodes[a], nodes[b]);
      edges_[index(edge)].time = std::min(edges_[index(edge)].time, facet.time);
      opened.emplace_back(n_broken, edge);
    }
    for (std::size_t t = 0; t < mesh.pre_crack.size(); ++t) {
      if (mesh.pre_crack[t] == 0) continue;
      const auto crossed = fracture::crossed_edges(geometry::PreCrackCut::from(mesh.pre_crack[t]).cut);
      const auto& nodes = mesh.tetrahedra[t];
      for (std::size_t k = 0; k < dual_facet_nodes.size(); ++k) {
        const auto& [a, b] = dual_facet_nodes[k];
        if (((crossed >> k) & 1U) != 0 && std::min(number_[index(nodes[a])], number_[index(nodes[b])]) >= 0)
          edges_[index(edge_between(nodes[a], nodes[b]))].time = -never;
      }
    }
    opened_in_ = Lists<std::int32_t>(index(n_broken) + 1, [&](const auto& add) {
      for (const auto& [broken, edge] : opened) add(broken, edge);
    });
    broken_at_ = Lists<std::int32_t>(edges_.size(), [&](const auto& add) {
      for (const auto& [broken, edge] : opened) add(edge, broken);
    });
  }

  double spacing(std::int32_t node) const {
    double sum = 0;
    for (const Neighbour& next : at(node)) sum += norm(place(next.node) - place(node));
    return sum / static_cast<double>(at(node).size());
  }

  /// Takes the tetrahedron that broke first in each cell of grids that suit the spacing.
  void choose_centres(const Realization& mesh, const CrackSurface& surface) {
    std::set<std::tuple<int, std::int64_t, std::int64_t, std::int64_t>> taken;
    std::int64_t last = -1;
    for (const CrackFacet& facet : surface.facets) {
      if (std::exchange(last, facet.tetrahedron) == facet.tetrahedron) continue;
      const auto& nodes = mesh.tetrahedra[index(facet.tetrahedron)];
      const Point& p = facet.corner[2];
      double h = 0;
      for (const auto node : nodes) h += spacing(number_[index(node)]) / 4;
      const auto cell = [&](int level) {
        const auto along = [&](double x) {
          return std::llround(std::floor(x / (distance_of_balls * std::ldexp(1.0, level))));
        };
        return std::tuple(level, along(p[0]), along(p[1]), along(p[2]));
      };
      const int level = std::ilogb(h);
      if (taken.contains(cell(level - 1)) || taken.contains(cell(level + 1)) ||
          !taken.insert(cell(level)).second)
        continue;
      centres_.push_back({p, h, number_[index(nodes[0])], facet.crack});
    }
  }

  std::vector<std::int32_t> number_;  ///< of each node of the mesh, or -1
  std::vector<Point> places_;
  std::vector<Edge> edges_;
  Lists<Neighbour> at_;
  Lists<std::int32_t> links_, opened_in_, broken_at_;
  std::vector<Centre> centres_;
};

/// The opened edges between two pieces of a ball.
struct Sheet {
  std::vector<std::int32_t> edges;
  std::vector<double> distance;  ///< of their middles from the line
  Vector direction{};            ///< in which it leaves the line, of any length
  double time = 0;               ///< median [s]
  bool is_branch = false;
};

/// A fork or a junction as one ball shows it.
struct Sight {
  std::size_t centre;
  std::vector<std::int32_t> line;  ///< nodes at which the pieces meet
  Point place{};                   ///< their mean
  std::vector<Sheet> sheets;
  bool is_fork = false;  ///< otherwise two sheets arrive
  double angle = 0, time = 0;
};

class Balls {
public:
  explicit Balls(const CutMesh& mesh) : mesh_(mesh), local_(mesh.n_nodes(), -1) {}

  /// True if the ball around a centre shows a fork or a junction.
  bool look(const Centre& centre, Sight& sight) {
    gather(centre);
    const bool has_several = cut(centre) >= 3 && find_line(centre, sight) && find_sheets(centre, sight);
    for (const std::int32_t node : members_) local_[index(node)] = -1;
    return has_several;
  }

private:
  void gather(const Centre& centre) {
    const double radius = radius_of_balls * centre.spacing;
    members_.clear();
    distance_.clear();
    const auto add = [&](std::int32_t node) {
      if (local_[index(node)] >= 0) return;
      const Vector offset = mesh_.place(node) - centre.place;
      const double squared = dot(offset, offset);
      if (squared > radius * radius) return;
      local_[index(node)] = static_cast<std::int32_t>(members_.size());
      members_.push_back(node);
      distance_.push_back(std::sqrt(squared));
    };
    add(centre.node);
    for (std::size_t i = 0; i < members_.size(); ++i)
      for (const Neighbour& next : mesh_.at(members_[i])) add(next.node);
  }

  /// Labels the nodes by the pieces that count, others by the nearest of these.
  /// @return their number
  int cut(const Centre& centre) {
    const std::size_t n = members_.size();
    label_.assign(n, -1);
    const double border = (radius_of_balls - 1) * centre.spacing;
    int n_pieces = 0;
    std::vector<std::size_t> piece, labelled;
    std::vector<char> is_seen(n, 0);
    for (std::size_t i = 0; i < n; ++i) {
      if (is_seen[i] != 0) continue;
      piece.assign(1, i);
      is_seen[i] = 1;
      bool reaches_border = false;
      for (std::size_t k = 0; k < piece.size(); ++k) {
        reaches_border = reaches_border || distance_[piece[k]] > border;
        for (const std::int32_t next : mesh_.links(members_[piece[k]])) {
          const std::int32_t j = local_[index(next)];
          if (j < 0 || is_seen[index(j)] != 0) continue;
          is_seen[index(j)] = 1;
          piece.push_back(index(j));
        }
      }
      if (!reaches_border || piece.size() < least_nodes ||
          static_cast<double>(piece.size()) < least_share * static_cast<double>(n))
        continue;
      for (const std::size_t k : piece) label_[k] = n_pieces;
      labelled.insert(labelled.end(), piece.begin(), piece.end());
      ++n_pieces;
    }
    if (n_pieces < 3) return n_pieces;
    for (std::size_t k = 0; k < labelled.size(); ++k)
      for (const Neighbour& next : mesh_.at(members_[labelled[k]])) {
        const std::int32_t j = local_[index(next.node)];
        if (j < 0 || label_[index(j)] >= 0) continue;
        label_[index(j)] = label_[labelled[k]];
        labelled.push_back(index(j));
      }
    return n_pieces;
  }

  /// The nodes that have three pieces at or next to them.
  bool find_line(const Centre& centre, Sight& sight) {
    line_.clear();
    sight.line.clear();
    sight.place = {};
    for (std::size_t i = 0; i < members_.size(); ++i) {
      std::uint32_t pieces = std::uint32_t{1} << label_[i];
      for (const Neighbour& next : mesh_.at(members_[i]))
        if (const std::int32_t j = local_[index(next.node)]; j >= 0)
          pieces |= std::uint32_t{1} << label_[index(j)];
      if (std::popcount(pieces) < 3) continue;
      line_.push_back(members_[i]);
      if (distance_[i] > line_radius * centre.spacing) continue;
      sight.line.push_back(members_[i]);
      sight.place = sight.place + mesh_.place(members_[i]);
    }
    if (sight.line.empty()) return false;
    sight.place = sight.place / static_cast<double>(sight.line.size());
    return true;
  }

  bool find_sheets(const Centre& centre, Sight& sight) const {
    std::map<std::pair<int, int>, Sheet> between;
    for (std::size_t i = 0; i < members_.size(); ++i)
      for (const Neighbour& next : mesh_.at(members_[i])) {
        const std::int32_t j = local_[index(next.node)];
        if (j <= static_cast<std::int32_t>(i) || label_[i] == label_[index(j)] ||
            mesh_.time(next.edge) == never)
          continue;
        const Point middle = mesh_.middle(next.edge);
        double nearest = never;
        for (const std::int32_t node : line_) nearest = std::min(nearest, norm(middle - mesh_.place(node)));
        if (nearest < line_width * centre.spacing) continue;
        Sheet& sheet = between[std::minmax(label_[i], label_[index(j)])];
        sheet.edges.push_back(next.edge);
        sheet.distance.push_back(nearest);
        sheet.direction = sheet.direction + nearest * (middle - sight.place);
      }
    sight.sheets.clear();
    int n_arriving = 0, n_leaving = 0;
    double arrival = -never, departure = never;
    for (auto& [pieces, sheet] : between) {
      if (sheet.edges.size() < least_edges) continue;
      std::vector<double> times;
      for (const std::int32_t edge : sheet.edges) times.push_back(mesh_.time(edge));
      sheet.time = median(std::move(times));
      const double along = course(sheet);
      if (sheet.time == -never || along < -clear_course) {
        ++n_arriving;
        arrival = std::max(arrival, sheet.time);
      } else {
        sheet.is_branch = true;
        n_leaving += along > clear_course ? 1 : 0;
        departure = std::min(departure, sheet.time);
      }
      sight.sheets.push_back(std::move(sheet));
    }
    const auto n_branches = std::ranges::count_if(sight.sheets, &Sheet::is_branch);
    sight.is_fork = n_arriving == 0   ? n_branches > 2 && n_leaving > 1
                    : n_arriving == 1 ? n_branches > 1 && arrival < departure
                                      : n_leaving > n_arriving;
    if (sight.is_fork) measure(sight);
    return sight.is_fork || n_arriving > 1;
  }

  /// From 1, where all edges opened the later the farther they are from the line, to -1.
  double course(const Sheet& sheet) const {
    double sum = 0, all = 0;
    for (std::size_t i = 0; i < sheet.edges.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const double one = mesh_.time(sheet.edges[i]), other = mesh_.time(sheet.edges[j]);
        if (one == other) continue;
        const double farther = sheet.distance[i] - sheet.distance[j];
        all += std::abs(farther);
        sum += one > other ? farther : -farther;
      }
    return all > 0 ? sum / all : 0;
  }

  /// Unit normal of the plane that fits a sheet best.
  Eigen::Vector3d normal(const Sheet& sheet) const {
    // Sums of a fixed order, unlike those of products of large matrices.
    const auto place = [&](std::int32_t edge) { return Eigen::Vector3d(mesh_.middle(edge).data()); };
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const std::int32_t edge : sheet.edges) mean += place(edge) / static_cast<double>(sheet.edges.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const std::int32_t edge : sheet.edges)
      spread += (place(edge) - mean) * (place(edge) - mean).transpose();
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  }

  /// Measures the two branches with the least angle between their planes, on the side to which they leave.
  void measure(Sight& sight) const {
    sight.angle = never;
    std::vector<std::pair<const Sheet*, Eigen::Vector3d>> branches;
    for (const Sheet& sheet : sight.sheets) {
      if (!sheet.is_branch) continue;
      const Eigen::Vector3d across = normal(sheet);
      for (const auto& [other, across_other] : branches) {
        const double acute = std::acos(std::min(1.0, std::abs(across.dot(across_other))));
        const double angle = dot(sheet.direction, other->direction) > 0 ? acute : std::numbers::pi - acute;
        if (angle >= sight.angle) continue;
        sight.angle = angle;
        sight.time = std::max(sheet.time, other->time);
      }
      branches.emplace_back(&sheet, across);
    }
  }

  const CutMesh& mesh_;
  std::vector<std::int32_t> members_;  ///< nodes of the ball
  std::vector<std::int32_t> local_;    ///< index of each node among them, or -1
  std::vector<double> distance_;       ///< of each from the centre
  std::vector<int> label_;             ///< of each
  std::vector<std::int32_t> line_;     ///< nodes of the whole ball at which its pieces meet
};

/// The sights of each fork, in the order of their first; there are more than of a junction there.
std::vector<std::vector<const Sight*>> join(const CutMesh& mesh, const std::vector<Sight>& sights) {
  const auto meet = [&](const Sight& one, const Sight& other) {
    const double spacing = mesh.centres()[one.centre].spacing;
    if (norm(one.place - other.place) > (line_gap + 2 * line_radius) * spacing) return false;
    return std::ranges::any_of(one.line, [&](std::int32_t a) {
      return std::ranges::any_of(other.line, [&](std::int32_t b) {
        return norm(mesh.place(a) - mesh.place(b)) <= line_gap * spacing;
      });
    });
  };
  DisjointSets same(sights.size());
  for (std::size_t i = 0; i < sights.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (meet(sights[i], sights[j])) same.join(i, j);
  std::map<std::size_t, std::vector<const Sight*>> forks;
  for (std::size_t i = 0; i < sights.size(); ++i) forks[same.smallest(i)].push_back(&sights[i]);
  std::vector<std::vector<const Sight*>> ordered;
  for (auto& [first, members] : forks) {
    const auto n_junctions = std::erase_if(members, [](const Sight* one) { return !one->is_fork; });
    if (members.size() >= std::max(least_balls, n_junctions + 1)) ordered.push_back(std::move(members));
  }
  return ordered;
}

/// Follows the sheets of a fork beyond the ball.
class Extents {
public:
  explicit Extents(const CutMesh& mesh) : mesh_(mesh), owner_(mesh.n_edges(), -1) {}

  /// Distance of the end of the second longest branch from the fork; each opened edge belongs to the sheet
  /// from which the fewest tetrahedra lead to it.
  double second(const Sight& sight) {
    std::vector<std::int32_t> reached;
    for (std::size_t s = 0; s < sight.sheets.size(); ++s)
      for (const std::int32_t edge : sight.sheets[s].edges) {
        owner_[index(edge)] = static_cast<std::int32_t>(s);
        reached.push_back(edge);
      }
    std::vector<double> extent(sight.sheets.size(), 0);
    for (std::size_t k = 0; k < reached.size(); ++k) {
      const std::int32_t owner = owner_[index(reached[k])];
      if (sight.sheets[index(owner)].is_branch)
        extent[index(owner)] = std::max(extent[index(owner)], norm(mesh_.middle(reached[k]) - sight.place));
      mesh_.for_next(reached[k], [&](std::int32_t next) {
        if (owner_[index(next)] >= 0) return;
        owner_[index(next)] = owner;
        reached.push_back(next);
      });
    }
    for (const std::int32_t edge : reached) owner_[index(edge)] = -1;
    std::ranges::nth_element(extent, extent.begin() + 1, std::greater<>());
    return extent[1];
  }

private:
  const CutMesh& mesh_;
  std::vector<std::int32_t> owner_;  ///< sheet of each edge, or -1
};

}  // namespace

std::vector<BranchingPoint> find_forks(const Realization& realization, const CrackSurface& surface) {
  std::vector<BranchingPoint> points;
  if (surface.facets.empty()) return points;
  const CutMesh mesh(realization, surface);
  Balls balls(mesh);
  std::vector<Sight> sights;
  Sight sight;
  for (std::size_t i = 0; i < mesh.centres().size(); ++i) {
    sight.centre = i;
    if (balls.look(mesh.centres()[i], sight)) sights.push_back(sight);
  }
  Extents extents(mesh);
  for (const auto& members : join(mesh, sights)) {
    std::vector<double> angles, times;
    std::set<std::int32_t> line;
    for (const Sight* one : members) {
      angles.push_back(one->angle);
      times.push_back(one->time);
      line.insert(one->line.begin(), one->line.end());
    }
    Point place{};
    for (const std::int32_t node : line) place = place + mesh.place(node) / static_cast<double>(line.size());
    const Sight& middle =
        **std::ranges::min_element(members, {}, [&](const Sight* one) { return norm(one->place - place); });
    const Centre& centre = mesh.centres()[middle.centre];
    const double length = extents.second(middle);
    if (length < min_branch_length * centre.spacing) continue;
    points.push_back({surface.cracks[index(centre.crack)].start, -1, place[0], place[1], place[2],
                      median(std::move(times)), length, median(std::move(angles)), not_a_number, false,
                      true});
  }
  return points;
}

}  // namespace crackle::cracks
