// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "fracture/break_record.h"
#include "fracture/release.h"
#include "geometry/subdomain.h"
#include "mechanics/edges.h"
#include "mechanics/initial_strain.h"
#include "mechanics/internal_force.h"
#include "mechanics/operators.h"
#include "mechanics/residual_stiffness.h"
#include "parallel/communicator.h"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// The seven cuts' vector areas of a tetrahedron: V b^a, then V (b^0 + b^k) for k = 1, 2, 3 [m^2].
std::array<Vector, n_cuts> cut_areas(const mechanics::TetrahedronOperator& tetrahedron);

/// The cut with the largest normal traction n . sigma . n; the lower number if equal.
int most_loaded_cut(const mechanics::TetrahedronOperator& tetrahedron, const mechanics::Symmetric& sigma);

/// A body that can break: its constant operators, its internal force and its set of broken tetrahedra, on one
/// subdomain.
///
/// Its Release decides what a breaking tetrahedron loses.
///
/// Ranks that hold the same tetrahedron compute bitwise the same stress, so they break it consistently
/// without communication.
class BreakableBody {
public:
  /// @param subdomain must outlive the object
  /// @param release nullptr: by elements, at once
  BreakableBody(const geometry::Subdomain& subdomain, mechanics::MaterialField material,
                std::unique_ptr<Release> release = nullptr, input::Contact contact = input::Contact::none,
                double friction = 0);
  BreakableBody(const geometry::Subdomain& subdomain, const input::Material& material,
                std::unique_ptr<Release> release = nullptr, input::Contact contact = input::Contact::none,
                double friction = 0)
      : BreakableBody(subdomain, mechanics::MaterialField(material), std::move(release), contact, friction) {}
  BreakableBody(const BreakableBody&) = delete;
  BreakableBody& operator=(const BreakableBody&) = delete;

  const geometry::Subdomain& subdomain() const { return *subdomain_; }
  const mechanics::PdsOperators& operators() const { return operators_; }
  /// For mass scaling, which adds to the masses.
  mechanics::PdsOperators& operators() { return operators_; }
  const mechanics::MaterialField& material() const { return material_; }
  const mechanics::ElasticityField& elasticity() const { return material_.elasticity; }
  const mechanics::Edges& edges() const { return edges_; }
  const mechanics::InternalForce& force() const { return force_; }
  const mechanics::InitialStrain& initial_strain() const { return initial_strain_; }
  const mechanics::ResidualStiffness& residual_stiffness() const { return residual_stiffness_; }
  /// For contacts, which remember their motion.
  mechanics::ResidualStiffness& residual_stiffness() { return residual_stiffness_; }
  /// True if broken tetrahedra resist closing.
  bool has_contact() const { return contact_ != input::Contact::none; }

  bool is_broken(std::int32_t tetrahedron) const { return broken_[index(tetrahedron)] != 0; }
  /// For each local tetrahedron and corner the neighbour across the opposite face, broken or not; -1 if there
  /// is none. Computed on first use.
  const std::vector<std::array<std::int32_t, 4>>& face_neighbours() const;
  /// Local tetrahedra in order of breaking.
  std::span<const std::int32_t> broken_tetrahedra() const { return order_; }
  const Release& release_law() const { return *release_; }
  /// Replaces it while the body is intact, and opens the pre-cracks. Local.
  void set_release(std::unique_ptr<Release> release);
  /// True if tetrahedra soften before they break.
  bool softens() const { return release_->softens(); }
  /// Local tetrahedra whose stiffness was reduced, in order; repeated for each reduction.
  std::span<const std::int32_t> changes() const { return changes_; }
  /// Breaks counted by this rank, in order of breaking.
  std::span<const Break> breaks() const { return records_; }
  /// Stiffness reductions of softening tetrahedra counted by this rank, in order.
  std::span<const StiffnessReduction> stiffness_reductions() const { return stiffness_reductions_; }
  /// Releases by the bridging rule of tetrahedra counted by this rank.
  std::span<const BridgeRelease> bridge_releases() const { return bridge_releases_; }

  /// The elastic strain, on which stress and energy depend: without the initial strain.
  mechanics::Symmetric strain(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return initial_strain_.elastic(tetrahedron, total_strain(tetrahedron, displacement));
  }
  /// Stress of the intact material of a tetrahedron at an elastic strain [Pa].
  mechanics::Symmetric intact_stress(std::int32_t tetrahedron, const mechanics::Symmetric& strain) const {
    return material_.elasticity[tetrahedron](strain);
  }
  /// The same at the tetrahedron's own strain.
  mechanics::Symmetric stress(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return intact_stress(tetrahedron, strain(tetrahedron, displacement));
  }
  /// Its rate while the displacement changes at a rate, and the initial strain with time [Pa/s].
  mechanics::Symmetric stress_rate(std::int32_t tetrahedron, std::span<const double> velocity) const {
    return intact_stress(tetrahedron, strain_rate(tetrahedron, velocity));
  }
  /// Likewise, of the elastic strain [1/s].
  mechanics::Symmetric strain_rate(std::int32_t tetrahedron, std::span<const double> velocity) const {
    return initial_strain_.elastic_rate(tetrahedron, total_strain(tetrahedron, velocity));
  }

