// SPDX-License-Identifier: GPL-3.0-or-later
// Cost of the time loop compared with the machine's limits and with PETSc, side by side in one run.
//
//   mpirun -n 2 benchmark_time_loop INPUT [--rounds N] [--json FILE]
//
// Every figure is the median over rounds in which all candidates take turns. Rank 0 measures while rank 1
// sleeps; finally both run the time loop at once, each on a separate body.
#include "common/stopwatch.h"
#include "dynamics/breaking_check.h"
#include "dynamics/moving_body.h"
#include "dynamics/quasi_static.h"
#include "dynamics/stable_step.h"
#include "fracture/fracture_law.h"
#include "fracture/material_field.h"
#include "geometry/body.h"
#include "geometry/mother_points.h"
#include "geometry/partition.h"
#include "geometry/realization.h"
#include "input/reader.h"
#include "mechanics/fixed_point_force.h"
#include "mechanics/static_solver.h"
#include "parallel/sleeping_wait.h"

#include "plain_delaunay.h"
#include "run_benchmark.h"

#include <fmt/format.h>
#include <mpi.h>
#include <petscksp.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace crackle;

/// Seconds per candidate and round.
class Rounds {
public:
  void add(const std::string& name, double seconds) { seconds_[name].push_back(seconds); }
  /// Runs `work` `repeats` times and records the seconds per run.
  void time(const std::string& name, int repeats, const std::function<void()>& work) {
    const Stopwatch watch;
    for (int i = 0; i < repeats; ++i) work();
    add(name, watch.seconds() / repeats);
  }
  double median(const std::string& name) const {
    auto values = seconds_.at(name);
    std::ranges::sort(values);
    return values[values.size() / 2];
  }

private:
  std::map<std::string, std::vector<double>> seconds_;
};

/// The body of an input's sample 0 with all data of a sample.
struct Sample {
  parallel::Communicator self{MPI_COMM_SELF};
  input::Parameters parameters;
  geometry::Body geometry;
  geometry::MotherPoints base;
  geometry::Realization realization;
  geometry::Subdomain subdomain;
  fracture::BreakableBody body;
  mechanics::Conditions loads;

  explicit Sample(const input::Parameters& input)
      : parameters(input),
        geometry(*geometry::make_body(input.specimen)),
        base(geometry::make_mother_points(geometry, input.mesh, input.seed)),
        realization(geometry::make_realization(geometry, base, input.mesh, input.seed, 0)),
        subdomain(geometry::split(realization, geometry::partition(realization, 1)).front()),
        body(subdomain, fracture::make_material_field(input, 0, fracture::span_of(subdomain))),
        loads(mechanics::make_boundary_loads(self, input, subdomain)) {}

  /// @param stable, step as FractureLaw::Steps
  std::unique_ptr<fracture::FractureLaw> law(double step, double stable = infinity) {
    return std::make_unique<fracture::FractureLaw>(self, parameters, 0, body,
                                                   fracture::FractureLaw::Steps{step, stable},
                                                   fracture::FractureLaw::Options{.follows_cracks = false});
  }
  dynamics::MotionContext context(fracture::FractureLaw& law) { return {&self, &body, &loads, &law}; }
};

/// The input with a Young's modulus that varies in space.
input::Parameters with_variation(input::Parameters parameters) {
  for (input::Material& material : parameters.materials)
    material.variation =
        input::StiffnessVariation{.coefficient_of_variation = 0.1, .correlation_length = 2e-3};
  return parameters;
}

double triad(std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& c,
             int repeats) {
  const Stopwatch watch;
  for (int r = 0; r < repeats; ++r) {
    for (std::size_t i = 0; i < a.size(); ++i) a[i] = b[i] + 3.0 * c[i];
    asm volatile("" : : "r"(a.data()) : "memory");
  }
  return watch.seconds() / repeats;
}

