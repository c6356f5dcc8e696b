// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "fracture/variation.h"
#include "geometry/body.h"
#include "geometry/subdomain.h"
#include "input/material_model.h"
#include "input/poisson_limits.h"
#include "mechanics/operators.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace crackle::fracture {

using input::toughness_factor;

/// With the stress averaged over a ball (StressAverage), the spacing in the relation of strength and
/// toughness is replaced by this multiple of the ball's radius. Measured likewise; valid on every mesh that
/// resolves the ball.
double spacings_per_length(input::Release release, double poisson_ratio);

/// Energy per crack area for a strength and a spacing, one of fracture_spacings() [J/m^2].
double toughness_of(const input::MaterialModel& model, double strength, double spacing);

/// Strength that gives the energy per crack area at a spacing [Pa].
double strength_of(const input::MaterialModel& model, double toughness, double spacing);

/// Range of a quantity over several places.
struct Range {
  double least = 0;
  double greatest = 0;
};

/// The spacings that a mesh requires along the ligaments: from each notch tip straight ahead to the opposite
/// face or the next notch [m]. Empty without notches.
std::optional<Range> spacing_along_ligaments(const input::Mesh& mesh, const geometry::Body& body);

/// Local spacing at each local tetrahedron: the mean over its corners of the edge length of a regular
/// tetrahedron with the mean volume of the tetrahedra around the corner [m]. Collective; bitwise equal for
/// any number of ranks.
std::vector<double> local_spacings(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const mechanics::PdsOperators& operators);
/// The same at the tetrahedra of a whole realization. Local.
std::vector<double> local_spacings(const TetrahedronSpan& whole);

/// The spacing that relates strength and toughness of each local tetrahedron: the local one, or the
/// equivalent of the ball over which stress is averaged [m]. Collective as local_spacings().
std::vector<double> fracture_spacings(const parallel::Communicator& group, const input::MaterialModel& model,
                                      const BreakableBody& body);

/// Strengths of the local tetrahedra of a sample [Pa].
struct Strengths {
  /// The input's for its material, or for the interface that it touches; or the one that gives the toughness
  /// at the local spacing or the averaging length; multiplied by the sample's variation. If the input gives
  /// both, that of nucleation: the input's, or the larger of the two if the stress that must reach it is not
  /// a mean around nodes; with softening the input's.
  std::vector<double> nucleation;
  /// At a crack, see CrackVicinity; empty if the input gives only one of strength and toughness, or
  /// softening.
  std::vector<double> growth;
};

/// Collective; bitwise equal for any number of ranks.
Strengths tetrahedron_strengths(const parallel::Communicator& group, const input::MaterialModel& model,
                                std::uint64_t sample, const BreakableBody& body);

/// Energy per crack area that corresponds to the strength of each local tetrahedron [J/m^2]. Collective as
/// local_spacings().
std::vector<double> tetrahedron_toughness(const parallel::Communicator& group,
                                          const input::MaterialModel& model, const BreakableBody& body,
                                          std::span<const double> strengths);

/// The dissipation of each softening tetrahedron, per volume: the sample's local toughness divided by the
/// width of the crack band [J/m^3]. Collective; equal for any number of ranks.
/// @return empty without softening
std::vector<double> dissipations(const parallel::Communicator& group, const input::MaterialModel& model,
                                 std::uint64_t sample, const BreakableBody& body);

}  // namespace crackle::fracture
