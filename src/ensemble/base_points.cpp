// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/base_points.h"

#include "common/freed_memory.h"
#include "common/heartbeat.h"
#include "ensemble/material_map.h"
#include "ensemble/progress.h"
#include "ensemble/realization_queue.h"
#include "ensemble/results.h"
#include "geometry/flaws.h"
#include "geometry/pre_crack.h"
#include "io/ensemble_file.h"

#include <fmt/format.h>

#include <stdexcept>

namespace crackle::ensemble {

geometry::MotherPoints make_base_points(const geometry::Body& body, const input::Mesh& mesh,
                                        std::uint64_t seed,
                                        const std::function<void(const std::string&)>& say,
                                        std::uint64_t sample, int attempt, geometry::Crew* crew) {
  Heartbeat heartbeat(say);
  const auto expects = [&](double n_points) {
    heartbeat.begin(fmt::format("generating about {:.0f} mother points", n_points));
  };
  heartbeat.begin("counting the mother points");
  auto points = geometry::make_mother_points(body, mesh, seed, expects, sample, attempt, crew);
  release_freed_memory();
  return points;
}

geometry::MotherPoints make_shared_points(const geometry::Body& body, const input::Mesh& mesh,
                                          std::uint64_t seed,
                                          const std::function<void(const std::string&)>& say,
                                          geometry::Crew* crew) {
  if (mesh.base == input::Base::own) {
    const double n_points = [&] {
      Heartbeat heartbeat(say);
      heartbeat.begin("counting the mother points");
      return geometry::checked_n_points(body, mesh);
    }();
    if (say) say(fmt::format("base mesh: one for each sample, about {:.0f} mother points", n_points));
    return {};
  }
  geometry::MotherPoints points = make_base_points(body, mesh, seed, say, 0, 0, crew);
  if (say) say(fmt::format("base mesh: {} mother points", points.size()));
  return points;
}

geometry::Realization make_sample_mesh(const geometry::Body& body, const geometry::MotherPoints& shared,
                                       const input::Mesh& mesh, std::uint64_t seed, std::uint64_t sample,
                                       int attempt) {
  geometry::MotherPoints own;
  if (mesh.base == input::Base::own)
    own = geometry::make_mother_points(body, mesh, seed, {}, sample, attempt);
  const bool is_shared = mesh.base == input::Base::shared;
  auto realization = geometry::make_realization(body, is_shared ? shared : own, mesh, seed, sample, attempt);
  release_freed_memory();
  return realization;
}

void complete_realization(const input::Model& model, const geometry::Body& body, std::uint64_t sample,
                          geometry::Realization& realization) {
  apply_material_map(model, body, sample, realization);
  geometry::open_pre_cracks(geometry::pre_cracks(model, body, sample), body.bounds(), realization);
}

geometry::Realization make_sample_realization(const geometry::Body& body,
                                              const geometry::MotherPoints& shared, const input::Model& model,
                                              std::uint64_t sample) {
  auto realization = with_retries([&](std::uint64_t number, int attempt) {
    return make_sample_mesh(body, shared, model.mesh, model.seed, number, attempt);
  })(sample);
  complete_realization(model, body, sample, realization);
  return realization;
}

geometry::MotherPoints base_points(const std::filesystem::path& folder, const input::Parameters& parameters) {
  if (parameters.mesh.base == input::Base::own) return {};
  try {
    return io::read_mother_points(results_file(folder), parameters);
  } catch (const std::runtime_error&) {
    return make_base_points(*geometry::make_body(parameters), parameters.mesh, parameters.seed);
  }
}

}  // namespace crackle::ensemble
