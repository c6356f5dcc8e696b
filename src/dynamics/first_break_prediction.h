// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/real.h"
#include "dynamics/energy_account.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_setup.h"
#include "geometry/realization.h"
#include "input/model.h"

#include <optional>
#include <span>
#include <string>

namespace crackle::dynamics {

/// An estimate of the waves that the loads of a start from rest send through the body.
struct WaveOutlook {
  /// The stress of the waves together, before any reflection [Pa]: surface tractions, density times
  /// dilatational speed times velocity, body forces over the body's length, each at its largest within the
  /// duration. Infinite for loads on lines and points and for displacements imposed at once.
  double stress = 0;
  double strength = 0;     ///< least of the body [Pa]
  bool is_sudden = false;  ///< a load is at half its peak when a wave has passed two spacings
};

/// Not collective: of a setup on one rank.
WaveOutlook wave_outlook(const SampleSetup& setup);

/// The estimate in a sentence, with advice on sudden loads; empty without any load to judge.
std::string wave_text(const input::BulkViscosity& viscosity, const WaveOutlook& outlook);

/// Extremes of the stress in a body, and its energy.
struct StressState {
  double tension = 0;      ///< largest principal stress [Pa]
  double compression = 0;  ///< largest pressure along a principal axis [Pa]
  double energy = 0;       ///< [J]
};

/// Collective. @param displacement 3 n_local
StressState stress_state(const parallel::Communicator& group, const fracture::BreakableBody& body,
                         std::span<const double> displacement);

/// Strain up to which its square, which the program neglects, is below a few percent of it.
inline constexpr double small_strain = 0.05;

/// Static prediction of the first break under the loads.
struct FirstBreakPrediction {
  bool breaks = true;        ///< the loads break the body
  bool grows = false;        ///< without a break: the loads grow without bound
  double time = infinity;    ///< of the first break, from the start of loading; infinite without one [s]
  double load = 0;           ///< of the machine at the first break, or its maximum without one [N]
  double transit = 0;        ///< of a wave along the body, see wave_transit; 0: not known [s]
  double share = 1;          ///< without a break: the largest ratio of stress to strength
  bool has_contact = false;  ///< cuts have closed by then
  double strained = 0;       ///< share of the volume strained beyond small_strain then
};

/// Loads an unbroken body up to its first break and through the equilibrium after it. Collective.
FirstBreakPrediction first_break(QuasiStaticLoading& loading, const mechanics::Conditions& loads,
                                 EnergyAccount& account);

/// Warning that the loads do not break the body in equilibrium, with the margin and advice; empty if they do.
std::string weak_load_warning(const FirstBreakPrediction& outlook);

/// Warning that a body is strained beyond small strains at the first break; empty if it is not.
std::string large_strain_warning(const FirstBreakPrediction& outlook);

/// Predictions for a start from rest.
struct RestOutlook {
  WaveOutlook waves;
  std::optional<FirstBreakPrediction>
      equilibrium;  ///< if the waves hardly break the body, and it is supported
};

/// Not collective (runs on one rank).
/// @param solves for the equilibrium too, which takes longer; none is given where there is none
RestOutlook rest_outlook(const input::Model& model, const geometry::Realization& realization, bool solves);

/// Warning that neither waves nor equilibrium come near a break; only a large margin counts.
std::string weak_load_warning(const input::Time& time, const RestOutlook& outlook);

}  // namespace crackle::dynamics
