// SPDX-License-Identifier: GPL-3.0-or-later
// The fast dynamics in integers: reversible to the last bit, equal with every instruction set, consistent
// with the plain double-precision dynamics, and no overloaded tetrahedron missed.
#include "dynamics/explicit_phase.h"
#include "dynamics/stable_step.h"
#include "fracture/equivalent_stress.h"
#include "fracture/softening.h"
#include "fracture/tuler_butcher.h"

#include "dynamics/fixed_point_state.h"
#include "dynamics/state_range.h"
#include "support/box_mesh.h"
#include "support/effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::Integrator;
using input::Precision;

constexpr const char* name(Precision precision) {
  return precision == Precision::mixed ? "mixed" : "double";
}

/// A block that vibrates and translates.
class VibratingBlock : public ::testing::Test {
protected:
  VibratingBlock() : VibratingBlock([](std::size_t) { return mechanics::MaterialField(test::epoxy()); }) {}
  /// @param material of a number of tetrahedra
  explicit VibratingBlock(const std::function<mechanics::MaterialField(std::size_t)>& material)
      : mesh_(test::make_box({.size = {0.004, 0.006, 0.012}, .cells = {4, 6, 12}, .disturbance = 0.2})),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, material(subdomain_.tetrahedra.size())) {
    const double stable = splitting(Integrator::bilateral4).stability_limit /
                          largest_frequency(self_, subdomain_, body_.operators(), body_.force());
    dt_ = 0.5 * stable;
  }

  MotionState start(double strain, double velocity) const {
    MotionState state{parallel::NodeField(self_, subdomain_.layout),
                      parallel::NodeField(self_, subdomain_.layout)};
    for (std::size_t n = 0; n < subdomain_.nodes.size(); ++n) {
      const auto& p = subdomain_.nodes[n];
      state.displacement.local()[3 * n + 2] = strain * 0.004 * std::sin(p[2] / 0.002);
      state.displacement.local()[3 * n] = 0.5 * strain * p[1];
      for (std::size_t i = 0; i < 3; ++i)
        state.velocity.local()[3 * n + i] = velocity * (1 + std::cos(700 * p[i]));
    }
    return state;
  }

  std::unique_ptr<MovingBody> fixed_point(Precision precision, MotionState& state, double strength = 35e6,
                                          InstructionSet set = best_instruction_set(),
                                          double screening_share = 1) {
    return make_fixed_point_motion(context(strength, screening_share), precision, 0, 1e-4, state, set);
  }

  MotionContext context(double strength, double screening_share = 1) {
    law_ = std::make_unique<fracture::FractureLaw>(
        std::make_unique<fracture::TulerButcher>(input::Fracture{.strength = strength, .exponent = 2}, 1e4,
                                                 std::vector<double>(subdomain_.tetrahedra.size(), strength),
                                                 5e-9),
        screening_share);
    return {&self_, &body_, &loads_, law_.get()};
  }

  void run(MovingBody& motion, int n_steps) const {
    const Splitting& map = splitting(Integrator::bilateral4);
    for (int step = 0; step < n_steps; ++step)
      motion.step(step % 2 == 0 ? map.even : map.odd, dt_, step * dt_);
  }

  /// @param accuracy of the energy in double precision
  void expect_plain_dynamics(int n_steps, double accuracy);
  void expect_no_overload_missed();
  void expect_energy_of_tetrahedra();

  static std::vector<double> values(const MotionState& state) {
    std::vector<double> all(state.displacement.owned().begin(), state.displacement.owned().end());
    all.insert(all.end(), state.velocity.owned().begin(), state.velocity.owned().end());
    return all;
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  mechanics::Conditions loads_;
  std::unique_ptr<fracture::FractureLaw> law_;
  double dt_ = 0;
};

