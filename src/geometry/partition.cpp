// SPDX-License-Identifier: GPL-3.0-or-later
#include "geometry/partition.h"

#include "common/failure.h"
#include "common/index.h"
#include "geometry/face_neighbours.h"

#include <metis.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace crackle::geometry {

namespace {

void check_metis(int code) {
  if (code == METIS_OK) return;
  const char* const reason = code == METIS_ERROR_INPUT    ? "erroneous input"
                             : code == METIS_ERROR_MEMORY ? "not enough memory"
                                                          : "other error";
  fail("METIS_PartMeshDual: {} ({})", reason, code);
}

std::vector<std::int32_t> metis_parts(const Realization& realization, int n_parts, int seed) {
  const auto& tetrahedra = realization.tetrahedra;
  auto n_elements = static_cast<idx_t>(tetrahedra.size());
  auto n_nodes = static_cast<idx_t>(realization.nodes.size());
  std::vector<idx_t> element_begin(tetrahedra.size() + 1);
  for (std::size_t i = 0; i < tetrahedra.size(); ++i) element_begin[i + 1] = static_cast<idx_t>(4 * (i + 1));
  // METIS does not change the nodes, though it does not say so.
  static_assert(std::is_same_v<idx_t, std::int32_t>);
  auto* const element_nodes = const_cast<idx_t*>(tetrahedra.front().data());
  std::array<idx_t, METIS_NOPTIONS> options{};
  check_metis(METIS_SetDefaultOptions(options.data()));
  options[METIS_OPTION_PTYPE] = METIS_PTYPE_KWAY;
  options[METIS_OPTION_OBJTYPE] = METIS_OBJTYPE_CUT;
  options[METIS_OPTION_SEED] = seed;
  options[METIS_OPTION_UFACTOR] = 10;  // at most 1 % imbalance: the slowest rank sets the pace
  options[METIS_OPTION_NUMBERING] = 0;
  idx_t n_common = 3;
  idx_t n_wanted = n_parts;
  idx_t cut = 0;
  std::vector<idx_t> element_part(tetrahedra.size());
  std::vector<idx_t> node_part(realization.nodes.size());
  check_metis(METIS_PartMeshDual(&n_elements, &n_nodes, element_begin.data(), element_nodes, nullptr, nullptr,
                                 &n_common, &n_wanted, nullptr, options.data(), &cut, element_part.data(),
                                 node_part.data()));
  return element_part;
}

/// Renumbers the parts in the order of their first occurrence.
void renumber(std::vector<std::int32_t>& parts, int n_parts) {
  std::vector<std::int32_t> number(static_cast<std::size_t>(n_parts), -1);
  std::int32_t next = 0;
  for (std::int32_t& part : parts) {
    if (number[index(part)] < 0) number[index(part)] = next++;
    part = number[index(part)];
  }
}

std::vector<std::int32_t> node_parts(const Realization& realization, const Partition& partition) {
  // The parts around each node, in the order of the tetrahedra, each once.
  std::vector<std::vector<std::int32_t>> candidates(realization.nodes.size());
  for (std::size_t i = 0; i < realization.tetrahedra.size(); ++i)
    for (const std::int32_t node : realization.tetrahedra[i]) {
      auto& list = candidates[index(node)];
      const std::int32_t part = partition.tetrahedron_part[i];
      if (std::find(list.begin(), list.end(), part) == list.end()) list.push_back(part);
    }
  std::vector<std::int64_t> n_nodes(static_cast<std::size_t>(partition.n_parts), 0);
  std::vector<std::int32_t> result(realization.nodes.size(), 0);
  for (std::size_t node = 0; node < candidates.size(); ++node) {
    const auto& list = candidates[node];
    if (list.empty()) continue;
    result[node] = *std::min_element(list.begin(), list.end(), [&](std::int32_t a, std::int32_t b) {
      return n_nodes[index(a)] != n_nodes[index(b)] ? n_nodes[index(a)] < n_nodes[index(b)] : a < b;
    });
    ++n_nodes[index(result[node])];
  }
  return result;
}

}  // namespace

Partition partition(const Realization& realization, int n_parts, int seed) {
  if (n_parts < 1) fail<std::invalid_argument>("partition into {} parts", n_parts);
  const std::size_t n_tetrahedra = realization.tetrahedra.size();
  std::vector<std::int32_t> parts(n_tetrahedra, 0);
  if (static_cast<std::size_t>(n_parts) >= n_tetrahedra) {
    std::iota(parts.begin(), parts.end(), 0);
  } else if (n_parts > 1) {
    parts = metis_parts(realization, n_parts, seed);
    renumber(parts, n_parts);
  }
  return partition_of(realization, std::move(parts), n_parts);
}

Partition partition_of(const Realization& realization, std::vector<std::int32_t> tetrahedron_part,
                       int n_parts) {
  Partition result;
  result.n_parts = n_parts;
  result.tetrahedron_part = std::move(tetrahedron_part);
  result.node_part = node_parts(realization, result);
  if (n_parts == 1 || result.tetrahedron_part.empty()) return result;
  std::vector<std::int64_t> size(static_cast<std::size_t>(n_parts), 0);
  for (const std::int32_t part : result.tetrahedron_part) ++size[index(part)];
  result.imbalance = static_cast<double>(*std::max_element(size.begin(), size.end())) * n_parts /
                     static_cast<double>(result.tetrahedron_part.size());
  return result;
}

std::int64_t edge_cut(const Realization& realization, const Partition& partition) {
  const auto& parts = partition.tetrahedron_part;
  const auto neighbours = face_neighbours(realization.tetrahedra);
  std::int64_t n_cut = 0;
  for (std::size_t t = 0; t < parts.size(); ++t)
    for (const auto other : neighbours[t])
      if (other > static_cast<std::int32_t>(t) && parts[index(other)] != parts[t]) ++n_cut;
  return n_cut;
}

}  // namespace crackle::geometry
