// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/explicit_phase.h"

#include "crackle/fracture/principal_stress.h"
#include "crackle/parallel/exact_sum.h"

#include <algorithm>
#include <cmath>

namespace crackle::dynamics {

namespace {

/// Steps between two looks at whether the phase has arrested: each look is a message between ranks.
constexpr std::int64_t arrest_check_interval = 16;

/// The moving body: displacement and velocity, and the external work as the splitting itself counts it.
class Motion {
public:
  Motion(const parallel::Communicator& group, fracture::BreakableBody& body,
         const mechanics::BoundaryLoads& loads, double load_time, MotionState& state)
      : group_(&group),
        body_(&body),
        loads_(&loads),
        load_time_(load_time),
        displacement_(&state.displacement),
        velocity_(&state.velocity),
        force_(state.displacement.local().size()),
        inverse_mass_(state.displacement.owned().size()) {
    for (std::size_t i = 0; i < inverse_mass_.size(); ++i)
      inverse_mass_[i] = 1 / body.operators().node_mass[i / 3];
    for (const auto& motion : loads.motions) {
      for (const auto node : motion.nodes) inverse_mass_[index(node, motion.component)] = 0;
      reaction_work_.emplace_back(motion.nodes.size(), 0.0);
    }
    for (const auto& pattern : loads.forces) rate_work_.emplace_back(pattern.nodes.size(), 0.0);
    start_ = driven_kinetic();
    set_prescribed(load_time);
    displacement_->update_ghosts();
    const auto potential = load_potential(load_time);
    start_.insert(start_.end(), potential.begin(), potential.end());
  }

  void kick(double duration, double time) {
    update_force();
    const auto f = std::span<double>(force_).first(inverse_mass_.size());
    const auto v = velocity_->owned();
    // Loads act on few nodes: they enter after the sweep over the internal force.
    for (std::size_t i = 0; i < v.size(); ++i) v[i] -= duration * inverse_mass_[i] * f[i];
    for (std::size_t k = 0; k < loads_->forces.size(); ++k) {
      const auto& pattern = loads_->forces[k];
      const double amplitude = pattern.amplitude.at(time);
      const double slope = pattern.amplitude.slope(time);
      for (std::size_t n = 0; n < pattern.nodes.size(); ++n) {
        const auto i = index(pattern.nodes[n], pattern.component);
        v[i] += duration * inverse_mass_[i] * (amplitude * pattern.weight[n]);
        rate_work_[k][n] += duration * slope * pattern.weight[n] * displacement_->owned()[i];
      }
    }
    for (std::size_t m = 0; m < loads_->motions.size(); ++m) {
      const auto& motion = loads_->motions[m];
      const double velocity = motion.velocity(time);
      if (velocity == 0) continue;
      for (std::size_t n = 0; n < motion.nodes.size(); ++n) {
        reaction_work_[m][n] += duration * velocity * f[index(motion.nodes[n], motion.component)];
      }
    }
  }

  void drift(double duration, double time_after) {
    const auto u = displacement_->owned();
    const auto v = velocity_->owned();
    for (std::size_t i = 0; i < u.size(); ++i) u[i] += duration * v[i];
    set_prescribed(time_after);
    ghosts_are_current_ = false;
    force_is_current_ = false;
  }

  void update_ghosts() {
    if (!ghosts_are_current_) displacement_->update_ghosts();
    ghosts_are_current_ = true;
  }

  void release(std::int32_t tetrahedron, double phase_time) {
    body_->release(tetrahedron, displacement_->local(), load_time_, phase_time);
    force_is_current_ = false;
  }

  double kinetic_energy() const {
    const auto v = velocity_->owned();
    const auto& mass = body_->operators().node_mass;
    std::vector<double> terms(mass.size());
    for (std::size_t n = 0; n < mass.size(); ++n) {
      terms[n] =
          0.5 * mass[n] * (v[3 * n] * v[3 * n] + v[3 * n + 1] * v[3 * n + 1] + v[3 * n + 2] * v[3 * n + 2]);
    }
    return parallel::exact_sum(*group_, terms);
  }