/// A block of three materials with different Poisson's ratios, tetrahedron by tetrahedron.
class MixedBlock : public VibratingBlock {
protected:
  MixedBlock() : VibratingBlock(mixed) {}

private:
  static mechanics::MaterialField mixed(std::size_t n) {
    const std::array<input::Material, 3> materials{
        {{3300e6, 0.38, 1180}, {6600e6, 0.1, 2500}, {2000e6, 0.45, 900}}};
    std::vector<mechanics::IsotropicElasticity> elasticity;
    std::vector<double> density;
    for (std::size_t t = 0; t < n; ++t) {
      elasticity.emplace_back(materials[t * t % 3]);
      density.push_back(materials[t * t % 3].density);
    }
    return {mechanics::ElasticityField(std::move(elasticity)),
            mechanics::TetrahedronField<double>(std::move(density))};
  }
};

/// A block with an initial strain that changes from tetrahedron to tetrahedron, without any equilibrium.
class StrainedBlock : public VibratingBlock {
protected:
  StrainedBlock() {
    mechanics::InitialStrain::Part part{mechanics::LoadCurve(1, 0, {}), {}};
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
      auto random = RandomStream(5, 0, "strain").substream(static_cast<std::uint64_t>(t));
      auto& strain = part.strain.emplace_back();
      for (double& component : strain) component = 0.0015 * random.uniform(-1, 1);
    }
    body_.set_initial_strain({{part}, subdomain_.n_tetrahedra()});
  }
};

TEST_F(VibratingBlock, RunsBackToItsStartBitByBit) {
  for (std::int32_t t = 4; t < subdomain_.n_tetrahedra(); t += 40) body_.release(t, {}, 0, 0);
  for (const auto precision : {Precision::mixed, Precision::double_}) {
    auto state = start(0.002, 1);
    const auto motion = fixed_point(precision, state);
    const auto first = values(state);
    const int n_steps = 2000;
    run(*motion, n_steps);
    motion->read(state);
    const auto middle = values(state);
    const Splitting& map = splitting(Integrator::bilateral4);
    const auto reversed = [](std::span<const Stage> stages) {
      std::vector<Stage> back(stages.rbegin(), stages.rend());
      for (auto& stage : back) stage.fraction = -stage.fraction;
      return back;
    };
    const auto even = reversed(map.even), odd = reversed(map.odd);
    for (int step = n_steps - 1; step >= 0; --step) motion->step(step % 2 == 0 ? even : odd, dt_, 0);
    motion->read(state);
    const auto last = values(state);
    std::size_t n_moved = 0, n_different = 0;
    for (std::size_t i = 0; i < first.size(); ++i) {
      n_moved += middle[i] != first[i] ? 1 : 0;
      n_different += last[i] != first[i] ? 1 : 0;
    }
    std::printf("%s: %d steps and back: %zu of %zu numbers moved, %zu are not what they were\n",
                name(precision), n_steps, n_moved, first.size(), n_different);
    EXPECT_GT(n_moved, first.size() * 9 / 10);
    EXPECT_EQ(n_different, 0U);
  }
}

TEST_F(VibratingBlock, HasTheSameBitsWithEveryInstructionSet) {
  for (const auto precision : {Precision::mixed, Precision::double_}) {
    std::vector<double> first;
    for (const auto set : available_instruction_sets()) {
      auto state = start(0.002, 1);
      const auto motion = fixed_point(precision, state, 35e6, set);
      run(*motion, 300);
      motion->read(state);
      if (first.empty()) first = values(state);
      EXPECT_EQ(values(state), first) << name(precision) << ", " << to_string(set);
    }
    std::printf("%s: %zu instruction sets compared\n", name(precision), available_instruction_sets().size());
  }
}

