// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/subdomain.h"

#include "common/index.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <unordered_map>
#include <utility>

namespace crackle::geometry {

namespace {

/// Finds the parts with tetrahedra near a point.
class Halo {
public:
  /// @param width [m]
  Halo(const Realization& realization, const Partition& partition, double width);

  /// All parts that own the first node of a tetrahedron whose centroid is closer to `place` than the width,
  /// and possibly some less than 2 sqrt(3) widths away; ascending.
  std::span<const std::int32_t> parts_near(const Point& place) const;

private:
  using Cell = std::array<std::int64_t, 3>;
  struct CellHash {
    std::size_t operator()(const Cell& cell) const;
  };
  Cell cell_of(const Point& place) const;

  double width_;
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> near_;  // by cell containing a centroid
};

std::size_t Halo::CellHash::operator()(const Cell& cell) const {
  std::uint64_t hash = 0;
  for (const auto i : cell) hash = (hash ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15U;
  return hash ^ (hash >> 32);
}

Halo::Halo(const Realization& realization, const Partition& partition, double width) : width_(width) {
  std::unordered_map<Cell, std::vector<std::int32_t>, CellHash> inside;
  for (const Tetrahedron& t : realization.tetrahedra) {
    auto& parts = inside[cell_of(centroid(realization.nodes, t))];
    const std::int32_t part = partition.node_part[index(t[0])];
    if (std::ranges::find(parts, part) == parts.end()) parts.push_back(part);
  }
  near_.reserve(inside.size());
  for (const auto& [cell, ignored] : inside) {
    auto& parts = near_[cell];
    for (const std::int64_t i : {-1, 0, 1})
      for (const std::int64_t j : {-1, 0, 1})
        for (const std::int64_t k : {-1, 0, 1}) {
          const auto other = inside.find({cell[0] + i, cell[1] + j, cell[2] + k});
          if (other != inside.end()) parts.insert(parts.end(), other->second.begin(), other->second.end());
        }
    std::ranges::sort(parts);
    parts.erase(std::unique(parts.begin(), parts.end()), parts.end());
  }
}

std::span<const std::int32_t> Halo::parts_near(const Point& place) const {
  return near_.at(cell_of(place));
}

Halo::Cell Halo::cell_of(const Point& place) const {
  Cell cell{};
  for (std::size_t i = 0; i < 3; ++i) cell[i] = static_cast<std::int64_t>(std::floor(place[i] / width_));
  return cell;
}

/// Calls visit(part) once for each part that owns one of the nodes.
template <class Visit>
void for_owning_parts(std::span<const std::int32_t> nodes, const std::vector<std::int32_t>& node_part,
                      const Visit& visit) {
  std::array<std::int32_t, 4> parts{};
  std::size_t n_parts = 0;
  for (const std::int32_t node : nodes) {
    const std::int32_t part = node_part[index(node)];
    const auto end = parts.begin() + static_cast<std::ptrdiff_t>(n_parts);
    if (std::find(parts.begin(), end, part) != end) continue;
    parts[n_parts++] = part;
    visit(part);
  }
}

/// Calls work(of the realization, of the part) for each array of a property of tetrahedra.
template <class Work>
void for_each_property(const Realization& realization, Subdomain& part, const Work& work) {
  work(realization.material, part.material);
  work(realization.interface, part.interface);
  work(realization.map_factor, part.map_factor);
  work(realization.pre_crack, part.pre_crack);
}

/// Makes room for a number of tetrahedra with their properties.
void reserve(Subdomain& part, std::size_t n_tetrahedra, const Realization& realization) {
  part.tetrahedra.reserve(n_tetrahedra);
  part.tetrahedron_number.reserve(n_tetrahedra);
  part.owned.reserve(n_tetrahedra);
  for_each_property(realization, part, [&](const auto& all, auto& own) {
    if (!all.empty()) own.reserve(n_tetrahedra);
  });
}

/// Collects the nodes of a subdomain, whose tetrahedra and triangles still have the realization's node
/// numbers, and converts these to local ones.
/// @param local scratch, -1 for every node of the realization; restored on return
void number_locally(const Realization& realization, std::vector<std::int32_t>& local, Subdomain& subdomain) {
  auto& numbers = subdomain.layout.number;  // the owned nodes so far
  for (std::size_t i = 0; i < numbers.size(); ++i) local[index(numbers[i])] = static_cast<std::int32_t>(i);
  const std::size_t n_owned = numbers.size();
  for (const Tetrahedron& t : subdomain.tetrahedra)
    for (const std::int32_t node : t)
      if (local[index(node)] < 0) {
        local[index(node)] = 0;
        numbers.push_back(node);
      }
  std::sort(numbers.begin() + static_cast<std::ptrdiff_t>(n_owned), numbers.end());
  for (std::size_t i = n_owned; i < numbers.size(); ++i)
    local[index(numbers[i])] = static_cast<std::int32_t>(i);
  for (Tetrahedron& t : subdomain.tetrahedra)
    for (std::int32_t& node : t) node = local[index(node)];
  for (BoundaryTriangle& triangle : subdomain.boundary)
    for (std::int32_t& node : triangle.nodes) node = local[index(node)];
  subdomain.nodes.reserve(numbers.size());
  for (const std::int64_t number : numbers) {
    subdomain.nodes.push_back(realization.nodes[index(number)]);
    local[index(number)] = -1;
  }
}

}  // namespace

std::int32_t Subdomain::local_number(std::int64_t tetrahedron) const {
  const auto place = std::ranges::lower_bound(tetrahedron_number, tetrahedron);
  if (place == tetrahedron_number.end() || *place != tetrahedron) return -1;
  return static_cast<std::int32_t>(place - tetrahedron_number.begin());
}

std::vector<Subdomain> split(const Realization& realization, const Partition& partition, double halo) {
  const auto& node_part = partition.node_part;
  std::vector<Subdomain> parts(index(partition.n_parts));
  for (std::size_t node = 0; node < realization.nodes.size(); ++node)
    parts[index(node_part[node])].layout.number.push_back(static_cast<std::int64_t>(node));
  std::vector<std::int32_t> number_at_owner(realization.nodes.size());
  std::vector<std::int64_t> first_owned{0};
  for (Subdomain& part : parts) {
    part.layout.n_global = static_cast<std::int64_t>(realization.nodes.size());
    part.n_tetrahedra_global = static_cast<std::int64_t>(realization.tetrahedra.size());
    part.layout.n_owned = static_cast<std::int32_t>(part.layout.number.size());
    for (std::int32_t i = 0; i < part.layout.n_owned; ++i)
      number_at_owner[index(part.layout.number[index(i)])] = i;
    first_owned.push_back(first_owned.back() + part.layout.n_owned);
  }

  std::optional<Halo> halos;
  if (halo > 0 && partition.n_parts > 1) halos.emplace(realization, partition, halo);
  const auto for_parts_with_tetrahedra = [&](const auto& visit) {
    std::vector<std::size_t> last(parts.size(), realization.tetrahedra.size());
    for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i) {
      const Tetrahedron& t = realization.tetrahedra[i];
      const auto visit_once = [&](std::int32_t number) {
        if (std::exchange(last[index(number)], i) != i) visit(number, i);
      };
      for_owning_parts(t, node_part, visit_once);
      if (halos) std::ranges::for_each(halos->parts_near(centroid(realization.nodes, t)), visit_once);
    }
  };
  std::vector<std::size_t> n_tetrahedra(parts.size(), 0);
  for_parts_with_tetrahedra([&](std::int32_t number, std::size_t) { ++n_tetrahedra[index(number)]; });
  for (std::size_t number = 0; number < parts.size(); ++number)
    reserve(parts[number], n_tetrahedra[number], realization);
  for_parts_with_tetrahedra([&](std::int32_t number, std::size_t i) {
    Subdomain& part = parts[index(number)];
    part.tetrahedra.push_back(realization.tetrahedra[i]);
    part.tetrahedron_number.push_back(static_cast<std::int64_t>(i));
    part.owned.push_back(number == node_part[index(realization.tetrahedra[i][0])]);
    for_each_property(realization, part, [&](const auto& all, auto& own) {
      if (!all.empty()) own.push_back(all[i]);
    });
  });
  for (std::size_t i = 0; i < realization.boundary.size(); ++i) {
    const BoundaryTriangle& triangle = realization.boundary[i];
    for_owning_parts(triangle.nodes, node_part, [&](std::int32_t number) {
      parts[index(number)].boundary.push_back(triangle);
      parts[index(number)].boundary_number.push_back(static_cast<std::int64_t>(i));
    });
  }

  std::vector<std::int32_t> local(realization.nodes.size(), -1);
  for (Subdomain& part : parts) {
    number_locally(realization, local, part);
    part.pre_crack_normal = realization.pre_crack_normal;
    part.layout.first_owned = first_owned;
    for (std::size_t i = index(part.layout.n_owned); i < part.layout.number.size(); ++i) {
      const std::size_t node = index(part.layout.number[i]);
      part.layout.ghosts.push_back({node_part[node], number_at_owner[node]});
    }
  }
  return parts;
}

}  // namespace crackle::geometry
