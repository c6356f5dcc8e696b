// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/integrator.h"

#include <array>

namespace crackle::dynamics {

namespace {

constexpr std::array<double, 4> drift{0.5153528374311229364, -0.085782019412973646, 0.4415830236164665242,
                                      0.1288461583653841854};
constexpr std::array<double, 4> kick{0.1344961992774310892, -0.2248198030794208058, 0.7563200005156682911,
                                     0.3340036032863214255};

constexpr auto K = Stage::Kind::kick;
constexpr auto D = Stage::Kind::drift;

constexpr std::array<Stage, 8> bilateral_map{{{K, kick[0]},
                                              {D, drift[0]},
                                              {K, kick[1]},
                                              {D, drift[1]},
                                              {K, kick[2]},
                                              {D, drift[2]},
                                              {K, kick[3]},
                                              {D, drift[3]}}};
constexpr std::array<Stage, 8> bilateral_adjoint{{{D, drift[3]},
                                                  {K, kick[3]},
                                                  {D, drift[2]},
                                                  {K, kick[2]},
                                                  {D, drift[1]},
                                                  {K, kick[1]},
                                                  {D, drift[0]},
                                                  {K, kick[0]}}};
constexpr std::array<Stage, 3> verlet_map{{{K, 0.5}, {D, 1.0}, {K, 0.5}}};

const Splitting bilateral4{bilateral_map, bilateral_adjoint, 1.56, 2, 3.5};
const Splitting verlet{verlet_map, verlet_map, 2.0, 1, 1.0};

}  // namespace

const Splitting& splitting(input::Integrator integrator) {
  return integrator == input::Integrator::bilateral4 ? bilateral4 : verlet;
}

void substeps_of(std::span<const Stage> stages, double time_step, double time, bool force_is_current,
                 std::vector<Substep>& substeps) {
  substeps.clear();
  double elapsed = 0;  // in steps, by the drifts done
  for (const Stage& stage : stages) {
    if (stage.kind == Stage::Kind::kick) {
      Substep& substep = substeps.emplace_back();
      substep.has_force = substep.has_kick = true;
      substep.kick = stage.fraction * time_step;
      substep.kick_time = time + elapsed * time_step;
    } else {
      if (substeps.empty() || substeps.back().has_drift) substeps.emplace_back();
      Substep& substep = substeps.back();
      substep.is_first_drift = elapsed == 0;
      elapsed += stage.fraction;
      substep.has_drift = true;
      substep.drift = stage.fraction * time_step;
      substep.drift_time = time + elapsed * time_step;
    }
  }
  for (Substep& substep : substeps) substep.step = {time, time + time_step};
  if (force_is_current && substeps.front().has_kick) substeps.front().has_force = false;
  substeps.back().keeps_force = !substeps.back().has_drift;
}

}  // namespace crackle::dynamics