  /// Work of the loads since the start. With a splitting the energy that stays constant to its order is
  /// T + U - F(t).u + the sum over kicks of F'(t).u dt; this is that sum's external part, so the account
  /// closes to the integrator's order whatever the programs are.
  double external_work(double time) const {
    std::vector<double> terms = load_potential(time);
    for (const double term : start_) terms.push_back(-term);
    for (const auto& works : rate_work_) {
      for (const double work : works) terms.push_back(-work);
    }
    for (const auto& works : reaction_work_) terms.insert(terms.end(), works.begin(), works.end());
    const auto driven = driven_kinetic();
    terms.insert(terms.end(), driven.begin(), driven.end());
    return parallel::exact_sum(*group_, terms);
  }

  const parallel::NodeField& displacement() const { return *displacement_; }
  const parallel::NodeField& velocity() const { return *velocity_; }
  std::int64_t n_forces() const { return n_forces_; }

private:
  static std::size_t index(std::int32_t node, int component) {
    return 3 * static_cast<std::size_t>(node) + static_cast<std::size_t>(component);
  }

  void update_force() {
    update_ghosts();
    if (force_is_current_) return;
    body_->force().evaluate(displacement_->local(), force_);
    force_is_current_ = true;
    ++n_forces_;
  }

  void set_prescribed(double time) {
    loads_->set_displacements(time, displacement_->owned());
    for (const auto& motion : loads_->motions) {
      const double velocity = motion.velocity(time);
      for (const auto node : motion.nodes) velocity_->owned()[index(node, motion.component)] = velocity;
    }
  }

  /// Kinetic energy of the components that a prescribed motion drives: the drive supplies it.
  std::vector<double> driven_kinetic() const {
    std::vector<double> terms;
    for (const auto& motion : loads_->motions) {
      for (const auto node : motion.nodes) {
        const double v = velocity_->owned()[index(node, motion.component)];
        terms.push_back(0.5 * body_->operators().node_mass[static_cast<std::size_t>(node)] * v * v);
      }
    }
    return terms;
  }

  /// F(t).u node by node.
  std::vector<double> load_potential(double time) const {
    std::vector<double> terms;
    const auto u = displacement_->owned();
    for (const auto& pattern : loads_->forces) {
      const double amplitude = pattern.amplitude.at(time);
      for (std::size_t n = 0; n < pattern.nodes.size(); ++n) {
        terms.push_back(amplitude * pattern.weight[n] * u[index(pattern.nodes[n], pattern.component)]);
      }
    }
    return terms;
  }

