// SPDX-License-Identifier: GPL-3.0-or-later
// Contact. A bar is broken in two and pushed together again: the crack carries compression, and nothing else.
// Waves pass a closed crack; blocks that fly meet, rebound and slide; rubble makes no energy.
#include "common/index.h"
#include "dynamics/contact_search.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/sample_run.h"
#include "dynamics/stable_step.h"
#include "mechanics/elasticity.h"

#include "support/box_mesh.h"
#include "support/effort.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <memory>
#include <numeric>
#include <span>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using input::Contact;
using plane::Face;

struct Pushed {
  double reaction;      ///< at the driven end, relative to an intact bar
  double energy_error;  ///< relative to the work
};

/// Moves the end of a bar that is broken in the middle by `strain` times its length, slowly compared with its
/// waves.
Pushed push(double strain, Contact contact, input::Release release, bool is_broken = true) {
  input::Parameters parameters;
  const geometry::Point size{0.002, 0.002, 0.01};
  parameters.specimen.size = size;
  parameters.materials[0] = test::epoxy();
  const double duration = 120e-6;
  auto moved =
      test::boundary(Face::z_max, BoundaryKind::displacement, {false, false, true}, {0, 0, strain * size[2]});
  moved.history = {{0, 0}, {duration, 1}};
  parameters.boundaries = {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), moved};
  const auto mesh = test::make_box({.size = size, .cells = {3, 3, 15}, .disturbance = 0.1});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material(), fracture::make_release({.release = release}),
                               contact);
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  const auto is_upper = [&](std::int32_t n) { return subdomain.nodes[index(n)][2] > 0.0049; };
  const mechanics::Symmetric tension{-0.38e-3, -0.38e-3, 1e-3, 0, 0, 0};
  for (std::int32_t t = 0; is_broken && t < subdomain.n_tetrahedra(); ++t) {
    const auto n = std::ranges::count_if(subdomain.tetrahedra[index(t)], is_upper);
    if (n > 0 && n < 4) body.release(t, tension, 0, 0);
  }
  body.release_bridges(self, 0, 0, [&](std::int32_t) { return mechanics::Symmetric{}; });

  auto law = test::unbreakable(subdomain);
  MotionState state{parallel::NodeField(self, subdomain.layout), parallel::NodeField(self, subdomain.layout)};
  const MotionContext context{&self, &body, &loads, &law};
  const auto& map = splitting(input::Integrator::bilateral4);
  PhaseOptions options;
  input::Time time;
  time.duration = duration;
  const double omega = largest_frequency(self, subdomain, body.operators(), body.force());
  options.grid = choose_time_grid(time, 0.5 * map.stability_limit / omega);
  const EnergyAccount account(self, body);
  const auto motion = make_fixed_point_motion(context, input::Precision::double_, 0, duration, state);
  auto phase = run_explicit_phase(context, *motion, map, account, 0, options, state);
  // The energy of the prior breaks is not part of this motion.
  for (auto& row : phase.energy) row.released = 0;
  const double unbroken = parameters.materials[0].youngs_modulus * size[0] * size[1] * std::abs(strain);
  return {
      std::abs(measure_loads(self, body, loads, state.displacement, duration).conditions.back().reaction[2]) /
          unbroken,
      energy_error(phase.energy)};
}

TEST(Contact, OfABrokenBarCarriesCompressionOnly) {
  for (const auto release : {input::Release::element, input::Release::facet}) {
    const char* name = release == input::Release::element ? "element" : "facet";
    const Pushed whole = push(-1e-3, Contact::none, release, false);
    const Pushed with = push(-1e-3, Contact::frictionless, release);
    const Pushed pulled = push(1e-3, Contact::frictionless, release);
    const Pushed without = push(-1e-3, Contact::none, release);
    std::printf(
        "%s: pushed back, the end carries %.3f of the unbroken bar's force with contact (energy error "
        "%.1e), %.1e without; pulled %.1e\n",
        name, with.reaction / whole.reaction, with.energy_error, without.reaction, pulled.reaction);
    EXPECT_NEAR(with.reaction, whole.reaction, 0.1 * whole.reaction);
    EXPECT_LT(with.energy_error, 1e-3);
    EXPECT_LT(without.reaction, 0.05);
    EXPECT_LT(pulled.reaction, 0.05);
  }
}

