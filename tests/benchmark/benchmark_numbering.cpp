// SPDX-License-Identifier: GPL-3.0-or-later
// Effect of the numbering of nodes and tetrahedra on the speed of the force loop: the same realization with
// the numbering of crackle (slabs), that of CGAL's tessellation (Hilbert curve), and a random one.
//
//   benchmark_numbering INPUT [options of Google Benchmark]
#include "common/random.h"
#include "geometry/body.h"
#include "geometry/partition.h"
#include "geometry/subdomain.h"
#include "input/reader.h"
#include "mechanics/internal_force.h"

#include "plain_delaunay.h"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <map>
#include <numeric>

namespace {

using namespace crackle;
using geometry::Realization;
using geometry::Tetrahedron;

std::size_t index(std::int32_t number) {
  return static_cast<std::size_t>(number);
}

/// The part of a realization used by the force loop.
struct Numbering {
  std::vector<geometry::Point> nodes;
  std::vector<Tetrahedron> tetrahedra;
};

/// CGAL's order of nodes and cells, without the cells that fill notches.
Numbering of_tessellation(const Realization& realization) {
  const geometry::PlainDelaunay plain = geometry::plain_delaunay(realization.nodes);
  std::map<geometry::Point, std::int32_t> number;
  for (std::size_t i = 0; i < realization.nodes.size(); ++i)
    number[realization.nodes[i]] = static_cast<std::int32_t>(i);
  std::vector<Tetrahedron> ours = realization.tetrahedra;
  for (Tetrahedron& t : ours) std::sort(t.begin(), t.end());
  std::sort(ours.begin(), ours.end());
  Numbering result{plain.nodes, {}};
  for (const Tetrahedron& t : plain.tetrahedra) {
    Tetrahedron key{};
    for (std::size_t k = 0; k < 4; ++k) key[k] = number.at(plain.nodes[index(t[k])]);
    std::sort(key.begin(), key.end());
    if (std::binary_search(ours.begin(), ours.end(), key)) result.tetrahedra.push_back(t);
  }
  return result;
}

template <class Value>
void shuffle(std::vector<Value>& values, RandomStream& stream) {
  for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[stream.bits() % i]);
}

Numbering at_random(const Realization& realization) {
  RandomStream stream(1, 0, "numbering");
  std::vector<std::int32_t> number(realization.nodes.size());
  std::iota(number.begin(), number.end(), 0);
  shuffle(number, stream);
  Numbering result{realization.nodes, realization.tetrahedra};
  for (std::size_t i = 0; i < number.size(); ++i) result.nodes[index(number[i])] = realization.nodes[i];
  for (Tetrahedron& t : result.tetrahedra)
    for (std::int32_t& node : t) node = number[index(node)];
  shuffle(result.tetrahedra, stream);
  return result;
}

/// The force on one rank that holds the whole body.
void evaluate_forces(benchmark::State& state, const Numbering& numbering, const input::Material& material) {
  Realization realization;
  realization.nodes = numbering.nodes;
  realization.tetrahedra = numbering.tetrahedra;
  const auto parts = geometry::split(realization, geometry::partition(realization, 1));
  const mechanics::PdsOperators operators = mechanics::make_operators(parts[0], material.density);
  const mechanics::ElasticityField elasticity{mechanics::IsotropicElasticity(material)};
  const mechanics::ResidualStiffness intact(operators, elasticity);
  const mechanics::InternalForce force(operators, intact);
  std::vector<double> displacement(3 * realization.nodes.size());
  RandomStream stream(2, 0, "displacement");
  for (double& u : displacement) u = 1e-6 * stream.uniform(-1, 1);
  std::vector<double> result(displacement.size());
  for (auto step : state) {
    static_cast<void>(step);
    force.evaluate(displacement, result);
    benchmark::DoNotOptimize(result.data());
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(realization.tetrahedra.size()));
}

void register_benchmarks(const char* input) {
  const input::Parameters parameters = input::read(input);
  const geometry::Body body = *geometry::make_body(parameters.specimen);
  const std::uint64_t seed = parameters.seed;
  const Realization realization = geometry::make_realization(
      body, geometry::make_mother_points(body, parameters.mesh, seed), parameters.mesh, seed, 0);
  const auto add = [&](const char* name, const Numbering& numbering) {
    std::printf("%-22s %zu nodes, %zu tetrahedra\n", name, numbering.nodes.size(),
                numbering.tetrahedra.size());
    benchmark::RegisterBenchmark(name, [numbering,
                                        material = parameters.material()](benchmark::State& state) {
      evaluate_forces(state, numbering, material);
    })->Unit(benchmark::kMillisecond);
  };
  add("force/slabs", {realization.nodes, realization.tetrahedra});
  add("force/tessellation", of_tessellation(realization));
  add("force/random", at_random(realization));
}

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc != 2) {
    std::fprintf(stderr, "usage: benchmark_numbering INPUT [--benchmark_... options]\n");
    return 1;
  }
  try {
    register_benchmarks(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