  const parallel::Communicator* group_;
  fracture::BreakableBody* body_;
  const mechanics::BoundaryLoads* loads_;
  double load_time_;
  parallel::NodeField* displacement_;
  parallel::NodeField* velocity_;
  std::vector<double> force_;
  std::vector<double> inverse_mass_;            // 0 for prescribed components
  std::vector<std::vector<double>> rate_work_;  // for each pattern and node: sum of F' u dt over the kicks
  std::vector<std::vector<double>> reaction_work_;  // for each motion and node: sum of f v dt over the kicks
  std::vector<double> start_;
  bool ghosts_are_current_ = true;
  bool force_is_current_ = false;
  std::int64_t n_forces_ = 0;
};

Frame make_frame(const parallel::Communicator& group, const fracture::BreakableBody& body,
                 const Motion& motion, double time, std::int64_t n_broken) {
  const auto to_float = [](const std::vector<double>& values) {
    std::vector<float> result(values.size());
    std::ranges::transform(values, result.begin(), [](double value) { return static_cast<float>(value); });
    return result;
  };
  Frame frame{time, {}, {}, n_broken};
  frame.displacement =
      to_float(parallel::gather_nodes(group, body.subdomain(), motion.displacement().owned()));
  frame.velocity = to_float(parallel::gather_nodes(group, body.subdomain(), motion.velocity().owned()));
  return frame;
}

/// The steps after which a picture is taken; step 0 is the start.
std::vector<std::int64_t> frame_steps(int n_frames, std::int64_t n_steps) {
  std::vector<std::int64_t> steps;
  for (int k = 0; k < n_frames; ++k) {
    steps.push_back(n_frames == 1 ? n_steps : (n_steps * k + (n_frames - 1) / 2) / (n_frames - 1));
  }
  return steps;
}

}  // namespace

std::vector<std::int32_t> breaking_tetrahedra(const fracture::BreakableBody& body,
                                              std::span<const double> displacement, double time_step,
                                              fracture::TulerButcher& criterion) {
  std::vector<std::int32_t> breaking;
  // The bound holds up to rounding, hence the last digits' slack.
  const double threshold = criterion.strength() * (1 - 1e-12);
  for (std::int32_t t = 0; t < body.subdomain().n_tetrahedra(); ++t) {
    if (body.is_broken(t)) continue;
    const mechanics::Symmetric sigma = body.stress(t, displacement);
    if (fracture::largest_principal_bound(sigma) <= threshold) continue;
    const double stress = fracture::largest_principal(sigma);
    if (stress <= criterion.strength()) continue;
    if (criterion.advance(static_cast<std::size_t>(t), stress, time_step)) breaking.push_back(t);
  }
  return breaking;
}

PhaseResult run_explicit_phase(const parallel::Communicator& group, fracture::BreakableBody& body,
                               const mechanics::BoundaryLoads& loads, fracture::TulerButcher& criterion,
                               const Splitting& splitting, const EnergyAccount& account, double load_time,
                               const PhaseOptions& options, MotionState& state) {
  PhaseResult result;
  const double dt = options.grid.step;
  const std::int64_t n_steps = options.grid.n_steps;
  const std::int64_t row_interval = std::max<std::int64_t>(1, n_steps / options.n_energy_rows);
  const auto pictures = frame_steps(options.n_frames, n_steps);
  Motion motion(group, body, loads, load_time, state);

  const auto write_outputs = [&](std::int64_t step, bool last) {
    const bool is_picture = std::ranges::binary_search(pictures, step);
    if (step % row_interval != 0 && !is_picture && !last) return;
    const double time = static_cast<double>(step) * dt;
    const double work = motion.external_work(load_time + time);
    result.energy.push_back(account.row(time, motion.kinetic_energy(), work, motion.displacement()));
    if (options.on_row) options.on_row(result.energy.back());
    if (is_picture) {
      Frame frame = make_frame(group, body, motion, time, result.energy.back().broken);
      if (group.is_root()) result.frames.push_back(std::move(frame));
    }
  };

  write_outputs(0, false);
  std::int64_t last_break = 0;
  std::int64_t step = 0;
  while (step < n_steps && !result.arrested) {
    double elapsed = static_cast<double>(step);  // in steps, within the step by the drifts done
    for (const Stage& stage : step % 2 == 0 ? splitting.even : splitting.odd) {
      if (stage.kind == Stage::Kind::kick) {
        motion.kick(stage.fraction * dt, load_time + elapsed * dt);
      } else {
        elapsed += stage.fraction;
        motion.drift(stage.fraction * dt, load_time + elapsed * dt);
      }
    }
    ++step;
    motion.update_ghosts();
    for (const auto tetrahedron : breaking_tetrahedra(body, state.displacement.local(), dt, criterion)) {
      motion.release(tetrahedron, static_cast<double>(step) * dt);
      last_break = step;
    }
    if (options.arrest_window && step % arrest_check_interval == 0 && step < n_steps) {
      parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &last_break, 1, MPI_INT64_T, MPI_MAX, group.get()),
                          "MPI_Allreduce");
      result.arrested = static_cast<double>(step - last_break) * dt >= *options.arrest_window;
    }
    write_outputs(step, step == n_steps || result.arrested);
  }
  result.time = static_cast<double>(step) * dt;
  result.n_steps = step;
  result.n_forces = motion.n_forces();
  result.kinetic = result.energy.back().kinetic;
  result.external_work = motion.external_work(load_time + result.time);
  return result;
}

}  // namespace crackle::dynamics
