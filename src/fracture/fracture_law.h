// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "fracture/break_record.h"
#include "fracture/breakable_body.h"
#include "fracture/crack_vicinity.h"
#include "fracture/criterion.h"
#include "fracture/nodal_means.h"
#include "fracture/stress_average.h"
#include "fracture/toughness.h"
#include "input/material_model.h"
#include "parallel/communicator.h"
#include "parallel/numbered_rows.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace crackle::fracture {

/// When the tetrahedra of a body break, and how: the criterion with its measure of stress, its strengths and
/// its memory, the stress that it is given (a tetrahedron's own, with means around nodes, or an average over
/// balls), and the body's Release.
class FractureLaw {
public:
  /// The time steps of dynamic phases [s].
  struct Steps {
    double used;
    double stable;
  };
  struct Options {
    std::span<const SquareEnd> ends = {};  ///< that count as cracks
    bool follows_cracks = true;            ///< false: strengths do not depend on where cracks are
    double weakening = 1;                  ///< divides the strengths away from cracks
  };

  /// That of a sample. Collective; equal for any number of ranks.
  /// @param sample its number, on which random fields depend
  /// @param body receives its release, if it is intact; must outlive the object
  FractureLaw(const parallel::Communicator& group, const input::MaterialModel& model, std::uint64_t sample,
              BreakableBody& body, const Steps& steps, const Options& options);
  FractureLaw(const parallel::Communicator& group, const input::MaterialModel& model, std::uint64_t sample,
              BreakableBody& body, const Steps& steps)
      : FractureLaw(group, model, sample, body, steps, Options()) {}
  /// A criterion that is given each tetrahedron's own stress. Local.
  /// @param vicinity of cracks, whose criterion it is, or nullptr
  explicit FractureLaw(std::unique_ptr<Criterion> criterion, double screening_share = 1,
                       std::unique_ptr<CrackVicinity> vicinity = nullptr)
      : criterion_(std::move(criterion)), screening_share_(screening_share), vicinity_(std::move(vicinity)) {}
  FractureLaw(const FractureLaw&) = delete;
  FractureLaw& operator=(const FractureLaw&) = delete;

  const EquivalentStress& stress() const { return criterion_->stress(); }
  /// As of Criterion.
  double strength(std::size_t tetrahedron) const { return criterion_->strength(tetrahedron); }
  std::span<const double> strengths() const { return criterion_->strengths(); }
  /// The strength of each local tetrahedron at a crack [Pa]; empty: as elsewhere.
  std::span<const double> growth_strengths() const { return growth_; }
  /// The share of its strength above which a tetrahedron must be passed to advance() at the end of a step.
  double screening_share() const { return screening_share_; }
  /// As of Criterion.
  bool advance(std::size_t tetrahedron, double earlier, double before, double after) {
    return criterion_->advance(tetrahedron, earlier, before, after);
  }
  double time_to_failure(std::size_t tetrahedron, double stress) const {
    return criterion_->time_to_failure(tetrahedron, stress);
  }
  Criterion& criterion() { return *criterion_; }

  /// The average over balls that the criterion is given instead of a tetrahedron's own stress, or nullptr.
  StressAverage* average() const { return average_.get(); }
  /// The means around nodes that must reach the strength beside the own stress, or nullptr.
  const NodalMeans* means() const { return vicinity_ ? vicinity_->means() : nullptr; }
  /// True if they must for a local tetrahedron now.
  bool needs_mean(std::int32_t tetrahedron) const { return vicinity_ && vicinity_->needs_mean(tetrahedron); }

  /// Takes over the thresholds of softened tetrahedra. Local.
  /// @param changed local tetrahedra whose stiffness was reduced
  void take_over(const BreakableBody& body, std::span<const std::int32_t> changed);
  /// Follows the cracks, see CrackVicinity::update(), likewise collective.
  /// @return the local tetrahedra whose strength has changed, ascending
  std::span<const std::int32_t> follow_cracks(const parallel::Communicator& group,
                                              double phase_time = infinity);

  /// Non-zero memory of the criterion, by bits, on the root. Collective.
  parallel::NumberedRows save(const parallel::Communicator& group,
                              const geometry::Subdomain& subdomain) const;
  /// Restores it. Local.
  void restore(const parallel::NumberedRows& memory, const geometry::Subdomain& subdomain);
  /// Restores releases recorded by an earlier run in the body, too. Local.
  /// @param phase_time as for BreakableBody::restore()
  /// @return the local tetrahedra whose stiffness has changed
  std::span<const std::int32_t> restore(const Releases& releases, BreakableBody& body,
                                        double phase_time = infinity);

private:
  std::unique_ptr<Criterion> criterion_;
  double screening_share_;
  std::vector<double> growth_;
  std::unique_ptr<StressAverage> average_;   // or none
  std::unique_ptr<CrackVicinity> vicinity_;  // or none
};

}  // namespace crackle::fracture
