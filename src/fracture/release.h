// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "input/model.h"
#include "mechanics/residual_stiffness.h"
#include "mechanics/tetrahedron_field.h"

#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// How a tetrahedron that meets the criterion gives way. Serves the tetrahedra of one body.
class Release {
public:
  /// How the stiffness of a breaking tetrahedron falls in a dynamic phase: linearly.
  struct Course {
    mechanics::TetrahedronField<double> time{0.0};  ///< until it is lost [s]; 0: lost at once
    double step = 0;                                ///< of the dynamic phase [s]
  };
  /// The stiffness left to a tetrahedron that does not break yet.
  struct Reduction {
    double share;      ///< of its stiffness
    double ductility;  ///< as in StiffnessReduction
  };

  explicit Release(Course course) : course_(std::move(course)) {}
  virtual ~Release() = default;
  Release(const Release&) = delete;
  Release& operator=(const Release&) = delete;

  /// The edges that a breaking tetrahedron loses.
  /// @param cut the most loaded one, see Break
  virtual mechanics::EdgeSet edges([[maybe_unused]] int cut) const { return mechanics::all_edges; }
  /// True if a broken tetrahedron loses the edges, too, around which all others are broken.
  virtual bool opens_bridges() const { return false; }

  /// True if tetrahedra soften before they break.
  virtual bool softens() const { return false; }
  /// The next step of an unbroken tetrahedron; empty if it breaks.
  /// @param energy of the intact material at its strain, per volume [J/m^3]
  virtual std::optional<Reduction> reduce([[maybe_unused]] std::int32_t tetrahedron,
                                          [[maybe_unused]] double energy) {
    return {};
  }
  /// Restores one step of an earlier run.
  virtual void restore([[maybe_unused]] std::int32_t tetrahedron, [[maybe_unused]] double ductility) {}
  /// The stress at which a tetrahedron softens or breaks next, relative to that at which it first softened; 1
  /// while it is intact. Both stresses are those of the intact material at the same strain.
  virtual double threshold([[maybe_unused]] std::int32_t tetrahedron) const { return 1; }

  /// The share of its stiffness that a tetrahedron keeps in the coming step of a dynamic phase: the mean over
  /// the step.
  /// @param since_break [s]
  virtual double remaining(std::int32_t tetrahedron, double since_break) const;

  const mechanics::TetrahedronField<double>& time() const { return course_.time; }

private:
  Course course_;
};

/// A broken tetrahedron carries no load.
class ElementRelease : public Release {
public:
  using Release::Release;
};

/// A broken tetrahedron releases the edges crossed by its most loaded cut (mechanics::EdgeStiffness), and
/// those around which all tetrahedra are broken (the bridging rule), without which neighbouring tetrahedra
/// with different cuts would bridge the crack forever.
class FacetRelease : public Release {
public:
  using Release::Release;
  mechanics::EdgeSet edges(int cut) const override;
  bool opens_bridges() const override { return true; }
};

/// The edges crossed by a cut.
mechanics::EdgeSet crossed_edges(int cut);

/// The release that the input asks for.
/// @param dissipation of each local tetrahedron with softening, see Softening
std::unique_ptr<Release> make_release(const input::Fracture& fracture, Release::Course course = {},
                                      std::vector<double> dissipation = {});

}  // namespace crackle::fracture
