// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "dynamics/energy_account.h"
#include "dynamics/sample_result.h"
#include "fracture/breakable_body.h"
#include "input/model.h"
#include "mechanics/conditions.h"
#include "parallel/communicator.h"
#include "parallel/node_field.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace crackle::dynamics {

/// Points of the body at which its state is recorded. Displacement and velocity are interpolated linearly in
/// the tetrahedron containing the point; so is the stress, from nodal values that are volume-weighted means
/// over the adjacent tetrahedra.
class Probes {
public:
  /// Locates the points in this realization; a point left outside by the faceted surface is moved to the
  /// nearest tetrahedron. Collective. The body must outlive the object.
  Probes(const parallel::Communicator& group, const fracture::BreakableBody& body,
         const std::vector<input::Probe>& probes);

  /// The values at all points, bitwise equal on every rank and for any partition. Collective.
  /// @param displacement with current ghosts
  /// @param velocity of a moving body, or nullptr
  std::vector<ProbeValue> read(const parallel::NodeField& displacement,
                               const parallel::NodeField* velocity) const;

private:
  /// This rank's contribution to the values at one point.
  struct Place {
    std::vector<std::pair<std::int32_t, double>> nodes;       ///< owned nodes with their weights
    std::vector<std::pair<std::int32_t, double>> tetrahedra;  ///< tetrahedra around these nodes, likewise
  };

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  std::vector<Place> places_;
};

/// Records a sample's history. All members are collective unless stated otherwise; the rows are equal on
/// every rank, bitwise for any number of ranks.
class HistoryRecorder {
public:
  /// The references must outlive the object.
  HistoryRecorder(const parallel::Communicator& group, const fracture::BreakableBody& body,
                  const mechanics::Conditions& loads, const EnergyAccount& account,
                  const std::vector<input::Probe>& probes)
      : group_(&group), body_(&body), loads_(&loads), account_(&account), probes_(group, body, probes) {}

  /// An equilibrium at this load time, with its loads.
  void record_equilibrium(double load_time, const LoadState& loads, const parallel::NodeField& displacement);

  /// A moment of a dynamic phase.
  /// @param phase its number, counted from 1
  /// @param load_time at the start of the phase [s]
  /// @param energy at that moment
  /// @param displacement with current ghosts
  /// @param loads of all terms
  /// @param is_output as in HistoryRow
  void record_motion(std::int32_t phase, double load_time, const EnergyRow& energy,
                     const parallel::NodeField& displacement, const parallel::NodeField& velocity,
                     const LoadState& loads, bool is_output);

  /// Continues after rows of an earlier run. Local.
  void append(std::span<const HistoryRow> rows) { rows_.insert(rows_.end(), rows.begin(), rows.end()); }

  /// Local.
  const std::vector<HistoryRow>& rows() const { return rows_; }
  /// The rows of one dynamic phase. Local.
  std::vector<HistoryRow> rows_of_phase(std::int32_t phase) const;

private:
  void add(HistoryRow row, const LoadState& state, const parallel::NodeField& displacement,
           const parallel::NodeField* velocity);

  const parallel::Communicator* group_;
  const fracture::BreakableBody* body_;
  const mechanics::Conditions* loads_;
  const EnergyAccount* account_;
  Probes probes_;
  std::vector<HistoryRow> rows_;
};

}  // namespace crackle::dynamics
