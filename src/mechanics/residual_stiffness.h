// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "mechanics/elasticity.h"
#include "mechanics/operators.h"

#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace crackle::mechanics {

/// Edges of a tetrahedron: bit k represents edge k in the order of geometry::dual_facet_nodes.
using EdgeSet = std::uint8_t;
inline constexpr EdgeSet no_edge = 0;
inline constexpr EdgeSet all_edges = 63;

using Matrix = std::array<Vector, 3>;  ///< rows

/// Stiffness of a tetrahedron with only some of its edges carrying load.
///
/// Its strain is given by those of its six edges, e_k = d_k . eps . d_k, and its intact stiffness by a matrix
/// K between them: sigma = sum_k q_k d_k (x) d_k with q = K e. A released edge k has q_k = 0 and arbitrary
/// e_k: K' = K_rr - K_rc K_cc^-1 K_cr. Hence it remains stress-free in rigid rotations, symmetric and
/// positive semi-definite, and every release lowers the energy.
struct EdgeStiffness {
  std::array<Vector, 6> edge;              ///< d_k [m]
  std::array<std::array<double, 6>, 6> k;  ///< K'; 0 in the rows and columns of released edges

  Symmetric stress(const Symmetric& strain) const;
  /// The block of V B^T C B that couples corners a and b, per volume [Pa/m^2].
  Matrix coupling(std::size_t a, std::size_t b) const;
};

/// Always computed from the intact tetrahedron, so the order in which edges were released has no influence.
EdgeStiffness edge_stiffness(const TetrahedronOperator& tetrahedron, const IsotropicElasticity& elasticity,
                             EdgeSet released);

/// A strain above which a cut is open, whatever the rounding.
inline constexpr double surely_open = 1e-9;

/// The contact of a broken tetrahedron's cut, and what it remembers of its motion.
struct CutContact {
  /// The operators of the intact tetrahedron, whose nodes are its corners' places 0 to 3.
  TetrahedronOperator intact{};
  std::array<std::int32_t, 4> corners{};  ///< local numbers
  Vector normal{};                        ///< of the cut, unit vector
  std::array<double, 4> closer{};         ///< strain along it per displacement along it of each corner [1/m]
  double share = 1;                       ///< of the stiffness in contact
  double closed_at = 0;                   ///< strain along the normal below which it resists closing
  Vector slip{};                          ///< shear strain at which the cut carries no friction
  double friction = 0;                    ///< magnitude of the shear traction when it was settled last [Pa]
  double dissipated = 0;                  ///< by friction [J]
  bool is_open = false;       ///< when it was settled last: without friction until it is settled again
  bool is_apart = false;      ///< its sides have moved apart so far that it does not act any more
  bool rests = false;         ///< so open that it does not act until it is looked at again
  double opening_before = 0;  ///< strain along the normal when it was looked at last

  bool acts() const { return !is_apart && !rests; }

  /// The strain along the normal, up to rounding.
  /// @param displacement of the corners
  double opening(const std::array<Vector, 4>& displacement) const {
    double sum = 0;
    for (std::size_t a = 1; a < 4; ++a) sum += closer[a] * dot(normal, displacement[a] - displacement[0]);
    return sum;
  }
  /// Strain of the tetrahedron, the initial one included. @param displacement of the corners [m]
  Symmetric strain(const std::array<Vector, 4>& displacement) const;
};

/// How the contact of a cut resists small changes of an equilibrium: across the cut with all of its stiffness
/// where it is closed, and by friction.
struct CutTangent {
  bool is_closed = false;
  double along = 0;       ///< share of the shear modulus that resists sliding
  double on_its_way = 0;  ///< likewise, along the way of a cut that slips
  Vector way{};           ///< unit vector, if it slips
  bool operator==(const CutTangent&) const = default;
};

/// The residual stiffness of each tetrahedron of a subdomain.
class ResidualStiffness {
public:
  /// Initially all are intact. The references must outlive the object.
  ResidualStiffness(const PdsOperators& operators, const ElasticityField& elasticity);

  /// The edges that no longer carry load; none while a tetrahedron is being released.
  EdgeSet released(std::int32_t tetrahedron) const {
    return static_cast<EdgeSet>(released_[index(tetrahedron)] & all_edges);
  }
  /// The same, with the edges that are being released.
  EdgeSet released_in_the_end(std::int32_t tetrahedron) const {
    const auto reduction = reductions_.find(tetrahedron);
    return reduction == reductions_.end() ? released(tetrahedron) : reduction->second.edges;
  }
  bool is_intact(std::int32_t tetrahedron) const { return released_[index(tetrahedron)] == no_edge; }
  /// True if any of its edges carries load, ignoring contact.
  bool carries(std::int32_t tetrahedron) const { return released(tetrahedron) != all_edges; }
  bool has_contact(std::int32_t tetrahedron) const { return contact_number(tetrahedron) >= 0; }
  /// The number of its contact, see contacts(); -1: none.
  std::int32_t contact_number(std::int32_t tetrahedron) const {
    return contact_place_.empty() ? -1 : contact_place_[index(tetrahedron)];
  }

