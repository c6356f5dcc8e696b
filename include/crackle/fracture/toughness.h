// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/fracture/breakable_body.h"
#include "crackle/geometry/body.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/input/parameters.h"
#include "crackle/mechanics/operators.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace crackle::fracture {

/// A strength criterion has no toughness of its own: a slow crack through tetrahedra of spacing h takes the
/// energy c(nu) strength^2 h / E out of the body for each unit of its area. This is c, fitted to the loads at
/// which cracked strips and bars in three-point bending become unstable (jobs/verification/README.md).
double toughness_factor(input::Release release, double poisson_ratio);

/// The same with the stress averaged over a ball (fracture::StressAverage): in place of the spacing stands
/// this many times the ball's radius. Measured likewise; it holds on every mesh that resolves the ball.
double spacings_per_length(input::Release release, double poisson_ratio);

/// Energy per crack area for a strength at a spacing, one of fracture_spacings() [J/m^2].
double toughness_of(const input::Parameters& parameters, double strength, double spacing);

/// Strength that gives an energy per crack area at a spacing [Pa].
double strength_of(const input::Parameters& parameters, double toughness, double spacing);

/// Of a quantity over several places.
struct Range {
  double least = 0;
  double greatest = 0;
};

/// The spacings that the input asks for along the ligaments: straight on from each notch's tip, to the
/// opposite face or the next notch [m]. Nothing without notches.
std::optional<Range> spacing_along_ligaments(const input::Parameters& parameters, const geometry::Body& body);

/// The toughness that a strength [Pa] has at these spacings [J/m^2].
std::optional<Range> toughness_along_ligaments(const input::Parameters& parameters,
                                               const geometry::Body& body, double strength);

/// Local spacing at each local tetrahedron: the mean over its corners of the edge of the regular tetrahedron
/// that has the mean volume of the tetrahedra round the corner [m]. Collective; equal bits for any number of
/// ranks.
std::vector<double> local_spacings(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                   const mechanics::PdsOperators& operators);

/// The spacing that strength and toughness of each local tetrahedron go with: the local one, or what the ball
/// over which the stress is averaged stands for [m]. Collective as local_spacings().
std::vector<double> fracture_spacings(const parallel::Communicator& group,
                                      const input::Parameters& parameters,
                                      const geometry::Subdomain& subdomain,
                                      const mechanics::PdsOperators& operators);

/// Strength of each local tetrahedron [Pa]: the input's, or what gives the input's toughness at the local
/// spacing or the length over which the stress is averaged; times what the sample's variation makes of it.
/// Collective; equal bits for any number of ranks.
std::vector<double> tetrahedron_strengths(const parallel::Communicator& group,
                                          const input::Parameters& parameters, std::uint64_t sample,
                                          const geometry::Subdomain& subdomain,
                                          const mechanics::PdsOperators& operators);

/// Makes the tetrahedra of an intact body soften where the input asks for it. Each then dissipates the
/// sample's toughness at its place over the width of the band, for each of its volume. Collective; the same
/// for any number of ranks.
void soften_by_input(const parallel::Communicator& group, const input::Parameters& parameters,
                     std::uint64_t sample, BreakableBody& body);

}  // namespace crackle::fracture