  /// Enables an initial strain, at its time 0.
  void set_initial_strain(mechanics::InitialStrain strain) { initial_strain_ = std::move(strain); }
  /// Takes the initial strain at a time of the load curves [s].
  void set_time(double time) {
    if (!initial_strain_.is_none()) initial_strain_.set_time(time);
  }

  /// Breaks a tetrahedron, or reduces the stiffness of a softening one by a tooth; the recorded energy and
  /// cut are computed from the given strain. Local; every rank that holds it must do the same.
  /// @param moves in a dynamic phase the stiffness may fall over time, otherwise it is lost at once
  void release(std::int32_t tetrahedron, const mechanics::Symmetric& strain, double load_time,
               double phase_time, bool moves = false);

  /// Continues the releases that are under way. The energy is added to that of the break. Local, like
  /// release().
  /// @param strain current strain of a local tetrahedron
  void continue_releases(double phase_time, const std::function<mechanics::Symmetric(std::int32_t)>& strain);
  /// True if tetrahedra of this rank are being released.
  bool is_releasing() const { return !releasing_.empty(); }

  /// Restores releases recorded by an earlier run: all that this rank holds, counted or not.
  /// @param phase_time now, in the phase of these releases; infinity: all are complete
  void restore(const Releases& releases, double phase_time = infinity);

  /// Applies the bridging rule after breaks since the last call; no effect with release by elements.
  /// Collective; does not call check_peers() before. A rank that fails before its communication throws; the
  /// others then do nothing.
  /// @param load_time, phase_time of these breaks, for the records
  /// @param strain current strain of a local tetrahedron
  void release_bridges(const parallel::Communicator& group, double load_time, double phase_time,
                       const std::function<mechanics::Symmetric(std::int32_t)>& strain);

  /// Strain energy of each tetrahedron counted by this rank [J].
  std::vector<double> strain_energies(std::span<const double> displacement) const;
  /// The same of a body without initial strain: the quadratic form of the stiffness.
  std::vector<double> change_energies(std::span<const double> displacement) const;
  /// Energies released by the breaks, bridge releases and stiffness reductions counted by this rank [J].
  std::vector<double> released_energies() const;

private:
  /// Edge k of the tetrahedron with this number in the realization.
  struct BridgingEdge {
    std::int64_t tetrahedron;
    std::int64_t edge;
    auto operator<=>(const BridgingEdge&) const = default;
  };
  mechanics::Symmetric total_strain(std::int32_t tetrahedron, std::span<const double> displacement) const {
    return mechanics::strain(operators_.tetrahedra[index(tetrahedron)], displacement);
  }
  template <class Strain>
  std::vector<double> energies(const Strain& strain) const;
  std::vector<BridgingEdge> find_bridging_edges() const;
  void reduce(std::int32_t tetrahedron, double share, const mechanics::Symmetric& strain, double load_time,
              double phase_time, double ductility);
  /// A break whose tetrahedron still has part of its stiffness.
  struct Releasing {
    std::int32_t tetrahedron;
    double phase_time;
    std::optional<std::size_t> record;  // in records_, if this rank counts it
  };
  void open(std::int32_t tetrahedron, int cut, double remaining);
  Vector contact_normal(std::int32_t tetrahedron, int cut) const;
  void release_edges(std::int32_t tetrahedron, mechanics::EdgeSet edges);

  const geometry::Subdomain* subdomain_;
  std::unique_ptr<Release> release_;
  input::Contact contact_;
  mechanics::MaterialField material_;
  mechanics::PdsOperators operators_;
  mechanics::Edges edges_;
  mechanics::ResidualStiffness residual_stiffness_;
  mechanics::InitialStrain initial_strain_;
  mechanics::InternalForce force_;
  mutable std::vector<std::array<std::int32_t, 4>> face_neighbours_;
  std::vector<std::uint8_t> broken_;
  std::vector<std::int32_t> order_;
  std::vector<Releasing> releasing_;
  std::vector<std::int32_t> changes_;
  std::vector<StiffnessReduction> stiffness_reductions_;
  std::size_t n_checked_ = 0;  // number of entries in order_ whose edges were checked
  std::vector<BridgeRelease> bridge_releases_;
  std::vector<Break> records_;
};

}  // namespace crackle::fracture
