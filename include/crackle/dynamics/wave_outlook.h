// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/dynamics/sample_setup.h"
#include "crackle/input/parameters.h"

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
std::string wave_text(const input::Parameters& parameters, const WaveOutlook& outlook);

}  // namespace crackle::dynamics
