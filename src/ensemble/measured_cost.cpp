// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/measured_cost.h"

#include "crackle/dynamics/explicit_phase.h"
#include "crackle/dynamics/quasi_static.h"
#include "crackle/dynamics/sample_run.h"
#include "crackle/fracture/toughness.h"
#include "crackle/geometry/partition.h"
#include "crackle/stopwatch.h"

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <utility>
#include <vector>

namespace crackle::ensemble {

namespace {

/// Load of the measured phase over that of the first break: enough for cracks to run.
constexpr double overload = 1.2;
/// Kinetic energy that the measured phase starts with, over the strain energy at the strength... of a body at
/// the
constexpr double kinetic_share = 0.25;

class Measurement {
public:
  Measurement(const input::Parameters& parameters, const geometry::Realization& realization,
              const dynamics::TimeGrid& grid)
      : parameters_(parameters),
        grid_(grid),
        subdomain_(geometry::split(realization, geometry::partition(realization, 1)).front()),
        body_(subdomain_, parameters.material, parameters.fracture.release, parameters.fracture.contact),
        loads_(mechanics::make_boundary_loads(self_, parameters, subdomain_)),
        strength_(fracture::tetrahedron_strengths(self_, parameters, subdomain_, body_.operators())),
        account_(self_, body_),
        state_{parallel::NodeField(self_, subdomain_), parallel::NodeField(self_, subdomain_)} {}

  void measure_solves(MeasuredCost& cost) {
    const fracture::TulerButcher criterion(parameters_.fracture, strength_, grid_.step);
    const ThreadClock first;
    dynamics::QuasiStaticLoading loading(self_, body_, loads_, criterion,
                                         dynamics::arrest_window(parameters_));
    cost.first_solve = first.seconds();
    const auto n_solves = loading.n_solves();
    const ThreadClock next;
    const auto end = loading.advance(account_, [&] { return loading.n_breaks() > 0; });
    cost.next_solve = loading.n_solves() > n_solves ? next.seconds() : cost.first_solve;
    if (end == dynamics::QuasiStaticEnd::no_load && loading.n_breaks() == 0) {
      cost.breaks = false;
      cost.next_solve = 0;
    }
    load_time_ = loading.time();
    state_.displacement.assign(loading.displacement());
  }

  void measure_phase(MeasuredCost& cost, double seconds) {
    // A lower strength under the load that is: the same as the load that much higher, but for the scale.
    std::vector<double> weakened = strength_;
    for (double& value : weakened) value /= overload;
    fracture::TulerButcher criterion(parameters_.fracture, weakened, grid_.step);
    const double duration = static_cast<double>(grid_.n_steps) * grid_.step;
    const dynamics::MotionContext context{&self_, &body_, &loads_, parameters_.material.density,
                                          criterion.strengths()};
    const double v = getenv("V") ? atof(getenv("V")) : 0;
    if (v != 0)
      for (std::size_t i = 0; i < state_.velocity.owned().size(); ++i)
        state_.velocity.owned()[i] = v / std::sqrt(3.0);

    const ThreadClock start;
    const auto motion =
        dynamics::make_fixed_point_motion(context, parameters_.time.precision, load_time_, duration, state_);
    cost.phase_start = start.seconds();
    const ThreadClock loop;
    double measured = 0;
    std::int64_t n_looks = 0;
    dynamics::PhaseOptions options;
    options.grid = grid_;
    if (parameters_.time.start == input::Start::quasi_static)
      options.arrest_window = dynamics::arrest_window(parameters_);
    // No frames are kept, but the energies that go with each.
    options.n_energy_rows += parameters_.output.frames;
    options.request = [&] {
      const double last = measured;
      measured = loop.seconds();
      ++n_looks;
      if (getenv("V"))
        fmt::print("{} {:.3f} ms {}\n", n_looks * 32, 1e3 * (measured - last) / 32, body_.breaks().size());
      return measured < seconds ? dynamics::Request::go_on : dynamics::Request::park;
    };
    options.save = [](const auto&...) {};
    const auto result = dynamics::run_explicit_phase(context, *motion, criterion,
                                                     dynamics::splitting(parameters_.time.integrator),
                                                     account_, load_time_, options, state_);
    cost.n_steps = result.parked ? n_looks * dynamics::steps_per_look : result.n_steps;
    if (!result.parked) measured = loop.seconds();
    cost.step = measured / static_cast<double>(cost.n_steps);
  }

private:
  parallel::Communicator self_{MPI_COMM_SELF};
  const input::Parameters& parameters_;
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
                          const dynamics::TimeGrid& grid, double seconds) {
  MeasuredCost cost;
  const ThreadClock setup;
  Measurement measurement(parameters, realization, grid);
  cost.setup = setup.seconds();
  if (parameters.time.start == input::Start::quasi_static) measurement.measure_solves(cost);
  measurement.measure_phase(cost, seconds);
  return cost;
}

}  // namespace crackle::ensemble