// The strength lets the ends of a fragment's edge part by a quarter of its flight, 35 MPa / (density x shear
// wave speed) x duration.
TEST_F(VibratingBlock, LeavesRoomForFragmentsThatRotateInFlight) {
  const double flight = 0.25 * 35e6 / std::sqrt(1180 * 3300e6 / 2.76);
  double shortest = std::numeric_limits<double>::infinity();
  for (const auto& [a, b] : body_.edges().nodes)
    shortest = std::min(shortest, norm(subdomain_.nodes[index(a)] - subdomain_.nodes[index(b)]));
  const auto range = [&](double duration) {
    const MotionContext of = context(35e6);
    const MotionState state = start(0, 0);
    return expected_range(of, Terms(of, state, 64), 0, duration, state);
  };
  const auto brief = range(0);
  for (const double turn : {1, 20, 40, 1000}) {
    const auto mine = range(turn * shortest / flight);
    const double expected = std::clamp(turn, 16.0, 64.0);
    std::printf("flight by %4.0f shortest edges: room for %.2f of them, %.2f times the force\n", turn,
                mine.stretch / shortest, mine.force / brief.force);
    EXPECT_NEAR(mine.stretch / shortest, expected, 1e-6 * expected);
    EXPECT_NEAR(mine.force / brief.force, expected / 16, 1e-6 * expected);
  }
}

void VibratingBlock::expect_plain_dynamics(int n_steps, double accuracy) {
  // Changes in the reference motion due to the integrator's own error are subtracted.
  const auto energy_and_momentum = [&](const MotionState& state) {
    const auto v = state.velocity.owned();
    double energy = 0, momentum = 0, scale = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double m = body_.operators().node_mass[i / 3];
      energy += 0.5 * m * v[i] * v[i];
      if (i % 3 == 2) momentum += m * v[i];
      if (i % 3 == 2) scale += m * std::abs(v[i]);
    }
    for (const double e : body_.strain_energies(state.displacement.local())) energy += e;
    return std::array{energy, momentum, scale};
  };
  auto plain_state = start(0.002, 1);
  const double at_start = energy_and_momentum(plain_state)[0];
  const auto plain = make_reference_motion(context(35e6), 0, plain_state);
  run(*plain, n_steps);
  const double plain_change = energy_and_momentum(plain_state)[0] / at_start - 1;
  for (const auto precision : {Precision::mixed, Precision::double_}) {
    auto state = start(0.002, 1);
    const auto motion = fixed_point(precision, state);
    const auto before = energy_and_momentum(state);
    run(*motion, n_steps);
    motion->read(state);
    const auto after = energy_and_momentum(state);
    double worst = 0, largest = 0;
    for (std::size_t i = 0; i < state.velocity.owned().size(); ++i) {
      worst = std::max(worst, std::abs(state.velocity.owned()[i] - plain_state.velocity.owned()[i]));
      largest = std::max(largest, std::abs(plain_state.velocity.owned()[i]));
    }
    std::printf(
        "%s, %d steps: energy differs by %.1e from the plain dynamics, momentum change %.1e, velocity "
        "differs by %.1e of the largest\n",
        name(precision), n_steps, after[0] / before[0] - 1 - plain_change, (after[1] - before[1]) / before[2],
        worst / largest);
    const bool is_mixed = precision == Precision::mixed;
    EXPECT_LT(std::abs(after[0] / before[0] - 1 - plain_change), is_mixed ? 5e-5 : accuracy);
    EXPECT_LT(std::abs(after[1] - before[1]), (is_mixed ? 1e-5 : 1e-9) * before[2]);
    // Rounding adds up as in a random walk.
    EXPECT_LT(worst, (is_mixed ? 2e-3 : 1e-6) * std::sqrt(n_steps / 20000.0) * largest);
    EXPECT_FALSE(motion->failure());
  }
}

