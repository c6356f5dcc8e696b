// SPDX-License-Identifier: GPL-3.0-or-later
// crackle observe: for the Python package, what it needs of an ensemble beside its result files.
#include "analysis/statistics.h"
#include "commands.h"
#include "common/index.h"
#include "ensemble_folder.h"
#include "geometry/body.h"
#include "geometry/outline.h"
#include "geometry/symmetry.h"
#include "input/copula.h"
#include "input/reader.h"
#include "parallel/agreement.h"
#include "uncertainty/random_inputs.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <memory>
#include <string>

namespace crackle::apps {

namespace {

using Json = nlohmann::ordered_json;  // writes numbers with full precision, and NaN as null

Json in_plane(const geometry::Point& p) {
  return {p[1], p[2]};
}

/// The ends of the walls, in the y-z plane, at which cracks of a start begin.
Json walls_of(const geometry::Body& body, const geometry::CrackStart& start) {
  Json walls = Json::array();
  for (std::size_t f = 0; f < body.faces().size(); ++f) {
    const auto has = [&](const geometry::CrackStart& each) {
      return std::ranges::find(each.faces, static_cast<geometry::FaceId>(f)) != each.faces.end();
    };
    const bool is_its = start.is_free_surface ? std::ranges::none_of(body.crack_starts(), has) : has(start);
    if (body.faces()[f].outward[0] != 0 || !is_its) continue;
    const geometry::Patch& patch = body.faces()[f].patch;
    walls.push_back({in_plane(patch.at(patch.domain.lower)), in_plane(patch.at(patch.domain.upper))});
  }
  return walls;
}

Json starts_of(const geometry::Body& body) {
  const geometry::Outline outline = geometry::outline_of(body);
  Json starts = Json::array();
  for (std::size_t i = 0; i < outline.names.size(); ++i) {
    const geometry::CrackStart& start = body.crack_starts()[i];
    const double* const slot = &outline.slots[4 * i];
    starts.push_back({{"name", outline.names[i]},
                      {"is_straight", start.is_straight},
                      {"is_free_surface", start.is_free_surface},
                      {"is_hole", start.is_hole},
                      {"tip", in_plane(start.tip)},
                      {"end", in_plane(start.end)},
                      {"slot", {{slot[0], slot[2]}, {slot[1], slot[3]}}},
                      {"walls", walls_of(body, start)}});
  }
  return starts;
}

/// Symmetries as maps p -> matrix p + shift of the y-z plane.
Json symmetries_of(const geometry::Body& body, const input::Parameters& parameters) {
  Json list = Json::array();
  for (const geometry::Symmetry& symmetry : geometry::loaded_symmetries(body, parameters)) {
    const geometry::Point zero = symmetry.image({0, 0, 0});
    const geometry::Point y = symmetry.image({0, 1, 0}) - zero, z = symmetry.image({0, 0, 1}) - zero;
    list.push_back({{"crack_start", symmetry.crack_start},
                    {"matrix", {{y[1], z[1]}, {y[2], z[2]}}},
                    {"shift", in_plane(zero)}});
  }
  return list;
}

/// True if samples may have symmetries of their own.
bool has_random_symmetries(const input::Parameters& parameters) {
  using enum input::Affects;
  return std::ranges::any_of(parameters.random, [](const input::RandomInput& random) {
    return input::affects(random, {body, points, place, mesh, conditions});
  });
}

void add_samples(const StoredSamples& stored, const input::Parameters& parameters, Json& document) {
  Json samples = Json::array();
  for (std::size_t i = 0; i < stored.rows.size(); ++i) {
    const analysis::SampleSummary& row = stored.rows[i];
    const char* const group = row.status == analysis::SampleStatus::pending  ? "missing"
                              : row.status == analysis::SampleStatus::failed ? "failed"
                              : analysis::is_undecided(row)                  ? "undecided"
                                                                             : nullptr;
    if (group != nullptr) {
      document[group].push_back(i);
      continue;
    }
    const double onset = std::isnan(row.onset_force) ? row.first_break_load : row.onset_force;
    Json one{{"number", i},
             {"leading_start", row.leading_start},
             {"onset_load", onset},
             {"peak_load", row.peak_load},
             {"is_unbroken", analysis::is_unbroken(row) || analysis::is_held(row)},
             {"inputs", row.inputs}};
    if (has_random_symmetries(parameters)) {
      const input::Parameters own = uncertainty::sample_parameters(parameters, i);
      one["symmetries"] = symmetries_of(*geometry::make_body(own), own);
    }
    samples.push_back(std::move(one));
  }
  document["samples"] = std::move(samples);
}

/// The random inputs, with NaN for what their distributions do not take.
Json random_of(const input::Parameters& parameters) {
  Json list = Json::array();
  for (const input::RandomInput& random : parameters.random)
    list.push_back({{"key", random.key},
                    {"keys", input::keys_of(random)},
                    {"by_factor", random.by_factor},
                    {"unit", random.unit},
                    {"kind", input::distribution_names[index(random.distribution)]},
                    {"parameters",
                     {{"own", random.own},
                      {"mean", random.mean},
                      {"standard_deviation", random.standard_deviation},
                      {"lower", random.lower},
                      {"upper", random.upper},
                      {"mode", random.mode},
                      {"shape", random.shape},
                      {"scale", random.scale}}},
                    {"values", random.values},
                    {"weights", random.weights}});
  return list;
}

std::string observed(const std::filesystem::path& folder, const input::Parameters& parameters) {
  StoredSamples stored = stored_samples(folder, parameters);
  for (std::size_t i = 0; i < stored.rows.size(); ++i) tell_unusable(i, stored.rows[i]);
  analysis::leave_out_surplus(analysis::make_statistics(stored.rows, parameters), 0, stored.rows);
  const auto body = geometry::make_composite_body(parameters);
  const auto& [lower, upper] = body->bounds();
  Json sections = Json::array();
  for (const input::Section& section : parameters.sections.all()) sections.push_back(input::name_of(section));
  Json document{{"lower", in_plane(lower)},
                {"upper", in_plane(upper)},
                {"starts", starts_of(*body)},
                {"symmetries", symmetries_of(*body, parameters)},
                {"sections", sections},
                {"base", parameters.mesh.base == input::Base::shared ? "shared" : "own"},
                {"has_points", parameters.mesh.points.has_value()},
                {"replicates", parameters.ensemble.replicates},
                {"seed", parameters.seed},
                {"planned", stored.rows.size()},
                {"headline_load", analysis::headline_load(stored.rows)},
                {"failed", Json::array()},
                {"undecided", Json::array()},
                {"missing", Json::array()}};
  document["random"] = random_of(parameters);
  document["correlation"] = parameters.correlations.empty() ? Json() : Json(input::copula(parameters));
  add_samples(stored, parameters, document);
  return document.dump() + "\n";
}

}  // namespace

void add_observe_command(CLI::App& app, Action& run) {
  const auto given = std::make_shared<std::string>();
  CLI::App* const command = app.add_subcommand(
      "observe", "Print as JSON, in SI units, the body of an ensemble and the samples that count");
  command->group("");  // for the Python package
  command->add_option("folder", *given, "output folder of crackle run, or the ensemble.h5 in it")->required();
  command->callback([given, &run] {
    run.work = [given](const parallel::Communicator& world) {
      const auto folder = folder_of(world, *given);
      const input::Parameters parameters = input_of(world, folder);
      parallel::agree_on_root(world, [&] { fmt::print("{}", observed(folder, parameters)); });
      return success;
    };
  });
}

}  // namespace crackle::apps
