// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <vector>

namespace crackle::fracture {

/// The seven ways to separate the four particles of a tetrahedron: cut 0..3 separates node `cut` from the
/// other three (vector area V b^a), cuts 4, 5, 6 separate the pairs {0,1|2,3}, {0,2|1,3}, {0,3|1,2} (V (b^0 +
/// b^k)).
inline constexpr int n_cuts = 7;

/// One broken tetrahedron.
struct Break {
  std::int64_t tetrahedron;  ///< number in the realization
  double load_time;   ///< time of the quasi-static equilibrium, or of the start of the dynamic phase [s]
  double phase_time;  ///< time since then; 0 for a quasi-static break [s]
  double principal_stress;  ///< largest principal stress when it broke [Pa]
  double released_energy;   ///< strain energy released from the body [J]
  std::int32_t cut;         ///< the most loaded of the seven cuts: its dual facets form the crack
};

/// Edges released from a tetrahedron broken by facets, besides those of its cut; the times are those of the
/// break that caused it.
struct BridgeRelease {
  std::int64_t tetrahedron;  ///< number in the realization
  double load_time;          ///< as in Break [s]
  double phase_time;         ///< as in Break [s]
  double released_energy;    ///< strain energy released from the body [J]
  std::uint32_t edges;       ///< mechanics::EdgeSet
};

/// One reduction of the stiffness of a softening tetrahedron, by a tooth of fracture::SofteningLaw; the last
/// tooth is a Break.
struct StiffnessReduction {
  std::int64_t tetrahedron;  ///< number in the realization
  double load_time;          ///< as in Break [s]
  double phase_time;         ///< as in Break [s]
  double released_energy;    ///< strain energy released from the body [J]
  double share;              ///< remaining share of the stiffness
  double ductility;          ///< argument of SofteningLaw::teeth(); equal for all reductions of a tetrahedron
};

/// All releases of a body.
struct Releases {
  std::vector<Break> breaks;
  std::vector<BridgeRelease> bridge_releases;
  std::vector<StiffnessReduction> stiffness_reductions;  ///< in order for each tetrahedron
};

}  // namespace crackle::fracture