/// PETSc's product with the assembled stiffness, in one of its formats.
class PetscProduct {
public:
  PetscProduct(Sample& sample, MatType type) {
    const auto& operators = sample.body.operators();
    const PetscInt n = 3 * sample.subdomain.layout.n_owned;
    MatCreateSeqAIJ(MPI_COMM_SELF, n, n, 60, nullptr, &matrix_);
    MatSetBlockSize(matrix_, 3);
    MatSetOption(matrix_, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE);
    for (const auto& t : operators.tetrahedra) {
      std::array<double, 144> block{};
      std::array<PetscInt, 12> rows{};
      const auto& c = sample.body.elasticity()[0];
      for (std::size_t a = 0; a < 4; ++a) {
        for (std::size_t i = 0; i < 3; ++i) rows[3 * a + i] = 3 * t.nodes[a] + static_cast<PetscInt>(i);
        for (std::size_t b = 0; b < 4; ++b)
          for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = 0; j < 3; ++j) {
              const auto& g = t.gradient;
              double k = c.lambda * g[a][i] * g[b][j] + c.mu * g[b][i] * g[a][j];
              if (i == j) k += c.mu * dot(g[a], g[b]);
              block[12 * (3 * a + i) + 3 * b + j] = t.volume * k;
            }
      }
      MatSetValues(matrix_, 12, rows.data(), 12, rows.data(), block.data(), ADD_VALUES);
    }
    MatAssemblyBegin(matrix_, MAT_FINAL_ASSEMBLY);
    MatAssemblyEnd(matrix_, MAT_FINAL_ASSEMBLY);
    MatSetOption(matrix_, MAT_SYMMETRIC, PETSC_TRUE);
    MatConvert(matrix_, type, MAT_INPLACE_MATRIX, &matrix_);
    MatCreateVecs(matrix_, &x_, &y_);
    VecSet(x_, 1e-6);
  }
  PetscProduct(const PetscProduct&) = delete;
  PetscProduct& operator=(const PetscProduct&) = delete;
  ~PetscProduct() {
    VecDestroy(&x_);
    VecDestroy(&y_);
    MatDestroy(&matrix_);
  }
  void operator()() { MatMult(matrix_, x_, y_); }

private:
  Mat matrix_ = nullptr;
  Vec x_ = nullptr, y_ = nullptr;
};

/// One force evaluation of the fast path, from integers to integers.
template <class Real>
class FastForce {
public:
  explicit FastForce(Sample& sample)
      : force_(sample.subdomain, sample.body.operators(), sample.body.elasticity(), sample.body.edges(),
               sample.body.residual_stiffness(),
               std::vector<double>(static_cast<std::size_t>(sample.subdomain.layout.n_owned), 1.0),
               mechanics::fixed_point_scale<Real>({.stretch = 1e-3, .velocity = 1000, .force = 1e4}),
               best_instruction_set()) {
    std::int32_t seed = 1;
    for (auto& node : force_.nodes())
      for (auto& u : node.displacement) u = (seed = seed * 1103515245 + 12345) >> 16;
  }
  void operator()() { force_.evaluate(); }
  const mechanics::FixedPointForce<Real>& force() const { return force_; }

private:
  mechanics::FixedPointForce<Real> force_;
};

/// The time loop as in a sample, during fracture: starting from the equilibrium of the first instability
/// under `overload` times its load.
class BreakingLoop {
public:
  BreakingLoop(Sample& sample, input::Precision precision, input::Integrator integrator,
               const parallel::NodeField& equilibrium, double load_time)
      : sample_(sample),
        splitting_(dynamics::splitting(integrator)),
        law_(sample.law(*sample.parameters.time.step,
                        dynamics::stable_step(sample.parameters, sample.realization).step)),
        state_{parallel::NodeField(sample.self, sample.subdomain.layout),
               parallel::NodeField(sample.self, sample.subdomain.layout)},
        step_(*sample.parameters.time.step),
        load_time_(load_time) {
    state_.displacement.assign(equilibrium);
    context_ = sample.context(*law_);
    motion_ = dynamics::make_fixed_point_motion(context_, precision, load_time, 1e-4, state_);
    breaking_ = dynamics::make_breaking_check(context_, *motion_);
    breaking_->start();
  }