/// An unbreakable body of the box's epoxy with contact, in motion from a state at time 0, on one rank.
class Meeting {
public:
  using IsBroken = std::function<bool(const std::array<geometry::Point, 4>& corners)>;
  /// @param start displacement and velocity of a node at its place
  Meeting(const test::BoxMesh& box, std::vector<input::Boundary> boundaries, double friction,
          input::Integrator integrator, double duration, const IsBroken& is_broken,
          const std::function<std::pair<Vector, Vector>(const geometry::Point&)>& start,
          Contact contact = Contact::frictionless)
      : mesh_(test::make_box(box)),
        subdomain_(test::whole(mesh_)),
        body_(subdomain_, test::epoxy(), nullptr, contact, friction),
        law_(test::unbreakable(subdomain_)),
        state_{parallel::NodeField(self_, subdomain_.layout), parallel::NodeField(self_, subdomain_.layout)},
        map_(splitting(integrator)) {
    input::Parameters parameters;
    parameters.specimen.size = box.size;
    parameters.materials[0] = test::epoxy();
    parameters.boundaries = std::move(boundaries);
    loads_ = mechanics::make_boundary_loads(self_, parameters, subdomain_);
    for (std::int32_t t = 0; t < subdomain_.n_tetrahedra(); ++t) {
      std::array<geometry::Point, 4> corners{};
      for (std::size_t a = 0; a < 4; ++a) corners[a] = place(subdomain_.tetrahedra[index(t)][a]);
      if (is_broken && is_broken(corners)) body_.release(t, {-0.38e-3, -0.38e-3, 1e-3, 0, 0, 0}, 0, 0);
    }
    for (std::int32_t n = 0; n < subdomain_.n_local(); ++n) {
      const auto [u, v] = start(place(n));
      for (std::size_t i = 0; i < 3; ++i) {
        state_.displacement.owned()[index(n, 0) + i] = u[i];
        state_.velocity.owned()[index(n, 0) + i] = v[i];
      }
    }
    MotionContext context{&self_, &body_, &loads_, &law_};
    context.contact =
        contact_scale(self_, subdomain_, body_.operators(), body_.force(), {.friction = friction});
    const double omega = largest_frequency(self_, subdomain_, body_.operators(), body_.force());
    input::Time time;
    time.duration = duration;
    grid_ = choose_time_grid(time, map_.stability_limit / omega / std::sqrt(1.2));
    motion_ = make_fixed_point_motion(context, input::Precision::double_, 0, duration, state_);
    motion_->read(state_);
    energy_at_start_ = kinetic() + motion_->strain_energy(state_);
  }

  bool advance() {
    motion_->step(n_steps_ % 2 == 0 ? map_.even : map_.odd, grid_.step, time());
    ++n_steps_;
    EXPECT_EQ(motion_->failure(), std::nullopt);
    return n_steps_ < grid_.n_steps;
  }
  double time() const { return static_cast<double>(n_steps_) * grid_.step; }
  const geometry::Point& place(std::int32_t node) const { return subdomain_.nodes[index(node)]; }
  /// Mean of a velocity component, by mass, over the nodes at some places.
  double velocity(int component, const std::function<bool(const geometry::Point&)>& is_there) {
    motion_->read(state_);
    double mass = 0, momentum = 0;
    for (std::int32_t n = 0; n < subdomain_.n_local(); ++n) {
      if (!is_there(place(n))) continue;
      mass += body_.operators().node_mass[index(n)];
      momentum += body_.operators().node_mass[index(n)] * state_.velocity.owned()[index(n, component)];
    }
    return momentum / mass;
  }
  double kinetic() const {
    double sum = 0;
    for (std::size_t i = 0; i < state_.velocity.owned().size(); ++i)
      sum += 0.5 * body_.operators().node_mass[i / 3] * std::pow(state_.velocity.owned()[i], 2);
    return sum;
  }
  /// Energy that has come from nowhere, relative to the kinetic energy at the start.
  double energy_error() {
    motion_->read(state_);
    const double now = kinetic() + motion_->strain_energy(state_) + motion_->dissipated_energy() -
                       motion_->external_work(time(), state_);
    return (now - energy_at_start_) / energy_at_start_;
  }
  double dissipated() const { return motion_->dissipated_energy(); }

private:
  parallel::Communicator self_{MPI_COMM_SELF};
  geometry::Realization mesh_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  fracture::FractureLaw law_;
  mechanics::Conditions loads_;
  MotionState state_;
  const Splitting& map_;
  TimeGrid grid_{};
  std::unique_ptr<MovingBody> motion_;
  double energy_at_start_ = 0;
  std::int64_t n_steps_ = 0;
};

