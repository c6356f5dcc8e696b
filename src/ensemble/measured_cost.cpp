// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/stopwatch.h"
#include "dynamics/explicit_phase.h"
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "dynamics/sample_setup.h"
#include "ensemble/estimate.h"
#include "fracture/material_field.h"
#include "geometry/partition.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

namespace crackle::ensemble {

namespace {

/// Load of the measured phase relative to the first break: cracks run from all notches at once.
constexpr double overload = 1.5;
/// After the forces, the fracture check costs most, and it is due more often the faster the nodes move. A
/// phase begins at rest and ends with roughly equal kinetic and strain energy; the measured part starts with
/// this share, with the same velocity at all nodes.
constexpr double kinetic_share = 0.5;
/// Strain energy at which cracks run, relative to that of a body at its strength everywhere: 0.02 in both
/// inputs of jobs/. For bodies that start unloaded.
constexpr double energy_of_running_cracks = 0.02;
/// Agreements of the ranks that share a sample.
constexpr double agreements_per_poll = 3;

class Measurement {
public:
  Measurement(const input::Model& model, int n_frames, const geometry::Realization& realization)
      : model_(model),
        n_frames_(n_frames),
        subdomain_(geometry::split(realization, geometry::partition(realization, 1)).front()),
        setup_(self_, model, subdomain_, 0),
        account_(self_, setup_.body),
        state_{parallel::NodeField(self_, subdomain_.layout), parallel::NodeField(self_, subdomain_.layout)} {
  }

  const fracture::BodyWaves& waves() const { return setup_.waves; }

  void measure_solves(MeasuredCost& cost) {
    setup_.refuse_free_body();
    const ThreadClock first;
    dynamics::QuasiStaticLoading loading(
        setup_.motion_context(), dynamics::arrest_window(model_.time, model_.specimen.size, setup_.waves));
    cost.first_solve = first.seconds();
    loading.load_at_start(account_);
    if (!setup_.body.initial_strain().is_none())
      cost.initial = dynamics::stress_state(self_, setup_.body, loading.displacement().local());
    if (model_.time.start == input::Start::quasi_static) {
      loading.refuse_overload();
      cost.share_at_start = loading.stress_share();
    }
    const auto n_solves = loading.n_solves();
    const ThreadClock next;
    cost.outlook = dynamics::first_break(loading, setup_.loads, account_);
    cost.next_solve = loading.n_solves() > n_solves ? next.seconds() : cost.first_solve;
    if (!cost.outlook.breaks) cost.next_solve = 0;
    cost.outlook.transit = dynamics::wave_transit(model_.specimen.size, setup_.waves);
    load_time_ = loading.time();
    state_.displacement.assign(loading.displacement());
  }

  void measure_phase(MeasuredCost& cost, double seconds) {
    // Lower strength under the same load: equivalent, up to scale, to a higher load.
    fracture::FractureLaw weakened(self_, model_, 0, setup_.body, {setup_.grid.step, setup_.stable_step},
                                   {.follows_cracks = false, .weakening = overload});
    weakened.take_over(setup_.body, setup_.body.changes());
    dynamics::MotionContext context = setup_.motion_context();
    context.law = &weakened;
    agitate();
    const ThreadClock start;
    const auto motion =
        dynamics::make_motion(context, model_.time, load_time_, setup_.grid.duration(), state_);
    cost.phase_start = start.seconds();
    const ThreadClock loop;
    double measured = 0;
    std::int64_t n_polls = 0;
    dynamics::PhaseOptions options;
    options.grid = setup_.grid;
    if (model_.time.start != input::Start::rest)
      options.arrest_window = dynamics::arrest_window(model_.time, model_.specimen.size, setup_.waves);
    // No frames are stored, but the energies of each are.
    options.n_energy_rows += n_frames_;
    options.request = [&] {
      measured = loop.seconds();
      ++n_polls;
      return measured < seconds ? dynamics::Request::go_on : dynamics::Request::suspend;
    };
    options.save = [](const auto&...) {};
    try {
      const auto result = dynamics::run_explicit_phase(context, *motion, setup_.splitting, account_,
                                                       load_time_, options, state_);
      cost.n_steps = result.suspended ? n_polls * dynamics::steps_per_poll : result.n_steps;
      if (!result.suspended) measured = loop.seconds();
    } catch (const std::runtime_error&) {
      // For example fragments that fly away; the steps up to there are valid measurements.
      cost.n_steps = n_polls * dynamics::steps_per_poll;
      if (n_polls == 0) throw;
    }
    cost.step = measured / static_cast<double>(cost.n_steps);
  }

private:
  void agitate() {
    double strain = dynamics::strain_energy(self_, setup_.body, state_.displacement.local());
    if (strain == 0)
      strain =
          energy_of_running_cracks * dynamics::energy_at_strength(self_, setup_.body, setup_.law.strengths());
    const auto& masses = setup_.body.operators().node_mass;
    const double mass = std::accumulate(masses.begin(), masses.end(), 0.0);
    const double speed = std::sqrt(2 * kinetic_share * strain / mass);
    std::ranges::fill(state_.velocity.owned(), speed / std::sqrt(3.0));
  }

  parallel::Communicator self_{MPI_COMM_SELF};
  const input::Model& model_;
  int n_frames_;
  geometry::Subdomain subdomain_;
  dynamics::SampleSetup setup_;
  dynamics::EnergyAccount account_;
  dynamics::MotionState state_;
  double load_time_ = 0;
};

MeasuredCost measured_cost(const input::Model& model, int n_frames, const geometry::Realization& realization,
                           double seconds) {
  MeasuredCost cost;
  const bool at_rest = model.time.start == input::Start::rest;
  const ThreadClock setup;
  Measurement measurement(model, n_frames, realization);
  cost.setup = setup.seconds();
  cost.waves = measurement.waves();
  cost.n_nodes = static_cast<double>(realization.nodes.size());
  cost.agreements = agreements_per_poll / dynamics::steps_per_poll + (model.any_contact() ? 1 : 0);
  if (!at_rest) measurement.measure_solves(cost);
  try {
    measurement.measure_phase(cost, seconds);
  } catch (const dynamics::NumberRangeExceeded&) {
    throw;
  } catch (const std::runtime_error& error) {
    throw NotMeasured(error.what());
  }
  return cost;
}

}  // namespace

MeasuredCost measure_cost(const input::Model& model, int n_frames, const geometry::Realization& realization,
                          double seconds) {
  try {
    return measured_cost(model, n_frames, realization, seconds);
  } catch (const dynamics::NumberRangeExceeded&) {
    if (model.time.precision == input::Precision::double_) throw;
  }
  // As for a sample that leaves the range of mixed precision.
  input::Model in_double = model;
  in_double.time.precision = input::Precision::double_;
  return measured_cost(in_double, n_frames, realization, seconds);
}

}  // namespace crackle::ensemble