TEST_F(VibratingBlock, FollowsThePlainDynamicsOverManySteps) {
  expect_plain_dynamics(test::repetitions(1000, 20000), 1e-8);
}
TEST_F(MixedBlock, FollowsThePlainDynamicsOverManySteps) {
  // Numbers have the range of the stiffest material.
  expect_plain_dynamics(4000, 4e-8);
}
TEST_F(StrainedBlock, FollowsThePlainDynamicsOverManySteps) {
  expect_plain_dynamics(test::repetitions(1000, 4000), 1e-8);
}
TEST_F(StrainedBlock, WithBreaksFollowsThePlainDynamics) {
  auto state = start(0.002, 1), plain_state = start(0.002, 1), petsc_state = start(0.002, 1);
  const auto motion = fixed_point(Precision::double_, state);
  const auto used = context(35e6);
  const auto plain = make_reference_motion(used, 0, plain_state);
  const auto petsc = make_petsc_motion(used, 0, petsc_state);
  for (int i = 0; i < 20; ++i) {
    const std::int32_t t = 7 + 40 * i;
    // At once, and gradually.
    body_.release(t, motion->strain(t), 0, i * dt_, i % 2 == 0 ? 0 : 0.4);
    for (MovingBody* const one : {motion.get(), plain.get(), petsc.get()}) {
      one->release(std::array{t});
      run(*one, 2);
    }
  }
  motion->read(state);
  const auto expected = values(plain_state), found = values(state), by_petsc = values(petsc_state);
  double worst = 0, worst_petsc = 0, largest = 0;
  for (std::size_t i = expected.size() / 2; i < expected.size(); ++i) {
    worst = std::max(worst, std::abs(found[i] - expected[i]));
    worst_petsc = std::max(worst_petsc, std::abs(by_petsc[i] - expected[i]));
    largest = std::max(largest, std::abs(expected[i]));
  }
  std::printf("velocities differ by %.1e of the largest, by PETSc's product %.1e\n", worst / largest,
              worst_petsc / largest);
  EXPECT_LT(worst, 1e-7 * largest);
  EXPECT_LT(worst_petsc, 1e-11 * largest);
}

void VibratingBlock::expect_no_overload_missed() {
  const double strength = 15e6, share = 0.8;
  for (const auto precision : {Precision::mixed, Precision::double_}) {
    auto state = start(0.002, 1);
    const auto motion = fixed_point(precision, state, strength, best_instruction_set(), share);
    const Splitting& map = splitting(Integrator::bilateral4);
    std::size_t n_overloaded = 0, n_quiet_steps = 0;
    for (int step = 0; step < 400; ++step) {
      motion->step(step % 2 == 0 ? map.even : map.odd, dt_, step * dt_);
      std::vector<std::int32_t> expected;
      for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
        if (fracture::largest_principal(body_.intact_stress(t, motion->strain(t))) > share * strength)
          expected.push_back(t);
      }
      const auto found = motion->overloaded();
      ASSERT_EQ(std::vector<std::int32_t>(found.begin(), found.end()), expected) << "step " << step;
      n_overloaded += expected.size();
      n_quiet_steps += expected.empty() ? 1 : 0;
    }
    std::printf("%s: %zu overloads in 400 steps, %zu steps without any\n", name(precision), n_overloaded,
                n_quiet_steps);
    EXPECT_GT(n_overloaded, 1000U);
  }
}

TEST_F(VibratingBlock, NoOverloadedTetrahedronIsMissed) {
  expect_no_overload_missed();
}
TEST_F(MixedBlock, NoOverloadedTetrahedronIsMissed) {
  expect_no_overload_missed();
}
TEST_F(StrainedBlock, NoOverloadedTetrahedronIsMissed) {
  expect_no_overload_missed();
}

/// Keeps a part of its stiffness when it breaks, and in every third tetrahedron a tenth afterwards.
template <class Way>
class InParts final : public Way {
public:
  explicit InParts(double kept) : Way(fracture::Release::Course()), kept_(kept) {}
  double remaining(std::int32_t tetrahedron, double since_break) const override {
    return since_break == 0 ? kept_ : tetrahedron % 3 == 0 ? 0.1 : 0.0;
  }

private:
  double kept_;
};

/// How tetrahedra give way.
struct Loss {
  const char* name;
  input::Release release;
  input::Contact contact = input::Contact::none;
  double kept = 0;