const double modulus = 3300e6 * (1 - 0.38) / ((1 + 0.38) * (1 - 2 * 0.38)), density = 1180;
const double longitudinal = std::sqrt(modulus / density);
const double transverse = std::sqrt(3300e6 / (2 * 1.38) / density);

/// Tetrahedra cut by a plane across z.
Meeting::IsBroken cut_at(double z) {
  return [=](const std::array<geometry::Point, 4>& corners) {
    const auto n = std::ranges::count_if(corners, [&](const auto& x) { return x[2] > z; });
    return n > 0 && n < 4;
  };
}

std::pair<Vector, Vector> at_rest(const geometry::Point&) {
  return {};
}

/// A plane wave of compression along z, from a face that is pushed: passes a closed crack as if there were
/// none.
TEST(Contact, AClosedCrackLetsCompressionPass) {
  const double length = 0.02, speed = 1, section = 0.0175, rise = 1e-6;
  const std::array<double, 3> size{0.0015, 0.0015, length};
  std::vector<input::Boundary> boundaries{
      test::boundary(Face::z_min, BoundaryKind::velocity, {true, true, true}, {0, 0, speed})};
  boundaries[0].history = {{0, 0}, {rise, 1}};
  for (const auto face : {Face::x_min, Face::x_max})
    boundaries.push_back(test::boundary(face, BoundaryKind::fix, {true, false, false}));
  for (const auto face : {Face::y_min, Face::y_max})
    boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const auto integrator : {input::Integrator::verlet, input::Integrator::bilateral4}) {
    struct Front {
      double time = 0, height = 0;
    };
    const auto front = [&](bool is_cut, Contact contact) {
      Meeting bar({.size = size, .cells = {3, 3, 40}, .disturbance = 0.1}, boundaries, 0, integrator, 10.5e-6,
                  is_cut ? cut_at(0.01 - 1e-4) : nullptr, at_rest, contact);
      const auto there = [&](const geometry::Point& x) { return std::abs(x[2] - section) < 0.0004; };
      Front front;
      double sum = 0;
      int n = 0;
      while (bar.advance()) {
        const double v = bar.velocity(2, there);
        if (front.time == 0 && v > speed / 2) front.time = bar.time();
        // The plateau behind the front, before the far end's reflection.
        if (bar.time() > section / longitudinal + rise && bar.time() < (2 * length - section) / longitudinal)
          sum += v, ++n;
      }
      front.height = sum / n;
      return front;
    };
    const Front whole = front(false, Contact::none), with = front(true, Contact::frictionless),
                without = front(true, Contact::none);
    std::printf(
        "compression through a closed crack, %s: front at %.3f us (unbroken %.3f, exact %.3f), height %.4f "
        "(unbroken %.4f), without contact %.4f\n",
        integrator == input::Integrator::verlet ? "verlet" : "bilateral4", 1e6 * with.time, 1e6 * whole.time,
        1e6 * (section / longitudinal + rise / 2), with.height, whole.height, without.height);
    EXPECT_NEAR(with.time, whole.time, 0.02 * whole.time);
    EXPECT_NEAR(with.height, whole.height, 0.02 * whole.height);
    EXPECT_LT(without.height, 0.1);
  }
}