  /// @return seconds of the stages and of the breaking check
  std::array<double, 2> run(int n_steps) {
    std::array<double, 2> seconds{};
    for (int i = 0; i < n_steps; ++i, ++n_) {
      const Stopwatch stages;
      motion_->step(n_ % 2 == 0 ? splitting_.even : splitting_.odd, step_, load_time_);
      seconds[0] += stages.seconds();
      const Stopwatch check;
      const auto breaking = breaking_->end_step(n_ + 1);
      for (const auto t : breaking) sample_.body.release(t, motion_->strain(t), load_time_, n_ * step_);
      motion_->release(breaking);
      seconds[1] += check.seconds();
    }
    return seconds;
  }

  std::size_t n_broken() const { return sample_.body.broken_tetrahedra().size(); }

private:
  Sample& sample_;
  const dynamics::Splitting& splitting_;
  std::unique_ptr<fracture::FractureLaw> law_;
  dynamics::MotionState state_;
  double step_;
  double load_time_;
  std::unique_ptr<dynamics::MovingBody> motion_;
  dynamics::MotionContext context_{};
  std::unique_ptr<dynamics::BreakingCheck> breaking_;
  int n_ = 0;
};

/// The first static solution of an intact body, including set-up, and the one after breaking the tetrahedron
/// with the largest strain along z.
class StaticSolutions {
public:
  explicit StaticSolutions(Sample& sample)
      : sample_(sample),
        held_(3 * sample.subdomain.nodes.size()),
        force_(held_.size()),
        displacement_(sample.self, sample.subdomain.layout) {
    for (const auto& motion : sample.loads.motions)
      for (const auto node : motion.nodes) held_[place(node, motion.component)] = 1;
    for (const auto& pattern : sample.loads.forces)
      for (std::size_t n = 0; n < pattern.nodes.size(); ++n)
        force_[place(pattern.nodes[n], pattern.component)] += pattern.weight[n];
  }

  int first() {
    const auto& body = sample_.body;
    solver_.emplace(sample_.self, sample_.subdomain, body.operators(), body.elasticity(), body.edges(),
                    body.residual_stiffness(), held_);
    return solver_->solve(force_, displacement_);
  }

  void break_one() {
    std::int32_t worst = 0;
    double most = 0;
    for (std::int32_t t = 0; t < sample_.subdomain.n_tetrahedra(); ++t) {
      const double stretch = sample_.body.strain(t, displacement_.local())[2];
      if (sample_.body.is_broken(t) || stretch <= most) continue;
      most = stretch;
      worst = t;
    }
    sample_.body.release(worst, sample_.body.strain(worst, displacement_.local()), 0, 0);
    solver_->release({&worst, 1});
  }
  int update() { return solver_->solve(force_, displacement_); }

private:
  static std::size_t place(std::int32_t node, int component) {
    return 3 * static_cast<std::size_t>(node) + static_cast<std::size_t>(component);
  }

  Sample& sample_;
  mechanics::HeldComponents held_;
  std::vector<double> force_;
  parallel::NodeField displacement_;
  std::optional<mechanics::StaticSolver> solver_;
};

struct Options {
  std::string input;
  std::string json;
  int rounds = 7;
};

constexpr double overload = 1.3;
constexpr int steps_per_round = 40;