  std::unique_ptr<fracture::Release> make(std::size_t n_tetrahedra) const {
    if (release == input::Release::softening)
      return std::make_unique<fracture::Softening>(
          fracture::SofteningLaw(input::SofteningCurve::exponential, 7),
          std::vector<double>(n_tetrahedra, 1e7));
    if (release == input::Release::facet) return std::make_unique<InParts<fracture::FacetRelease>>(kept);
    return std::make_unique<InParts<fracture::ElementRelease>>(kept);
  }
};

/// Strain energies of a body that breaks, from the motion and from its tetrahedra in double precision [J].
struct Energies {
  std::vector<double> of_motion, of_tetrahedra;
};

void VibratingBlock::expect_energy_of_tetrahedra() {
  const auto lose = [&](const Loss& loss, Precision precision, InstructionSet set) {
    const auto n = subdomain_.tetrahedra.size();
    fracture::BreakableBody body(subdomain_, body_.material(), loss.make(n), loss.contact);
    std::vector<double> strengths;
    for (std::size_t t = 0; t < n; ++t) strengths.push_back(t == 11 ? 1e20 : 2e7 * (1 + 0.3 * double(t % 5)));
    fracture::FractureLaw law(std::make_unique<fracture::TulerButcher>(
        input::Fracture{.strength = 35e6, .exponent = 2}, 1e4, std::move(strengths), 5e-9));
    auto state = start(0.002, 1);
    for (std::size_t i = 0; i < subdomain_.nodes.size(); ++i) {  // a rotation
      state.displacement.local()[3 * i] += 0.003 * subdomain_.nodes[i][2];
      state.displacement.local()[3 * i + 2] -= 0.003 * subdomain_.nodes[i][0];
    }
    const auto motion =
        make_fixed_point_motion({&self_, &body, &loads_, &law}, precision, 0, 1e-4, state, set);
    Energies energies;
    for (std::int32_t i = 0; i < 30; ++i) {
      const auto n_changes = body.changes().size();
      const auto strain = [&](std::int32_t t) { return motion->strain(t); };
      body.continue_releases(i * dt_, strain);
      for (const std::int32_t t : {7 + 30 * i, 8 + 30 * i, 11 + 30 * i})
        body.release(t, motion->strain(t), 0, i * dt_, true);
      body.release_bridges(self_, 0, i * dt_, strain);
      motion->release(body.changes().subspan(n_changes));
      run(*motion, 2);
      motion->read(state);
      energies.of_motion.push_back(motion->strain_energy(state));
      energies.of_tetrahedra.push_back(strain_energy(self_, body, state.displacement.local()));
    }
    return energies;
  };
  for (const auto& loss : {Loss{"elements", input::Release::element}, Loss{"facets", input::Release::facet},
                           Loss{"softening", input::Release::softening},
                           Loss{"in time", input::Release::element, input::Contact::none, 0.4},
                           Loss{"facets in time", input::Release::facet, input::Contact::none, 0.4},
                           Loss{"contact", input::Release::element, input::Contact::frictionless, 0.4}}) {
    for (const auto precision : {Precision::mixed, Precision::double_}) {
      const Energies energies = lose(loss, precision, best_instruction_set());
      double error = 0;
      for (std::size_t i = 0; i < energies.of_motion.size(); ++i)
        error = std::max(error, std::abs(energies.of_motion[i] / energies.of_tetrahedra[i] - 1));
      std::printf("%s, %s: strain energies differ by %.1e\n", loss.name, name(precision), error);
      EXPECT_LT(error, precision == Precision::mixed ? 3e-8 : 1e-14);
      for (const auto set : available_instruction_sets())
        EXPECT_EQ(lose(loss, precision, set).of_motion, energies.of_motion) << loss.name << to_string(set);
    }
  }
}