/// Compression and shear start together; the shear arrives later, and passes the crack up to the friction.
TEST(Contact, FrictionLimitsTheShearThatPasses) {
  const std::array<double, 3> size{0.04, 0.001, 0.012};
  const double speed = 1, crack = 0.003, section = 0.005;
  std::vector<input::Boundary> boundaries{
      test::boundary(Face::z_min, BoundaryKind::velocity, {true, true, true}, {speed, 0, speed})};
  boundaries[0].history = {{0, 0}, {1e-6, 1}};

  for (const auto face : {Face::y_min, Face::y_max})
    boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  const auto passed = [&](double friction, bool is_cut) {
    Meeting block({.size = size, .cells = {80, 2, 24}, .disturbance = 0.1}, boundaries, friction,
                  input::Integrator::verlet, 8e-6, is_cut ? cut_at(crack - 1e-4) : nullptr, at_rest);
    double sum = 0;
    int n = 0;
    while (block.advance())
      if (block.time() > 6.2e-6) {
        sum += block.velocity(0, [&](const geometry::Point& x) {
          return std::abs(x[2] - section) < 0.0004 && std::abs(x[0] - size[0] / 2) < 0.002;
        });
        ++n;
      }

    return sum / n;
  };
  const double whole = passed(0, false);
  for (const double friction : {0.0, 0.3, 2.0}) {
    const double expected = std::min(1.0, friction * longitudinal / transverse);
    const double found = passed(friction, true) / whole;
    std::printf("shear through a closed crack, friction %.1f: %.3f of the unbroken block's (Coulomb %.3f)\n",
                friction, found, expected);
    EXPECT_NEAR(found, expected, 0.1);
  }
}

/// Two bars of one mesh, apart by a row of cells that is left out, fly towards each other.
TEST(Contact, BarsThatMeetRebound) {
  const double cell = 0.0005, length = 0.006, speed = 5;
  const std::array<double, 3> size{0.0015, 0.0015, 2 * length + cell};
  std::vector<input::Boundary> boundaries;
  for (const auto face : {Face::x_min, Face::x_max})
    boundaries.push_back(test::boundary(face, BoundaryKind::fix, {true, false, false}));
  for (const auto face : {Face::y_min, Face::y_max})
    boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  const auto is_lower = [&](const geometry::Point& x) { return x[2] < length + cell / 2; };
  for (const auto integrator : {input::Integrator::verlet, input::Integrator::bilateral4}) {
    Meeting bars(
        {.size = size,
         .cells = {3, 3, 25},
         .removed = [&](const geometry::Point& x) { return std::abs(x[2] - size[2] / 2) < cell / 2; }},
        boundaries, 0.3, integrator, 12e-6, nullptr, [&](const geometry::Point& x) {
          const double close = 0.4999 * cell;
          return is_lower(x) ? std::pair<Vector, Vector>{{0, 0, close}, {0, 0, speed}}
                             : std::pair<Vector, Vector>{{0, 0, -close}, {0, 0, -speed}};
        });
    double from = 0, to = 0;
    while (bars.advance()) {
      const double v = bars.velocity(2, is_lower) / speed;
      if (from == 0 && v < 0.8) from = bars.time();
      if (to == 0 && v < -0.8) to = bars.time();
    }
    const double duration = 2 * length / longitudinal, found = (to - from) / 0.8;
    const double stress = density * length * 1.6 * speed / (to - from);
    std::printf(
        "bars that meet: contact lasts %.3f us (exact %.3f), stress %.3f MPa (exact %.3f), velocity after "
        "%.4f "
        "of that before, energy error %.1e, dissipated %.1e of the energy\n",
        1e6 * found, 1e6 * duration, 1e-6 * stress, 1e-6 * density * longitudinal * speed,
        bars.velocity(2, is_lower) / speed, bars.energy_error(), bars.dissipated() / bars.kinetic());
    EXPECT_NEAR(found, duration, 0.05 * duration);
    EXPECT_NEAR(bars.velocity(2, is_lower), -speed, 0.03 * speed);
    EXPECT_LT(std::abs(bars.energy_error()), 2e-3);
  }
}

