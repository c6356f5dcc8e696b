// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/common/index.h"
#include "crackle/fracture/break_record.h"
#include "crackle/fracture/criterion.h"
#include "crackle/fracture/softening.h"
#include "crackle/geometry/subdomain.h"
#include "crackle/mechanics/edges.h"
#include "crackle/mechanics/internal_force.h"
#include "crackle/mechanics/operators.h"
#include "crackle/mechanics/residual_stiffness.h"
#include "crackle/parallel/communicator.h"

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::fracture {

/// The seven cuts' vector areas of a tetrahedron: V b^a, then V (b^0 + b^k) for k = 1, 2, 3 [m^2].
std::array<Vector, n_cuts> cut_areas(const mechanics::TetrahedronOperator& tetrahedron);

/// The cut with the largest normal traction n . sigma . n; ties go to the lower number.
int most_loaded_cut(const mechanics::TetrahedronOperator& tetrahedron, const mechanics::Symmetric& sigma);

/// The edges that a cut crosses.
mechanics::EdgeSet crossed_edges(int cut);

/// With release by facets, a broken tetrahedron also lets go of an edge when the dual facets of the unbroken
/// tetrahedra round that edge are at most this share of all. With 0 it waits until all round the edge are
/// broken.
inline constexpr double bridging_share = 0.0;

/// A body that can break: its constant operators, its internal force and its broken set, on one subdomain.
///
/// Release by elements: a broken tetrahedron carries nothing. Release by facets: it lets go of the edges that
/// its most loaded cut crosses (mechanics::EdgeStiffness), and of further ones by the bridging rule, without
/// which neighbouring tetrahedra with different cuts would bridge the crack forever.
///
/// Ranks that hold the same tetrahedron see the same stress bits, so they break it together without a
/// message.
class BreakableBody {
public:
  /// @param subdomain must outlive the object
  BreakableBody(const geometry::Subdomain& subdomain, const input::Material& material,
                input::Release release = input::Release::element,
                input::Contact contact = input::Contact::none);
  BreakableBody(const BreakableBody&) = delete;
  BreakableBody& operator=(const BreakableBody&) = delete;

  const geometry::Subdomain& subdomain() const { return *subdomain_; }
  const mechanics::PdsOperators& operators() const { return operators_; }
  const mechanics::IsotropicElasticity& elasticity() const { return elasticity_; }
  const mechanics::Edges& edges() const { return edges_; }
  const mechanics::InternalForce& force() const { return force_; }
  const mechanics::ResidualStiffness& residual_stiffness() const { return residual_stiffness_; }
  /// Whether broken tetrahedra resist being closed again.
  bool has_contact() const { return contact_ != input::Contact::none; }

  bool is_broken(std::int32_t tetrahedron) const { return broken_[index(tetrahedron)] != 0; }
  /// For each local tetrahedron and corner the one across the opposite face, broken or not; -1 where none is.
  /// Found when first asked for.
  const std::vector<std::array<std::int32_t, 4>>& face_neighbours() const;
  /// Local tetrahedra in order of breaking.
  std::span<const std::int32_t> broken_tetrahedra() const { return order_; }
  /// Whether tetrahedra soften before they break.
  bool softens() const { return softening_.has_value(); }
  /// The stress at the strain of a tetrahedron, over that at which it first gave way, that makes it give way
  /// further; 1 while it is intact. Both stresses are those of the intact material.
  double threshold(std::int32_t tetrahedron) const;
  /// Local tetrahedra whose stiffness was reduced, in order; some more than once.
  std::span<const std::int32_t> changes() const { return changes_; }
  /// Records of the breaks that this rank counts, in order of breaking.
  std::span<const Break> breaks() const { return records_; }
  /// Teeth of softening tetrahedra that this rank counts, in order of falling.
  std::span<const ToothFall> tooth_falls() const { return tooth_falls_; }
  /// What the bridging rule released of tetrahedra that this rank counts.
  std::span<const BridgeRelease> bridge_releases() const { return bridge_releases_; }

  mechanics::Symmetric strain(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return mechanics::strain(operators_.tetrahedra[index(tetrahedron)], displacement);
  }
  /// Stress of the unbroken material at the strain of a tetrahedron.
  mechanics::Symmetric stress(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return elasticity_(strain(tetrahedron, displacement));
  }

  /// From now on tetrahedra soften before they break.
  /// @param dissipation of each local tetrahedron, over its volume [J/m^3]
  void soften(const SofteningLaw& law, std::vector<double> dissipation);

  /// Breaks a tetrahedron, or takes one tooth from a softening one; the record's energy and cut follow from
  /// the strain it had. Local; every rank that holds it does the same.
  void release(std::int32_t tetrahedron, const mechanics::Symmetric& strain, double load_time,
               double phase_time);

  /// Opens tetrahedra as records of an earlier run tell: all that this rank holds, counted or not.
  void restore(const Releases& releases);

  /// Applies the bridging rule after breaks since the last call; nothing with release by elements.
  /// Collective; does not agree() before. Where a rank fails before its messages, it throws and the others do
  /// nothing.
  /// @param load_time, phase_time of these breaks, for the records
  /// @param strain of a local tetrahedron now
  void release_bridges(const parallel::Communicator& group, double load_time, double phase_time,
                       const std::function<mechanics::Symmetric(std::int32_t)>& strain);

  /// Strain energies of the tetrahedra that this rank counts [J], one for each.
  std::vector<double> strain_energies(std::span<const double> displacement) const;
  /// Energies taken out by the breaks, bridge releases and teeth that this rank counts [J].
  std::vector<double> released_energies() const;

private:
  /// Edge k of the tetrahedron with this number in the realization.
  struct BridgingEdge {
    std::int64_t tetrahedron;
    std::int64_t edge;
    auto operator<=>(const BridgingEdge&) const = default;
  };
  /// Teeth of a tetrahedron that have fallen.
  struct Softened {
    int n_fallen = 0;
    double ductility = 0;
  };
  std::vector<BridgingEdge> find_bridging_edges() const;
  /// @return false when no tooth is left
  bool lose_tooth(std::int32_t tetrahedron, const mechanics::Symmetric& strain, double load_time,
                  double phase_time);
  void open(std::int32_t tetrahedron, int cut);
  void let_go(std::int32_t tetrahedron, mechanics::EdgeSet edges);

  const geometry::Subdomain* subdomain_;
  input::Release release_;
  input::Contact contact_;
  mechanics::PdsOperators operators_;
  mechanics::Edges edges_;
  mechanics::IsotropicElasticity elasticity_;
  mechanics::ResidualStiffness residual_stiffness_;
  mechanics::InternalForce force_;
  mutable std::vector<std::array<std::int32_t, 4>> face_neighbours_;
  std::vector<std::uint8_t> broken_;
  std::vector<std::int32_t> order_;
  std::vector<std::int32_t> changes_;
  std::optional<SofteningLaw> softening_;
  std::vector<double> dissipation_;  // of each tetrahedron while it softens, over its volume [J/m^3]
  std::unordered_map<std::int32_t, Softened> softened_;
  std::vector<ToothFall> tooth_falls_;
  std::size_t n_checked_ = 0;  // of order_, those whose edges were looked at
  std::vector<BridgeRelease> bridge_releases_;
  std::vector<Break> records_;
};

/// Tells a criterion at which stress softened tetrahedra give way next.
/// @param changed local tetrahedra whose stiffness was reduced
void update_strengths(Criterion& criterion, const BreakableBody& body, std::span<const std::int32_t> changed);

}  // namespace crackle::fracture