TEST_F(VibratingBlock, HasTheStrainEnergyOfItsTetrahedra) {
  expect_energy_of_tetrahedra();
}
TEST_F(MixedBlock, HasTheStrainEnergyOfItsTetrahedra) {
  expect_energy_of_tetrahedra();
}
TEST_F(StrainedBlock, HasTheStrainEnergyOfItsTetrahedra) {
  auto state = start(0.002, 1);
  const auto motion = fixed_point(Precision::mixed, state);
  motion->read(state);
  EXPECT_EQ(motion->strain_energy(state), strain_energy(self_, body_, state.displacement.local()));
}

TEST_F(VibratingBlock, KnowsTheStrainAtTheStartsOfItsLastTwoSteps) {
  const auto expect_known = [&](MovingBody& motion, const Splitting& map, const char* kind) {
    const auto strains = [&] {
      std::vector<mechanics::Symmetric> all;
      for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) all.push_back(motion.strain(t));
      return all;
    };
    auto now = strains(), before = now;
    for (int step = 0; step < 40; ++step) {  // beyond two unwrappings
      const auto earlier = std::exchange(before, now);
      motion.step(step % 2 == 0 ? map.even : map.odd, dt_, step * dt_);
      now = strains();
      ASSERT_NE(now, before);
      for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
        const auto i = static_cast<std::size_t>(t);
        ASSERT_EQ(motion.strain_before(t, 1), before[i]) << kind << ", step " << step << ", " << t;
        ASSERT_EQ(motion.strain_before(t, 2), earlier[i]) << kind << ", step " << step << ", " << t;
      }
    }
  };
  for (const auto integrator : {Integrator::bilateral4, Integrator::verlet}) {
    for (const auto precision : {Precision::mixed, Precision::double_}) {
      auto state = start(0.002, 1);
      expect_known(*fixed_point(precision, state), splitting(integrator), name(precision));
    }
    auto state = start(0.002, 1);
    expect_known(*make_reference_motion(context(35e6), 0, state), splitting(integrator), "reference");
  }
}

TEST_F(VibratingBlock, KnowsThemAfterARestart) {
  const Splitting& map = splitting(Integrator::verlet);
  const auto expect_known = [&](MovingBody& motion, MovingBody& other, const char* kind) {
    run(motion, 7);
    other.restore(motion.save());
    motion.step(map.even, dt_, 7 * dt_);
    other.step(map.even, dt_, 7 * dt_);
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t)
      for (const int n_steps : {1, 2})
        ASSERT_EQ(other.strain_before(t, n_steps), motion.strain_before(t, n_steps)) << kind << ", " << t;
  };
  for (const auto precision : {Precision::mixed, Precision::double_}) {
    auto state = start(0.002, 1), other = start(0.002, 1);
    expect_known(*fixed_point(precision, state), *fixed_point(precision, other), name(precision));
  }
  auto state = start(0.002, 1), other = start(0.002, 1);
  const auto motion_context = context(35e6);
  expect_known(*make_reference_motion(motion_context, 0, state),
               *make_reference_motion(motion_context, 0, other), "reference");
}

TEST_F(VibratingBlock, AStateThatOutgrowsItsNumbersIsReported) {
  auto state = start(0.002, 1);
  const auto motion = fixed_point(Precision::mixed, state);
  EXPECT_FALSE(motion->failure());
  // Far exceeds the stable step everything grows without bound.
  const Splitting& map = splitting(Integrator::bilateral4);
  int step = 0;
  while (step < 200 && !motion->failure()) {
    motion->step(step % 2 == 0 ? map.even : map.odd, 5 * dt_, 0);
    ++step;
  }
  ASSERT_TRUE(motion->failure());
  std::printf("after %d steps: %s\n", step, motion->failure()->c_str());
  EXPECT_NE(motion->failure()->find("time.precision"), std::string::npos);
}

// Numbers far out of range, many of which would look harmless when wrapped to 32 bits.