/// A block pressed on another one slides, and friction stops it.
TEST(Contact, ABlockSlidesByCoulombsLaw) {
  const double cell = 0.0005, friction = 0.3, pressure = 1e6, height = 0.001, speed = 3;
  const std::array<double, 3> size{0.003, 0.003, 2 * height + cell};
  auto pressed = test::boundary(Face::z_max, BoundaryKind::traction, {}, {0, 0, -pressure});
  const auto is_upper = [&](const geometry::Point& x) { return x[2] > height + cell / 2; };
  Meeting blocks(
      {.size = size,
       .cells = {6, 6, 5},
       .removed = [&](const geometry::Point& x) { return std::abs(x[2] - size[2] / 2) < cell / 2; }},
      {test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}), pressed}, friction,
      input::Integrator::verlet, 20e-6, nullptr, [&](const geometry::Point& x) {
        return is_upper(x)
                   ? std::pair<Vector, Vector>{{0.1 * cell, 0.07 * cell, -0.99999 * cell}, {speed, 0, 0}}
                   : std::pair<Vector, Vector>{};
      });
  const double deceleration = friction * pressure / (density * height);
  double stopped = 0;
  while (blocks.advance())
    if (stopped == 0 && blocks.velocity(0, is_upper) < 0.05 * speed) stopped = blocks.time();
  std::printf(
      "a block slides for %.3f us (Coulomb %.3f), then moves with %.3f of its speed; energy error %.1e, "
      "dissipated %.3f of the kinetic energy\n",
      1e6 * stopped, 0.95e6 * speed / deceleration, blocks.velocity(0, is_upper) / speed,
      blocks.energy_error(),
      blocks.dissipated() / (0.5 * density * size[0] * size[1] * height * speed * speed));
  EXPECT_NEAR(stopped, 0.95 * speed / deceleration, 0.1 * speed / deceleration);
  EXPECT_LT(std::abs(blocks.velocity(0, is_upper)), 0.1 * speed);
  EXPECT_LT(std::abs(blocks.energy_error()), 5e-3);
}

/// A brittle block crushed between two moving faces into rubble.
TEST(Contact, RubbleMakesNoEnergy) {
  const parallel::Communicator self(MPI_COMM_SELF);
  for (const auto release : {input::Release::element, input::Release::facet}) {
    for (const auto integrator : {input::Integrator::verlet, input::Integrator::bilateral4}) {
      double error_without = 0;
      for (const bool has_contact : {false, true}) {
        auto parameters = test::brittle({0.003, 0.003, 0.004});
        parameters.fracture.release = release;
        parameters.time.start = input::Start::rest;
        parameters.time.integrator = integrator;
        parameters.time.precision = input::Precision::double_;
        parameters.time.duration = 3e-5;
        parameters.boundaries = {
            test::boundary(Face::z_min, BoundaryKind::fix, {true, true, true}),
            test::boundary(Face::z_max, BoundaryKind::velocity, {true, true, true}, {0, 0, -12})};
        if (has_contact) parameters.contact = input::SurfaceContact{.friction = 0.3};
        const auto subdomain = test::whole(
            test::make_box({.size = parameters.specimen.size, .cells = {6, 6, 8}, .disturbance = 0.2}));
        const auto result = run_sample(self, parameters, parameters.output, subdomain);
        const EnergyRow& last = result.energy.back();
        const double work = std::abs(last.external);
        std::printf(
            "crushed, %s, %s, contact %d: %lld broken, work %.3e J, energy error %.1e, dissipated %.3f of "
            "the "
            "work, released %.3f\n",
            release == input::Release::element ? "element" : "facet",
            integrator == input::Integrator::verlet ? "verlet" : "bilateral4", has_contact ? 1 : 0,
            static_cast<long long>(last.broken), work, energy_error(result.energy), last.dissipated / work,
            last.released / work);
        if (!has_contact) error_without = energy_error(result.energy);
        EXPECT_LT(energy_error(result.energy), error_without + 1e-3);
      }
    }
  }
}

