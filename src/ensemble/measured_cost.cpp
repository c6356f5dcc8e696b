// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/measured_cost.h"

#include "crackle/common/stopwatch.h"
#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/fracture/toughness.h"
#include "crackle/geometry/partition.h"
#include "crackle/parallel/agreement.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace crackle::ensemble {

namespace {

/// Load of the measured phase over that of the first break: cracks run from all notches at once.
constexpr double overload = 1.5;
/// What costs most besides the forces, the breaking check, is due the more often the faster the nodes move. A
/// phase begins at rest and ends with about as much kinetic as strain energy; the measured part of it starts
/// with this share, all nodes alike.
constexpr double kinetic_share = 0.5;
/// Strain energy at which cracks run, over that of a body at its strength everywhere: 0.02 in both inputs of
/// jobs/. For bodies that start without load.
constexpr double energy_of_running_cracks = 0.02;

class Measurement {
public:
  Measurement(const input::Parameters& parameters, const geometry::Realization& realization,
              double stable_step, const dynamics::TimeGrid& grid)
      : parameters_(parameters),
        stable_step_(stable_step),
        grid_(grid),
        subdomain_(geometry::split(realization, geometry::partition(realization, 1)).front()),
        body_(subdomain_, parameters.material, parameters.fracture.release, parameters.fracture.contact),
        loads_(mechanics::make_boundary_loads(self_, parameters, subdomain_)),
        strength_(fracture::tetrahedron_strengths(self_, parameters, 0, subdomain_, body_.operators())),
        account_(self_, body_),
        state_{parallel::NodeField(self_, subdomain_.layout), parallel::NodeField(self_, subdomain_.layout)} {
    fracture::soften_by_input(self_, parameters, 0, body_);
  }

  void measure_solves(MeasuredCost& cost) {
    const auto criterion = fracture::make_criterion(parameters_, strength_, grid_.step);
    const auto average = fracture::make_stress_average(parameters_.fracture, body_, criterion->strengths());
    const ThreadClock first;
    dynamics::QuasiStaticLoading loading(self_, body_, loads_, *criterion,
                                         dynamics::arrest_window(parameters_), average.get());
    cost.first_solve = first.seconds();
    loading.load_at_start(account_);
    if (parameters_.time.start == input::Start::quasi_static) {
      try {
        loading.refuse_overload();
      } catch (const parallel::AgreedError& error) {
        cost.overload = error.what();
      }
    }
    const auto n_solves = loading.n_solves();
    const ThreadClock next;
    const auto end = loading.advance(account_, [&] { return loading.n_events() > 0; });
    cost.next_solve = loading.n_solves() > n_solves ? next.seconds() : cost.first_solve;
    if (end == dynamics::QuasiStaticEnd::no_load && loading.n_events() == 0) {
      cost.breaks = false;
      cost.next_solve = 0;
    }
    load_time_ = loading.time();
    if (loading.n_events() > 0) cost.first_break_time = load_time_;
    state_.displacement.assign(loading.displacement());
  }

  void measure_phase(MeasuredCost& cost, double seconds) {
    // A lower strength under the load that is: the same as the load that much higher, but for the scale.
    std::vector<double> weakened = strength_;
    for (double& value : weakened) value /= overload;
    const auto criterion = fracture::make_criterion(parameters_, weakened, grid_.step);
    fracture::update_strengths(*criterion, body_, body_.changes());
    const auto average = fracture::make_stress_average(parameters_.fracture, body_, criterion->strengths());
    const dynamics::MotionContext context{&self_,          &body_,
                                          &loads_,         parameters_.material.density,
                                          criterion.get(), criterion->screening_share(stable_step_),
                                          average.get(),   parameters_.damping_rate()};
    agitate();
    const ThreadClock start;
    const auto motion =
        dynamics::make_motion(context, parameters_.time, load_time_, grid_.duration(), state_);
    cost.phase_start = start.seconds();
    const ThreadClock loop;
    double measured = 0;
    std::int64_t n_polls = 0;
    dynamics::PhaseOptions options;
    options.grid = grid_;
    if (parameters_.time.start != input::Start::rest)
      options.arrest_window = dynamics::arrest_window(parameters_);
    // No frames are kept, but the energies that go with each.
    options.n_energy_rows += parameters_.output.frames;
    options.request = [&] {
      measured = loop.seconds();
      ++n_polls;
      return measured < seconds ? dynamics::Request::go_on : dynamics::Request::park;
    };
    options.save = [](const auto&...) {};
    try {
      const auto result =
          dynamics::run_explicit_phase(context, *motion, dynamics::splitting(parameters_.time.integrator),
                                       account_, load_time_, options, state_);
      cost.n_steps = result.parked ? n_polls * dynamics::steps_per_poll : result.n_steps;
      if (!result.parked) measured = loop.seconds();
    } catch (const std::runtime_error&) {
      // Such as small fragments that fly away; up to there the steps cost what they cost.
      cost.n_steps = n_polls * dynamics::steps_per_poll;
      if (n_polls == 0) throw;
    }
    cost.step = measured / static_cast<double>(cost.n_steps);
  }

private:
  void agitate() {
    double strain = dynamics::strain_energy(self_, body_, state_.displacement.local());
    if (strain == 0)
      strain = energy_of_running_cracks * dynamics::energy_at_strength(self_, body_, strength_);
    const auto& masses = body_.operators().node_mass;
    const double mass = std::accumulate(masses.begin(), masses.end(), 0.0);
    const double speed = std::sqrt(2 * kinetic_share * strain / mass);
    std::ranges::fill(state_.velocity.owned(), speed / std::sqrt(3.0));
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  const input::Parameters& parameters_;
  double stable_step_;
  dynamics::TimeGrid grid_;
  geometry::Subdomain subdomain_;
  fracture::BreakableBody body_;
  mechanics::BoundaryLoads loads_;
  std::vector<double> strength_;
  dynamics::EnergyAccount account_;
  dynamics::MotionState state_;
  double load_time_ = 0;
};

}  // namespace

MeasuredCost measure_cost(const input::Parameters& parameters, const geometry::Realization& realization,
                          double stable_step, const dynamics::TimeGrid& grid, double seconds) {
  MeasuredCost cost;
  const ThreadClock setup;
  Measurement measurement(parameters, realization, stable_step, grid);
  cost.setup = setup.seconds();
  if (parameters.time.start != input::Start::rest) measurement.measure_solves(cost);
  measurement.measure_phase(cost, seconds);
  return cost;
}

}  // namespace crackle::ensemble