  /// Stress carried at a strain without contact [Pa].
  Symmetric own_stress(std::int32_t tetrahedron, const Symmetric& strain) const;
  /// The same including contact [Pa].
  Symmetric stress(std::int32_t tetrahedron, const Symmetric& strain) const;
  /// Strain energy [J].
  double energy(std::int32_t tetrahedron, const Symmetric& strain) const;
  /// @pre neither intact nor fully released
  const EdgeStiffness& partial(std::int32_t tetrahedron) const {
    return partial_[index(place_[index(tetrahedron)])];
  }

  /// Reduces the stiffness to a share of the intact one.
  /// @pre no edge is released
  void soften(std::int32_t tetrahedron, double share);

  /// Releases further edges: at once, or with those that are being released.
  void release(std::int32_t tetrahedron, EdgeSet edges);

  /// Begins to release edges gradually: nothing changes until reduce().
  /// @pre no edge is released or being released
  void begin_release(std::int32_t tetrahedron, EdgeSet edges);

  /// Continues a gradual release.
  /// @param share of the difference between the stiffness before and after the release that is left; at 0 the
  ///   release is complete
  void reduce(std::int32_t tetrahedron, double share);

  /// Makes a broken tetrahedron resist closing its cut: from now on it carries E e_n n (x) n while its strain
  /// e_n along the normal n is negative, and by friction the shear t (x) n + n (x) t: t = G (g - slip) for a
  /// shear strain g along the cut, up to Coulomb's limit. For a tetrahedron that keeps no stiffness these
  /// moduli are the largest that never add energy beyond that of the unbroken one. While it is being
  /// released, contact grows as the stiffness decreases.
  /// @param normal unit vector
  void add_contact(std::int32_t tetrahedron, const Vector& normal);
  /// Tetrahedra with contact, in the order in which they were added.
  std::span<const std::int32_t> contacts() const { return contacts_; }
  CutContact& cut_contact(std::size_t i) { return cuts_[i]; }
  const CutContact& cut_contact(std::size_t i) const { return cuts_[i]; }
  /// Numbers of the contacts that may act, ascending: all new ones, and those that did at find_acting().
  std::span<const std::int32_t> acting() const { return acting_; }
  void find_acting();  ///< call after is_apart or rests have changed
  /// Changes whenever acting() may have.
  std::int64_t acting_version() const { return acting_version_; }
  /// Stress of contact number i at a strain of its tetrahedron [Pa]; 0 while it is open.
  Symmetric contact_stress(std::size_t i, const Symmetric& strain) const;
  double contact_energy(std::size_t i, const Symmetric& strain) const;  ///< likewise [J]
  /// A phase starts: where cuts overlap they resist closing further, without friction so far.
  void start_contact(std::size_t i, const Symmetric& strain);
  /// Lets a cut slip where friction has reached its limit, and accounts for the work.
  void settle_contact(std::size_t i, const Symmetric& strain);
  /// Likewise for a tetrahedron that breaks, without work.
  void settle_new_contact(std::int32_t tetrahedron, const Symmetric& strain);
  /// The tangent of contact number i at a strain. Along the way of a cut that slips the force follows the
  /// pressure, which a symmetric tangent leaves out.
  CutTangent cut_tangent(std::size_t i, const Symmetric& strain) const;
  /// Takes a tetrahedron's stiffness from another object, with the tangent of its contact, for a solver of
  /// equilibria.
  void linearize(std::int32_t tetrahedron, const ResidualStiffness& at, const CutTangent& tangent);
  /// @param friction Coulomb's coefficient
  void set_friction(double friction) { friction_ = friction; }
  /// Contact acts unless it is told not to, as in equilibria without closed cuts.
  void let_contacts_act(bool do_act) { contacts_act_ = do_act; }
  bool contacts_act() const { return contacts_act_; }

private:
  /// Flag in addition to the edges in released_.
  static constexpr EdgeSet softened = 64;
  /// A gradual release in progress.
  struct Reduction {
    EdgeStiffness before;
    EdgeSet edges;
    double share;
  };
  /// The state of a contact at a strain, at full stiffness.
  struct CutState {
    double closing;   // strain beyond the closed state, negative while the cut is closed
    Vector shear;     // strain along the cut
    Vector traction;  // by friction [Pa]
    bool slips;       // the limit is reached
  };
  CutState cut_state(std::size_t i, const Symmetric& strain) const;
  EdgeStiffness stiffness_without(std::int32_t tetrahedron, EdgeSet released) const;
  EdgeStiffness& make_partial(std::int32_t tetrahedron);
  void interpolate(std::int32_t tetrahedron, const Reduction& reduction);

  const PdsOperators* operators_;
  const ElasticityField* elasticity_;
  std::vector<EdgeSet> released_;
  std::vector<std::int32_t> place_;  // index in partial_; -1 for those never partially released
  std::vector<EdgeStiffness> partial_;
  std::unordered_map<std::int32_t, Reduction> reductions_;
  std::vector<std::int32_t> contacts_;
  std::vector<CutContact> cuts_;  // of contacts_
  std::vector<std::int32_t> acting_;
  std::int64_t acting_version_ = 0;
  std::vector<std::int32_t> contact_place_;  // of each tetrahedron, or -1; empty without contacts
  double friction_ = 0;
  bool contacts_act_ = true;
};

}  // namespace crackle::mechanics