/// Bodies of which random tetrahedra are broken, in random motion.
TEST(Contact, RandomRubbleStaysSound) {
  const int n = test::repetitions(40, 400);
  // Largest with verlet and bilateral4, with contact and without.
  std::array<std::array<double, 2>, 2> made{};
  double dissipated = 0;
  for (int k = 0; k < n; ++k)
    for (const auto contact : {Contact::frictionless, Contact::none}) {
      const RandomStream random(7, static_cast<std::uint64_t>(k), "rubble");
      auto stream = random.substream(0);
      const double share = stream.uniform(0.1, 0.9), speed = std::exp(stream.uniform(0, 5));
      const double friction = stream.uniform(-0.3, 1);
      auto breaks = random.substream(1), moves = random.substream(2);
      const geometry::Point size{0.002, 0.002, 0.003};
      Meeting rubble(
          {.size = size, .cells = {4, 4, 6}, .disturbance = 0.2}, {}, std::max(friction, 0.0),
          k % 2 == 0 ? input::Integrator::verlet : input::Integrator::bilateral4, 4e-6,
          [&](const auto&) { return breaks.uniform(0, 1) < share; },
          [&](const geometry::Point& x) {
            // Towards the middle, and anyhow.
            Vector v{};
            for (std::size_t i = 0; i < 3; ++i)
              v[i] = speed * (1 - 2 * x[i] / size[i] + moves.uniform(-0.3, 0.3));
            return std::pair<Vector, Vector>{{}, v};
          },
          contact);
      while (rubble.advance()) {
      }
      const double error = rubble.energy_error();
      EXPECT_TRUE(std::isfinite(error)) << k;
      double& largest = made[contact == Contact::none ? 1 : 0][index(k % 2)];
      largest = std::max(largest, error);
      dissipated = std::max(dissipated, rubble.dissipated());
    }
  std::printf(
      "%d random bodies: energy made %.1e of that at the start at most with verlet (%.1e without contact), "
      "%.1e "
      "(%.1e) with bilateral4; %.1e J dissipated at most\n",
      n, made[0][0], made[1][0], made[0][1], made[1][1], dissipated);
  for (const std::size_t integrator : {0U, 1U}) EXPECT_LT(made[0][integrator], made[1][integrator] + 2e-3);
  EXPECT_GT(dissipated, 0);
}

TEST(Contact, StiffnessKeepsTheStableStep) {
  const double share = 0.5;
  const auto mesh = test::make_box({.size = {0.003, 0.002, 0.004}, .cells = {6, 4, 8}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  const fracture::BreakableBody body(subdomain, test::epoxy());
  const double omega = largest_frequency(self, subdomain, body.operators(), body.force());
  const auto step = [&](std::span<const mechanics::NodeStiffness> springs) {
    return stable_step(self, input::Integrator::verlet, {}, subdomain, body.operators(), body.material(),
                       body.force(), springs);
  };
  const auto areas = surface_areas(subdomain);
  EXPECT_NEAR(std::accumulate(areas.begin(), areas.end(), 0.0), 52e-6, 1e-12);
  const double free = step({});
  const ContactScale scale{.rate = share * omega * omega};
  input::Model model;
  model.contact.emplace();
  const double least = free / std::sqrt(1 + share);
  EXPECT_NEAR(step(largest_contact(self, model, subdomain, body.operators(), scale)), least, 0.002 * least);
  // Tools alone touch the surface.
  model.contact.reset();
  model.tools.emplace_back();
  const double with_tools = step(largest_contact(self, model, subdomain, body.operators(), scale));
  std::printf("stable step %.4g ns, with contact %.4g, with tools %.4g\n", 1e9 * free, 1e9 * least,
              1e9 * with_tools);
  EXPECT_LT(with_tools, free);
  EXPECT_GT(with_tools, 0.999 * free / std::sqrt(1 + tool_factor * share));
}

/// The gap between a node and a face is what a motion of both together must overcome: none for a node in the
/// prism below the face, however the face is turned.
TEST(ContactGap, IsZeroBelowAFaceAndTheDistanceOutside) {
  const double depth = 0.3;
  for (const Vector& way : {Vector{0, 0, 1}, Vector{0.6, 0, 0.8}, Vector{0.36, 0.48, 0.8}}) {
    const Vector across =
        std::abs(way[0]) < 0.1 ? Vector{1, 0, 0} : cross(way, {0, 1, 0}) / norm(cross(way, {0, 1, 0}));
    const Vector beside = cross(way, across);
    const std::array<Vector, 3> face{Vector{}, across, beside};
    const Vector middle = (face[0] + face[1] + face[2]) / 3.0;
    for (const double below : {0.0, 0.1, 0.29})
      EXPECT_LE(contact_gap(middle - below * way, face, way, depth), 1e-12);
    EXPECT_NEAR(contact_gap(middle + 0.1 * way, face, way, depth), 0.1, 1e-12);
    EXPECT_NEAR(contact_gap(middle - 0.5 * way, face, way, depth), 0.2, 1e-12);
  }
  const std::array<Vector, 3> level{Vector{}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_NEAR(contact_gap({1.5, 0.1, -0.1}, level, {0, 0, 1}, depth), 0.5 - 2 * found_beyond, 1e-12);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