void measure(const parallel::Communicator& world, const Options& options) {
  const auto parameters = input::read(options.input);
  Rounds rounds;
  std::map<std::string, double> results;
  const bool measures = world.rank() == 0;

  Sample sample(parameters);
  const double n_tetrahedra = static_cast<double>(sample.subdomain.n_tetrahedra());
  const double stable = dynamics::stable_step(parameters, sample.realization).step;
  sample.parameters.time.step = dynamics::choose_time_grid(parameters.time, stable).step;
  const auto equilibrium = [&](Sample& of, double& load_time) {
    const auto law = of.law(5e-9);
    dynamics::QuasiStaticLoading loading(of.self, of.body, of.loads, *law, 2e-5);
    dynamics::EnergyAccount account(of.self, of.body);
    loading.advance(account);
    load_time = overload * loading.time();
    parallel::NodeField u(of.self, of.subdomain.layout);
    u.assign(loading.displacement());
    for (auto& value : u.local()) value *= overload;
    return u;
  };
  double load_time = 0;
  const auto start = equilibrium(sample, load_time);
  BreakingLoop mixed4(sample, input::Precision::mixed, input::Integrator::bilateral4, start, load_time);

  if (measures) {
    constexpr std::size_t kb = 1024 / sizeof(double);
    std::vector<double> l2[3], l3[3], memory[3];
    for (auto& v : l2) v.assign(256 * kb, 1.0);
    for (auto& v : l3) v.assign(6 * 1024 * kb, 1.0);
    for (auto& v : memory) v.assign(256 * 1024 * kb, 1.0);
    PetscProduct aij(sample, MATSEQAIJ), baij(sample, MATSEQBAIJ), sbaij(sample, MATSEQSBAIJ);
    FastForce<float> mixed(sample);
    FastForce<double> twice(sample);
    Sample varied_sample(with_variation(parameters));
    FastForce<float> varied(varied_sample);
    Sample verlet_sample(parameters);
    verlet_sample.parameters.time.step = sample.parameters.time.step;
    BreakingLoop verlet(verlet_sample, input::Precision::mixed, input::Integrator::verlet, start, load_time);
    Sample double_sample(parameters);
    double_sample.parameters.time.step = sample.parameters.time.step;
    BreakingLoop double4(double_sample, input::Precision::double_, input::Integrator::bilateral4, start,
                         load_time);
    std::vector<double> u(3 * sample.subdomain.nodes.size(), 1e-6), f(u.size());
    const std::size_t n_broken_before = mixed4.n_broken();
    const auto loop = [&](const std::string& name, BreakingLoop& of) {
      const auto seconds = of.run(steps_per_round);
      rounds.add(name + " stages", seconds[0] / steps_per_round);
      rounds.add(name + " check", seconds[1] / steps_per_round);
      rounds.add(name + " step", (seconds[0] + seconds[1]) / steps_per_round);
    };
    for (int round = 0; round < options.rounds; ++round) {
      rounds.add("triad L2", triad(l2[0], l2[1], l2[2], 200));
      rounds.add("triad L3", triad(l3[0], l3[1], l3[2], 10));
      if (round < 3) rounds.add("triad memory", triad(memory[0], memory[1], memory[2], 1));
      rounds.time("AIJ", 5, [&] { aij(); });
      rounds.time("BAIJ", 5, [&] { baij(); });
      rounds.time("SBAIJ", 5, [&] { sbaij(); });
      rounds.time("reference", 3, [&] { sample.body.force().evaluate(u, f); });
      rounds.time("force mixed", 20, [&] { mixed(); });
      rounds.time("force varied", 20, [&] { varied(); });
      rounds.time("force double", 10, [&] { twice(); });
      loop("bilateral4", mixed4);
      loop("verlet", verlet);
      loop("bilateral4 double", double4);
      if (round < 3) {
        Sample fresh(parameters);
        StaticSolutions solutions(fresh);
        rounds.time("static first", 1, [&] { results["static_first_iterations"] = solutions.first(); });
        solutions.break_one();
        rounds.time("static update", 1, [&] { results["static_update_iterations"] = solutions.update(); });
        rounds.time("base points", 1,
                    [&] { geometry::make_mother_points(sample.geometry, parameters.mesh, parameters.seed); });
        rounds.time("mesh", 1, [&] {
          geometry::make_realization(sample.geometry, sample.base, parameters.mesh, parameters.seed, 1);
        });
        rounds.time("Delaunay", 1, [&] { geometry::plain_delaunay(sample.realization.nodes); });
      }
    }
    const auto triad_rate = [&](const char* name, const std::vector<double>& v) {
      return 3 * static_cast<double>(v.size()) * sizeof(double) / rounds.median(name);
    };
    results["bandwidth_l2_gb_per_s"] = triad_rate("triad L2", l2[0]) / 1e9;
    results["bandwidth_l3_gb_per_s"] = triad_rate("triad L3", l3[0]) / 1e9;
    results["bandwidth_memory_gb_per_s"] = triad_rate("triad memory", memory[0]) / 1e9;
    const double bytes = static_cast<double>(mixed.force().bytes_per_sweep());
    results["force_bytes_per_tetrahedron"] = bytes / n_tetrahedra;
    results["force_double_bytes_per_tetrahedron"] =
        static_cast<double>(twice.force().bytes_per_sweep()) / n_tetrahedra;
    results["padding"] = mixed.force().padding();
    const auto rate = [&](const char* name, double evaluations = 1) {
      return evaluations * n_tetrahedra / rounds.median(name) / 1e6;
    };
    results["petsc_aij_melem_per_s"] = rate("AIJ");
    results["petsc_baij_melem_per_s"] = rate("BAIJ");
    results["petsc_sbaij_melem_per_s"] = rate("SBAIJ");
    results["reference_melem_per_s"] = rate("reference");
    results["force_melem_per_s"] = rate("force mixed");
    results["force_double_melem_per_s"] = rate("force double");
    results["stages4_melem_per_s"] = rate("bilateral4 stages", 4);
    results["step4_melem_per_s"] = rate("bilateral4 step", 4);
    results["step4_double_melem_per_s"] = rate("bilateral4 double step", 4);
    results["step2_melem_per_s"] = rate("verlet step");
    results["ratio_to_petsc_baij"] = rounds.median("BAIJ") / rounds.median("force mixed");
    results["ratio_to_petsc_sbaij"] = rounds.median("SBAIJ") / rounds.median("force mixed");
    results["ratio_double_to_petsc_sbaij"] = rounds.median("SBAIJ") / rounds.median("force double");
    results["step4_ratio_to_four_petsc_sbaij"] =
        4 * rounds.median("SBAIJ") / rounds.median("bilateral4 step");
    results["fraction_of_roofline"] = bytes / rounds.median("force mixed") / triad_rate("triad L3", l3[0]);
    results["force_varied_over_force"] = rounds.median("force varied") / rounds.median("force mixed");
    results["check_over_force"] = rounds.median("bilateral4 check") / rounds.median("force mixed");
    results["force_seconds"] = rounds.median("force mixed");
    results["mesh_seconds"] = rounds.median("mesh");
    results["mesh_over_delaunay"] = rounds.median("mesh") / rounds.median("Delaunay");
    results["static_first_over_force"] = rounds.median("static first") / rounds.median("force mixed");
    results["static_update_over_force"] = rounds.median("static update") / rounds.median("force mixed");
    results["base_points_seconds"] = rounds.median("base points");
    results["broken_during_measurement"] = static_cast<double>(mixed4.n_broken() - n_broken_before);
  }
  // Both ranks at once compared with one alone.
  parallel::barrier_asleep(world);
  for (int round = 0; round < std::max(3, options.rounds / 2); ++round) {
    if (measures) {
      const Stopwatch watch;
      mixed4.run(steps_per_round);
      rounds.add("alone", watch.seconds());
    }
    parallel::barrier_asleep(world);
    const Stopwatch watch;
    mixed4.run(steps_per_round);
    const double mine = watch.seconds();
    double slowest = mine;
    MPI_Allreduce(&mine, &slowest, 1, MPI_DOUBLE, MPI_MAX, world.get());
    if (measures) rounds.add("together", slowest);
  }
  if (!measures) return;
  if (world.size() > 1)
    results["two_processes_over_one"] = world.size() * rounds.median("alone") / rounds.median("together");

  fmt::print("{} nodes, {:.0f} tetrahedra, {}\n", sample.subdomain.nodes.size(), n_tetrahedra,
             to_string(best_instruction_set()));
  for (const auto& [name, value] : results) fmt::print("{:<36} {:.4g}\n", name, value);
  if (options.json.empty()) return;
  std::ofstream file(options.json);
  file << "{\n";
  for (auto entry = results.begin(); entry != results.end(); ++entry)
    file << fmt::format("  \"{}\": {:.6g}{}\n", entry->first, entry->second,
                        std::next(entry) == results.end() ? "" : ",");
  file << "}\n";
}

}  // namespace

int main(int argc, char** argv) {
  return run_benchmark("benchmark_time_loop", [&] {
    Options options;
    for (int i = 1; i < argc; ++i) {
      const std::string argument = argv[i];
      if (argument == "--json" && i + 1 < argc)
        options.json = argv[++i];
      else if (argument == "--rounds" && i + 1 < argc)
        options.rounds = std::stoi(argv[++i]);
      else
        options.input = argument;
    }
    const parallel::Communicator world(MPI_COMM_WORLD);
    measure(world, options);
  });
}
