// SPDX-License-Identifier: GPL-3.0-or-later
// The table of one realization.
#include "crackle/common/quantity_text.h"
#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/stable_step.h"
#include "crackle/geometry/mesh_statistics.h"
#include "crackle/geometry/partition.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/geometry/symmetry.h"

#include "mesh_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>
#include <vector>

namespace crackle::apps {

namespace {

std::string spread(const geometry::Quantiles& q, double unit, int digits) {
  return fmt::format("min {:.{}f}, 1 % {:.{}f}, median {:.{}f}, max {:.{}f}", q.smallest / unit, digits,
                     q.one_percent / unit, digits, q.median / unit, digits, q.largest / unit, digits);
}

std::string symmetry_text(const input::Specimen& specimen, std::uint8_t symmetry) {
  if (symmetry == 0) return "none";
  return geometry::symmetry_of(*geometry::make_body(specimen), symmetry).name;
}

void add_partition(std::vector<NamedValue>& table, const geometry::Realization& realization, int n_ranks) {
  const Stopwatch clock;
  const geometry::Partition parts = geometry::partition(realization, n_ranks);
  const std::vector<geometry::Subdomain> subdomains = geometry::split(realization, parts);
  const double seconds = clock.seconds();
  std::int64_t n_computed = 0;
  std::int64_t n_ghosts = 0;
  for (const geometry::Subdomain& part : subdomains) {
    n_computed += part.n_tetrahedra();
    n_ghosts = std::max<std::int64_t>(n_ghosts, part.n_local() - part.layout.n_owned);
  }
  const auto n_tetrahedra = static_cast<double>(realization.tetrahedra.size());
  table.emplace_back(
      "partition",
      fmt::format("{} ranks: edge cut {} faces, imbalance {:.2f} %, {:.2f} % of the tetrahedra "
                  "computed twice or more, at most {} ghost nodes; {:.2f} s",
                  n_ranks, geometry::edge_cut(realization, parts), 100 * (parts.imbalance - 1),
                  100 * (static_cast<double>(n_computed) / n_tetrahedra - 1), n_ghosts, seconds));
}

}  // namespace

std::vector<NamedValue> mesh_table(const input::Parameters& parameters, std::uint64_t sample,
                                   const geometry::MotherPoints& base,
                                   const geometry::Realization& realization, const MeshTimes& times,
                                   int n_ranks) {
  const geometry::MeshStatistics statistics = geometry::mesh_statistics(realization);
  const double degree = std::numbers::pi / 180;
  std::vector<NamedValue> table;
  table.emplace_back("sample", fmt::format("{} of seed {}", sample, parameters.ensemble.seed));
  table.emplace_back("nodes", fmt::format("{}", realization.nodes.size()));
  table.emplace_back("tetrahedra", fmt::format("{}", realization.tetrahedra.size()));
  table.emplace_back("edges", fmt::format("{}", statistics.n_edges));
  table.emplace_back("boundary triangles", fmt::format("{}", realization.boundary.size()));
  const auto materials = material_rows(parameters, realization);
  table.insert(table.end(), materials.begin(), materials.end());
  const auto of_length = [](const geometry::Quantiles& lengths) {
    const ShownUnit unit = shown_unit({"mm", 1e3}, "m", lengths.largest);
    return spread(lengths, 1 / unit.factor, 3) + " " + unit.name;
  };
  table.emplace_back("spacing", of_length(geometry::quantiles(base.spacing)));
  table.emplace_back("edge length", of_length(statistics.edge_length));
  table.emplace_back("quality", spread(statistics.quality, 1, 4));
  table.emplace_back("dihedral angles",
                     fmt::format("{:.1f} to {:.1f} degrees", statistics.smallest_angle / degree,
                                 statistics.largest_angle / degree));
  table.emplace_back("stable step", quantity_text(dynamics::stable_step(parameters, realization), "s"));
  table.emplace_back("redrawn points",
                     fmt::format("{} ({:.2f} %) in {} rounds", realization.report.redrawn_points,
                                 100 * static_cast<double>(realization.report.redrawn_points) /
                                     static_cast<double>(realization.nodes.size()),
                                 realization.report.rounds));
  table.emplace_back("symmetry", symmetry_text(parameters.specimen, realization.report.symmetry));
  table.emplace_back("time", fmt::format("{:.2f} s for the realization, {:.2f} s for the base points",
                                         times.realization, times.base));
  if (n_ranks > 1) add_partition(table, realization, n_ranks);
  return table;
}

std::vector<NamedValue> material_rows(const input::Parameters& parameters,
                                      const geometry::Realization& realization) {
  std::vector<NamedValue> rows;
  const auto contents = geometry::material_contents(realization);
  for (std::size_t i = 0; i < contents.size(); ++i)
    rows.emplace_back(
        fmt::format("material {}", parameters.materials[i].name),
        fmt::format("{} tetrahedra, {:.6g} mm^3", contents[i].tetrahedra, 1e9 * contents[i].volume));
  return rows;
}

NamedValue variation_row(const std::vector<double>& strength_factors) {
  return {"strength factor", spread(geometry::quantiles(strength_factors), 1, 3)};
}

}  // namespace crackle::apps
