// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/geometry/survey.h"

#include "crackle/common/index.h"
#include "crackle/common/stopwatch.h"
#include "crackle/geometry/plain_delaunay.h"
#include "crackle/geometry/symmetry.h"

#include <bit>
#include <stdexcept>

namespace crackle::geometry {

namespace {

constexpr double fine_factor = 2;  ///< largest spacing of the fine zone relative to the notch spacing
constexpr double depth = 2;        ///< minimum distance of the fine zone from the surface, in spacings

std::array<DisplacementSums, 3> displacement_sums(const Body& body, const MotherPoints& base,
                                                  const Realization& realization, double perturbation) {
  std::array<DisplacementSums, 3> sums;
  if (!(perturbation > 0)) return sums;
  const Symmetry symmetry = symmetry_of(body, realization.report.symmetry);
  for (std::size_t k = 0; k < base.size(); ++k) {
    const unsigned movable = base.movable[k];
    if (movable == 0) continue;
    DisplacementSums& own = sums[index(std::popcount(movable)) - 1];
    const double amplitude = perturbation * base.spacing[k];
    const Point node = symmetry.preimage(realization.nodes[k]);
    for (std::size_t i = 0; i < 3; ++i) {
      if (!((movable >> i) & 1u)) continue;
      const double shift = (node[i] - base.position[k][i]) / amplitude;
      ++own.n[i];
      own.sum[i] += shift;
      for (std::size_t j = 0; j < 3; ++j) {
        if (!((movable >> j) & 1u)) continue;
        ++own.n_products[i][j];
        own.products[i][j] += shift * (node[j] - base.position[k][j]) / amplitude;
      }
    }
  }
  return sums;
}

}  // namespace

FineZone::FineZone(const Body& body, const input::Mesh& mesh)
    : body_(body), spacing_(body, mesh), largest_spacing_(fine_factor * mesh.notch_spacing) {}

bool FineZone::contains(const Point& p) const {
  const double spacing = spacing_(p);
  return spacing <= largest_spacing_ && body_.distance_to_surface(p) >= depth * spacing;
}

void DisplacementSums::add(const DisplacementSums& other) {
  for (std::size_t i = 0; i < 3; ++i) {
    n[i] += other.n[i];
    sum[i] += other.sum[i];
    for (std::size_t j = 0; j < 3; ++j) {
      n_products[i][j] += other.n_products[i][j];
      products[i][j] += other.products[i][j];
    }
  }
}

Survey::Survey(const Body& body, const MotherPoints& base, const input::Mesh& mesh, std::uint64_t seed)
    : body_(body), base_(base), mesh_(mesh), seed_(seed), zone_(body, mesh) {}

SurveyRow Survey::measure(std::uint64_t sample,
                          const std::function<void(const Realization&)>& inspect) const {
  SurveyRow row;
  row.sample = sample;
  Realization realization;
  MotherPoints own;
  const bool is_own = mesh_.base == input::Base::own;
  const MotherPoints& base = is_own ? own : base_;
  try {
    const ThreadClock clock;
    if (is_own) own = make_mother_points(body_, mesh_, seed_, {}, sample);
    realization = make_realization(body_, base, mesh_, seed_, sample);
    row.seconds = clock.seconds();
  } catch (const std::runtime_error& error) {
    row.error = error.what();
    return row;
  }
  if (inspect) inspect(realization);
  row.n_nodes = static_cast<std::int64_t>(realization.nodes.size());
  row.n_tetrahedra = static_cast<std::int64_t>(realization.tetrahedra.size());
  row.report = realization.report;
  row.mesh = mesh_statistics(realization);
  row.orientation = orientation_moments(realization, [&](const Point& p) { return zone_.contains(p); });
  row.displacement = displacement_sums(body_, base, realization, mesh_.perturbation);
  row.delaunay_seconds = plain_delaunay(realization.nodes).seconds;
  return row;
}

OrientationMoments Survey::base_orientation() const {
  input::Mesh undisturbed = mesh_;
  undisturbed.perturbation = 0;
  return orientation_moments(make_realization(body_, base_, undisturbed, seed_, 0),
                             [&](const Point& p) { return zone_.contains(p); });
}

}  // namespace crackle::geometry
