// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/breakable_body.h"
#include "mechanics/residual_stiffness.h"
#include "parallel/communicator.h"
#include "parallel/numbered_rows.h"

#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// The contact of cuts in the equilibria of a sample: as in motion (ContactTerm) while their sides stay
/// close, with the friction of where they have slipped. Cuts whose sides have moved apart do not act. While
/// all cuts are open it does not act, so that equilibria are linear.
class ContactAtRest {
public:
  /// The references must outlive the object. Local.
  ContactAtRest(const parallel::Communicator& group, fracture::BreakableBody& body)
      : group_(&group), body_(&body), tangent_(body.operators(), body.elasticity()) {
    take_over(body.changes());
  }

  /// The body's stiffness with that of closed cuts.
  const mechanics::ResidualStiffness& tangent() const { return tangent_; }
  bool acts() const { return std::as_const(*body_).residual_stiffness().contacts_act(); }

  /// True if a cut is closed at these elastic strains. Collective.
  using Strain = std::function<mechanics::Symmetric(std::int32_t tetrahedron)>;
  bool closes(const Strain& strain) const;
  bool closes(std::span<const double> displacement) const;
  /// True if a cut will close while strains change at these rates for ever. Collective.
  bool closes_in_the_end(const Strain& rate) const;

  /// Acts from now on. @param displacement of an equilibrium without closed cuts, from which they may stick
  void start(std::span<const double> displacement);
  /// Acts from now on, from where cuts were in motion.
  void start();
  /// Takes over tetrahedra whose stiffness has changed. Local.
  void take_over(std::span<const std::int32_t> changes);
  /// Finds the tangent at a displacement. Local.
  /// @return the tetrahedra whose tangent has changed
  std::vector<std::int32_t> linearize(std::span<const double> displacement);
  /// An equilibrium is found: lets cuts slip. Local.
  void settle(std::span<const double> displacement);
  /// By friction in equilibria [J]. Collective; bitwise equal for any number of ranks.
  double dissipated() const;

private:
  mechanics::Symmetric strain(std::size_t contact, std::span<const double> displacement) const;

  const parallel::Communicator* group_;
  fracture::BreakableBody* body_;
  mechanics::ResidualStiffness tangent_;
  std::vector<mechanics::CutTangent> tangents_;  // of each contact, as in tangent_
  std::vector<double> dissipated_;               // by each contact [J]
};

/// The state of the cuts of all ranks, gathered on the root. Collective.
parallel::NumberedRows save_cuts(const parallel::Communicator& group, const fracture::BreakableBody& body);
/// @throws std::runtime_error when a broken tetrahedron is missing
void restore_cuts(const parallel::NumberedRows& rows, fracture::BreakableBody& body);

}  // namespace crackle::dynamics