TEST_F(VibratingBlock, LoadsAndMotionsBeyondTheRangeAreReported) {
  loads_.forces.push_back({.component = 0,
                           .amplitude = mechanics::LoadCurve(1, 1e8, {}),
                           .nodes = {5},
                           .weight = {1},
                           .total_weight = 1});
  const auto loaded = loads_;
  loads_.forces.clear();
  loads_.motions.push_back({.component = 0,
                            .is_velocity = true,
                            .is_fixed = false,
                            .curve = mechanics::LoadCurve(0, 1e9, {}),
                            .nodes = {7}});
  const auto driven = loads_;
  for (const auto& [loads, what] : {std::pair(&loaded, "loaded"), std::pair(&driven, "driven")}) {
    loads_ = *loads;
    auto state = start(0, 0);
    const auto motion = fixed_point(Precision::mixed, state);
    run(*motion, 1);
    EXPECT_FALSE(motion->failure()) << what;
    int n_missed = 0;
    for (int k = 1; k <= 40; ++k) {
      const auto late = fixed_point(Precision::mixed, state);
      late->step(splitting(Integrator::verlet).even, dt_, 3.7 * k);  // as if the phase took seconds
      n_missed += late->failure() ? 0 : 1;
    }
    EXPECT_EQ(n_missed, 0) << what;
  }
}

TEST(FixedPointContact, ForcesBeyondTheRangeAreReported) {
  const auto mesh = test::make_box({.size = {0.001, 0.001, 0.001}, .cells = {1, 1, 1}});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const mechanics::Conditions loads;
  auto law = test::unbreakable(subdomain, 1e5);
  const auto fails = [&](double closing) {
    fracture::BreakableBody body(subdomain, test::epoxy(), nullptr, input::Contact::frictionless);
    // A crack through everything: the range is determined by the intact part.
    for (std::int32_t t = 0; t < subdomain.n_tetrahedra(); ++t) body.release(t, {1e-3, 0, 0, 0, 0, 0}, 0, 0);
    const MotionContext context{&self, &body, &loads, &law};
    MotionState moved{parallel::NodeField(self, subdomain.layout),
                      parallel::NodeField(self, subdomain.layout)};
    MotionState state{parallel::NodeField(self, subdomain.layout),
                      parallel::NodeField(self, subdomain.layout)};
    moved.displacement.local()[0] = closing * 0.001;
    // Cuts that overlap when a phase starts resist from there on, those of a phase that started open at once.
    const auto after = make_fixed_point_motion(context, Precision::mixed, 0, 1e-4, moved)->save().nodes;
    const auto motion = make_fixed_point_motion(context, Precision::mixed, 0, 1e-4, state);
    MotionCheckpoint checkpoint = motion->save();
    checkpoint.nodes = after;
    motion->restore(checkpoint);
    motion->step(splitting(Integrator::verlet).even, 1e-12, 0);
    return motion->failure().has_value();
  };
  EXPECT_FALSE(fails(0));
  int n_missed = 0;
  for (int k = 0; k < 100; ++k) n_missed += fails(0.5 + 0.0137 * k) ? 0 : 1;
  EXPECT_EQ(n_missed, 0);
}

TEST(FixedPointNumbers, WhatTheTypeCannotHoldIsFlagged) {
  bool in_range = true;
  EXPECT_EQ(quantized<std::int32_t>(-2147483000.4, 1, in_range), -2147483000);
  EXPECT_EQ(quantized<std::int64_t>(1e18, 1, in_range), 1000000000000000000);
  EXPECT_TRUE(in_range);
  constexpr double infinity = std::numeric_limits<double>::infinity();
  for (const double value : {0x1p31, -0x1p31, 0x1p32 + 5, 1e300, infinity, infinity - infinity}) {
    in_range = true;
    EXPECT_EQ(quantized<std::int32_t>(value, 1, in_range), 0);
    EXPECT_FALSE(in_range) << value;
  }
  quantized<std::int32_t>(1, 1, in_range);
  EXPECT_FALSE(in_range) << "a number that fits does not take it back";
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
