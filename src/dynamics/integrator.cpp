// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/integrator.h"

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

}  // namespace crackle::dynamics
