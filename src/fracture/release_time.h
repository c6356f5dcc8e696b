// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fracture/toughness.h"
#include "input/material_model.h"
#include "mechanics/tetrahedron_field.h"
#include "parallel/communicator.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace crackle::fracture {

/// v_r of a material without one of its own, as a share of its Rayleigh speed: those of glassy materials have
/// 0.3 to 0.8.
inline constexpr double usual_release_share = 0.7;

/// Tetrahedra break within some h / v_r at this overload, relative to the strength, if no impulse is given:
/// too little for it to matter.
inline constexpr double inert_overload = 0.002;

/// v_r of a material [m/s]: the input's or, with a toughness, the usual share of the Rayleigh speed; 0 where
/// the release takes a given time, or none.
double release_speed(const input::MaterialModel& model, std::size_t material);

/// Over which the stiffness of each local tetrahedron falls when it breaks in a dynamic phase [s]; 0: at
/// once. The input's time, or the local spacing over v_r: then the discrete problem of a running crack has no
/// length but the spacing, and its speed does not depend on that. Collective; bitwise equal for any number of
/// ranks.
mechanics::TetrahedronField<double> release_times(const parallel::Communicator& group,
                                                  const input::MaterialModel& model,
                                                  const BreakableBody& body);

/// The same of the tetrahedra of a whole realization. Local.
mechanics::TetrahedronField<double> release_times(const input::MaterialModel& model,
                                                  const TetrahedronSpan& tetrahedra);

/// Collective. @throws parallel::AgreedError on every rank when more than 1 % of the tetrahedra are released
/// in less than two time steps, but not at once
void refuse_short_releases(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                           const mechanics::TetrahedronField<double>& release_times, double time_step);

/// K_f of each local tetrahedron [Pa^beta s]: the input's or (inert_overload sigma_0)^beta h / v_r, with the
/// usual v_r where there is none. Collective; bitwise equal for any number of ranks.
/// @param strengths sigma_0, of which those of growth apply where there are any
mechanics::TetrahedronField<double> impulses(const parallel::Communicator& group,
                                             const input::MaterialModel& model, const BreakableBody& body,
                                             const Strengths& strengths);

/// The dissipation of a steady crack, relative to that of a slow one: Gamma / G, within 12 % of eleven of
/// twelve strips of PMMA with v_r = 200 to 1670 m/s at 0.2 to 0.6 c_R (jobs/method.md).
/// @param speed of the crack, below the Rayleigh speed [m/s]
double dissipation_ratio(double speed, double release_speed, double rayleigh_speed);

/// Cracks that are given this multiple of G.
inline constexpr double usual_drive = 2;

/// The speed at which cracks dissipate usual_drive [m/s].
double driven_crack_speed(double release_speed, double rayleigh_speed);

/// The v_r with which cracks run at a speed under usual_drive [m/s]: driven_crack_speed() inverted.
double release_speed_for(double crack_speed, double rayleigh_speed);

}  // namespace crackle::fracture
