// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/censored_values.h"
#include "analysis/leader_frame.h"
#include "analysis/path_inference.h"
#include "analysis/result_list.h"
#include "analysis/sensitivity.h"
#include "analysis/statistics.h"
#include "analysis/stop_rule.h"
#include "analysis/weibull_fit.h"
#include "common/text_table.h"
#include "geometry/outline.h"
#include "input/reader.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>

namespace crackle::analysis {

namespace {

using Json = nlohmann::ordered_json;  // writes numbers with full precision, and NaN as null
using Shape = std::vector<std::size_t>;

/// Values in row-major order as nested lists.
template <class Value>
Json table(std::span<const Value> values, std::span<const std::size_t> shape) {
  if (shape.size() == 1) return Json(std::vector<Value>(values.begin(), values.end()));
  Json rows = Json::array();
  const std::size_t length = shape[0] == 0 ? 0 : values.size() / shape[0];
  for (std::size_t i = 0; i < shape[0]; ++i)
    rows.push_back(table<Value>(values.subspan(i * length, length), shape.subspan(1)));
  return rows;
}

template <class Value>
Json table(const std::vector<Value>& values, const Shape& shape) {
  return table<Value>(std::span(values), std::span(shape));
}

constexpr std::array about_words{"body", "place", "path", "hole", "computation"};  // as in About
constexpr std::array unbroken_words{"value", "bound", "nothing"};                  // as in OfUnbroken
constexpr std::array reduction_words{"none", "quantiles", "counts", "shares"};     // as in Reduction

/// Metadata of each result, and its statistics over all samples.
Json describe_results(const std::vector<ResultStatistics>& results) {
  Json described = Json::array();
  for (const ResultStatistics& found : results) {
    const ResultInfo& info = found.info;
    Json result{{"name", info.name},
                {"meaning", info.meaning},
                {"units", info.units},
                {"label", info.label},
                {"shown_units", info.shown_units},
                {"shown_factor", info.shown_factor},
                {"about", about_words[static_cast<std::size_t>(info.about)]},
                {"reduction", reduction_words[static_cast<std::size_t>(info.reduction)]},
                {"is_start", info.is_start},
                {"in_sensitivities", (info.short_tables & in_sensitivities) != 0},
                {"format", fitting_format(info.format, found.quantiles, info.shown_factor)},
                {"format_of_any", info.format},
                {"n_values", found.n_values},
                {"of_unbroken", unbroken_words[static_cast<std::size_t>(info.of_unbroken)]},
                {"tells_the_end", info.tells_the_end},
                {"n_bounds", found.n_bounds}};
    for (int k = 0; k < n_categories(info.categories); ++k)
      result["categories"].push_back(category_name(info.categories, k));
    if (found.n_values > 0 && info.reduction == Reduction::quantiles) {
      for (const Observation& one : found.quantiles) {
        result["quantiles"].push_back(known(one));
        if (found.n_bounds > 0) result["quantile_bounds"].push_back(one.is_bound ? one.value : not_a_number);
      }
      const auto& [lower, upper] = found.of_median;
      result["median_lower"] = known(lower);
      result["median_upper"] = known(upper);
    }
    if (found.n_values > 0 && info.reduction == Reduction::shares) result["counts"] = found.counts;
    if (found.n_values > 0 && info.reduction == Reduction::counts) {
      result["mean"] = found.mean;
      result["n_any"] = found.n_any;
      result["share"] = static_cast<double>(found.n_any) / found.n_values;
      result["lower"] = found.share_any.lower;
      result["upper"] = found.share_any.upper;
    }
    described.push_back(std::move(result));
  }
  return described;
}

template <class Value>
Json column(std::span<const SampleSummary> samples, Value value) {
  Json values = Json::array();
  for (const SampleSummary& sample : samples) values.push_back(value(sample));
  return values;
}

Json samples_of(std::span<const SampleSummary> samples, const Statistics& statistics, const Origin& origin) {
  Json group{{"status", column(samples, [](const auto& row) { return static_cast<int>(row.status); })},
             {"error", column(samples, [](const auto& row) { return row.error; })},
             {"note", column(samples, [](const auto& row) { return row.note; })}};
  for_each_result([&](const ResultInfo& info, auto member) {
    if (lacks(origin, info.name)) return;
    group[info.name] = column(samples, [member](const auto& row) { return row.*member; });
  });
  for (std::size_t k = 0; k < statistics.crack_parts.size(); ++k)
    group[crack_area_in_info.name][statistics.crack_parts[k]] = column(samples, [k](const auto& row) {
      return k < row.crack_area_in.size() ? row.crack_area_in[k] : not_a_number;
    });
  group["wall_time"] = column(samples, [](const auto& row) { return row.wall_time; });
  return group;
}

/// Where the leading crack of each sample crosses the sections, in the frame of its class.
Json leaders(std::span<const SampleSummary> samples, const LeaderFrame& frame) {
  return column(samples, [&](const SampleSummary& row) {
    Json positions = Json::array();
    for (int s = 0; s < frame.n_sections(); ++s) {
      const int start = row.leading_start < 0 ? -1 : frame.reference()[index(row.leading_start)];
      positions.push_back(start < 0 ? not_a_number : framed_position(frame, row, start, start, s).value);
    }
    return positions;
  });
}

/// The input lines that determine the bodies of the samples: those of random inputs, too, if these change
/// bodies.
std::vector<std::string> settings_of_bodies(const input::Parameters& parameters) {
  using enum input::Affects;
  std::vector<std::string> settings = input::settings_of(parameters, {body, points, mesh});
  const auto changes_bodies = [](const input::RandomInput& random) {
    return input::affects(random, {body, points, place, mesh});
  };
  if (!parameters.flaws.empty() || std::ranges::any_of(parameters.random, changes_bodies)) {
    auto drawn = input::settings_of(parameters, {draws});
    // The random inputs tell more than how they are drawn.
    std::ranges::stable_partition(drawn, [](const std::string& line) { return line.starts_with("random"); });
    settings.insert(settings.begin(), drawn.begin(), drawn.end());
  }
  return settings;
}

/// The grounds on which samples are independent, and the settings that make the bodies.
Json sampling_of(const input::Parameters& parameters) {
  const input::Ensemble& ensemble = parameters.ensemble;
  return {{"seed", parameters.seed},
          {"base", parameters.mesh.base == input::Base::shared ? "shared" : "own"},
          {"has_points", parameters.mesh.points.has_value()},
          {"plan", input::plan_names[index(ensemble.plan)]},
          {"replicates", ensemble.replicates},
          {"note", note_on_plan(parameters)},
          {"body_settings", settings_of_bodies(parameters)}};
}

Json crack_path(std::span<const SampleSummary> samples, const input::Sections& sections,
                const Shape& positions) {
  Json group{{"section", Json::array()},
             {"section_axis", Json::array()},
             {"section_name", Json::array()},
             {"section_coordinate", Json::array()}};
  for (const input::Section& section : sections.all()) {
    group["section"].push_back(section.position);
    group["section_axis"].push_back(section.axis);
    group["section_name"].push_back(input::name_of(section));
    group["section_coordinate"].push_back(input::coordinate_of(section));
    if (section.axis == 0) group["section_line"].push_back({section.line.from, section.line.to});
  }
  for_each_position_result([&](const ResultInfo& info, auto member) {
    group[info.name] = column(samples, [&](const auto& row) { return table(row.*member, positions); });
  });
  return group;
}

/// The planes, and the traces of every sample: samples x planes x starts, then cracks without a start and
/// all.
Json traces_of(std::span<const SampleSummary> samples, const Statistics& statistics,
               const std::vector<input::SectionPlane>& planes) {
  const Shape shape{planes.size(), cracks::n_trace_rows(index(statistics.n_starts))};
  Json group{{"plane", Json::array()}, {"cracks", statistics.start_names}};
  for (const input::SectionPlane& plane : planes)
    group["plane"].push_back(
        {{"point", plane.point}, {"normal", plane.normal}, {"axes", cracks::axes_along(plane)}});
  for (const char* const name : {"without a start", "all"}) group["cracks"].push_back(name);
  for_each_trace_result([&](const ResultInfo& info, auto member) {
    group[info.name] = column(samples, [&](const SampleSummary& row) {
      std::vector<double> values(shape[0] * shape[1], not_a_number);
      if (row.traces.size() == values.size()) std::ranges::transform(row.traces, values.begin(), member);
      return table(values, shape);
    });
  });
  return group;
}

/// The statistics of the traces: a list of planes, each a list of those of start_traces.
Json trace_statistics(const Statistics& statistics) {
  Json planes = Json::array();
  const std::size_t n_rows = cracks::n_trace_rows(index(statistics.n_starts));
  for (std::size_t p = 0; p < statistics.traces.size(); ++p) {
    const TraceStatistics& one = statistics.traces[p];
    if (p % n_rows == 0) planes.push_back(Json::array());
    Json found{{"n_crossed", one.n_crossed},
               {"n_of", one.n_of},
               {"share", one.share},
               {"lower", one.interval.lower},
               {"upper", one.interval.upper}};
    std::size_t i = 0;
    for_each_trace_result([&](const ResultInfo& info, auto) {
      const TraceStatistics::Estimate& estimate = one.results[i++];
      found[info.name] = {
          {"mean", estimate.mean}, {"std", estimate.std}, {"half_width", estimate.half_width}};
    });
    planes.back().push_back(std::move(found));
  }
  return planes;
}

/// The numbers of every sample's fragments.
Json fragments_of(std::span<const SampleSummary> samples) {
  Json group{{"shares", fragment_shares()}};
  for_each_fragment_result([&](const ResultInfo& info, auto member) {
    group[info.name] = column(samples, [&](const SampleSummary& row) { return row.fragments.*member; });
  });
  group["heavier"] = column(samples, [](const SampleSummary& row) { return row.fragments.heavier; });
  return group;
}

/// Their statistics; of `heavier` at each of the shares.
Json fragment_statistics(const FragmentStatistics& statistics) {
  const auto json = [](const MeanEstimate& one) {
    return Json{{"mean", one.mean}, {"std", one.std}, {"half_width", one.half_width}};
  };
  Json found{
      {"n_of", statistics.n_of}, {"n_fragmented", statistics.n_fragmented}, {"heavier", Json::array()}};
  std::size_t i = 0;
  for_each_fragment_result(
      [&](const ResultInfo& info, auto) { found[info.name] = json(statistics.results[i++]); });
  for (const MeanEstimate& one : statistics.heavier) found["heavier"].push_back(json(one));
  return found;
}

void add_paths(Json& group, const PathStatistics& paths, std::size_t n_rows, const Statistics& statistics) {
  const auto n_sections = static_cast<std::size_t>(statistics.n_sections);
  const Shape positions{n_rows, n_sections};
  const Shape running{static_cast<std::size_t>(statistics.n_samples), n_rows, n_sections};
  group["reached"] = table(paths.reached, positions);
  group["z_mean"] = table(paths.z_mean, positions);
  group["z_std"] = table(paths.z_std, positions);
  group["z_half_width"] = table(paths.z_half_width, positions);
  group["z_quantile"] = table(paths.z_quantile, {n_rows, n_sections, quantile_shares.size()});
  group["spread_mean"] = table(paths.spread_mean, positions);
  group["is_divided"] = table(paths.is_divided, positions);
  group["running_mean"] = table(paths.running_mean, running);
  group["running_half_width"] = table(paths.running_half_width, running);
}

/// Precision of the leaders' mean path, compared with the required one.
Json precision(const Statistics& statistics, const std::optional<input::EnsembleStop>& stop, double width) {
  const double wanted = stop ? stop->half_width : default_half_width_share * width;
  Json found{{"half_width_wanted", wanted}, {"is_of_the_input", stop.has_value()}};
  if (const auto worst = least_certain(statistics)) {
    const auto n_sections = static_cast<std::size_t>(statistics.n_sections);
    found["half_width"] = worst->half_width;
    found["row"] = worst->position / n_sections;
    found["section"] = worst->position % n_sections;
    if (worst->group != nullptr) found["group"] = worst->group - statistics.leader.groups.data();
    found["n_samples_needed"] = n_samples_needed(statistics, wanted);
  }
  return found;
}

/// The cracks that stopped before each section, as a list over rows and sections.
Json stopped_before(const PathInference& found, const RankStatistics& ranks, std::size_t n_sections) {
  Json list = Json::array();
  for (std::size_t p = 0; p < found.stopped.size(); ++p) {
    const Stopped& one = found.stopped[p];
    if (one.previous < 0) continue;
    list.push_back({{"leading_notch", ranks.leading_start[p / n_sections]},
                    {"notch", ranks.start[p / n_sections]},
                    {"section", p % n_sections},
                    {"previous_section", one.previous},
                    {"n_arrived", one.n_arrived},
                    {"n_stopped", one.n_stopped},
                    {"previous_mean_arrived", one.mean_arrived},
                    {"previous_mean_stopped", one.mean_stopped},
                    {"p", one.probability},
                    {"mean_of_all", one.mean_of_all},
                    {"mean_of_all_half_width", one.half_width_of_all},
                    {"n_all", one.n_all},
                    {"n_predicted", one.n_predicted},
                    {"n_beyond", one.n_beyond}});
  }
  return list;
}

/// The groups of a rank's paths, as a list.
Json groups_of(const RankStatistics& ranks) {
  Json list = Json::array();
  for (const PathGroup& group : ranks.groups)
    list.push_back({{"leading_notch", ranks.leading_start[group.row]},
                    {"notch", ranks.start[group.row]},
                    {"row", group.row},
                    {"n", group.n},
                    {"n_of", group.n_of},
                    {"share", group.share},
                    {"lower", group.share_lower},
                    {"upper", group.share_upper},
                    {"reached", group.reached},
                    {"z_mean", group.z_mean},
                    {"z_std", group.z_std},
                    {"z_half_width", group.z_half_width}});
  return list;
}

Json statistics_of(const Statistics& statistics, const LeaderFrame& frame,
                   std::span<const SampleSummary> samples, const input::Study& study) {
  const auto& stop = study.ensemble.stop;
  Json group{
      {"confidence", statistics.confidence},
      {"interval_scope", interval_scope(statistics.base, statistics.replicates)},
      {"n_looks", statistics.n_looks},
      {"looks", stop ? look_schedule(statistics.n_samples, stop->min_samples) : std::vector<std::size_t>{}},
      {"precision", precision(statistics, stop, study.specimen.size[1])}};
  add_paths(group, statistics, static_cast<std::size_t>(statistics.n_starts), statistics);
  group["pattern_share"] = statistics.pattern_share;
  group["pattern_half_width"] = statistics.pattern_half_width;
  group["pattern_lower"] = statistics.pattern_lower;
  group["pattern_upper"] = statistics.pattern_upper;
  group["reference_notch"] = statistics.reference_start;
  for (int leading = 0; leading < frame.n_starts(); ++leading) {
    const unsigned axes = frame.reflected_axes(leading);
    group["symmetries"].push_back({{"reflects_y", (axes & 2u) != 0},
                                   {"reflects_z", (axes & 4u) != 0},
                                   {"notch", frame.starts(leading)}});
  }
  for_each_rank(statistics, [&](const char* name, const RankStatistics& ranks) {
    const std::size_t n_rows = ranks.start.size();
    Json of_rank{
        {"leading_notch", ranks.leading_start},
        {"notch", ranks.start},
        {"counted", table(ranks.counted, {n_rows, static_cast<std::size_t>(statistics.n_sections)})}};
    add_paths(of_rank, ranks, n_rows, statistics);
    of_rank["groups"] = groups_of(ranks);
    if (&ranks == &statistics.leader || &ranks == &statistics.follower) {
      const auto n_sections = static_cast<std::size_t>(statistics.n_sections);
      const PathInference found = path_inference(ranks, statistics, samples, frame, study.sections);
      of_rank["band_half_width"] = table(found.band_half_width, {n_rows, n_sections});
      of_rank["stopped"] = stopped_before(found, ranks, n_sections);
    }
    group[name] = std::move(of_rank);
  });
  return group;
}

Json estimate(const Estimate& estimate) {
  return {{"value", estimate.value}, {"lower", estimate.lower}, {"upper", estimate.upper}};
}

Json inputs_of(std::span<const SampleSummary> samples, const std::vector<input::RandomInput>& random_inputs) {
  Json inputs = Json::array();
  for (std::size_t k = 0; k < random_inputs.size(); ++k) {
    const input::RandomInput& random = random_inputs[k];
    inputs.push_back({{"key", random.key},
                      {"units", random.unit},
                      {"distribution", input::describe(random)},
                      {"values", column(samples, [k](const auto& row) {
                         return k < row.inputs.size() ? row.inputs[k] : not_a_number;
                       })}});
  }
  return inputs;
}

Json sensitivities_of(std::span<const SampleSummary> samples, const input::Study& study) {
  const Sensitivities all = sensitivities(study, samples);
  Json results = Json::array();
  for (const Sensitivity& one : all.results) {
    Json inputs = Json::array();
    for (const InputEffect& effect : one.inputs)
      inputs.push_back({{"rank_correlation", estimate(effect.rank_correlation)},
                        {"first", estimate(effect.first)},
                        {"total", estimate(effect.total)}});
    Json result{{"result", one.info.name},        {"label", one.info.label}, {"share_of", one.share_of},
                {"n_values", one.n_values},       {"n_draws", one.n_draws},  {"n_bounds", one.n_bounds},
                {"mesh", estimate(one.mesh)},     {"degree", one.degree},    {"predicted", one.predicted},
                {"lack_of_fit", one.lack_of_fit}, {"inputs", inputs}};
    if (one.start >= 0) {
      result["notch"] = one.start;
      result["section"] = one.section;
    }
    results.push_back(std::move(result));
  }
  return {{"confidence", all.confidence},
          {"n_draws", all.n_draws},
          {"n_samples", all.n_samples},
          {"failures", all.failures},
          {"replicates", study.ensemble.replicates},
          {"results", results}};
}

Json weibull_of(std::span<const SampleSummary> samples, double confidence) {
  const auto estimate = [](const FittedParameter& one) {
    return Json{{"value", one.value}, {"lower", one.lower}, {"upper", one.upper}};
  };
  Json fits = Json::object();
  for (const auto& [load, fit] : weibull_fits(samples, confidence))
    fits[load.name] = {{"modulus", estimate(fit.modulus)},
                       {"scale", estimate(fit.scale)},
                       {"n_broken", fit.n_broken},
                       {"n_run_out", fit.n_unbroken}};
  return fits;
}

}  // namespace

std::string to_json(const Statistics& statistics, std::span<const SampleSummary> samples,
                    const input::Parameters& parameters, const Origin& origin, bool with_sensitivities) {
  const LeaderFrame frame(parameters, parameters.sections);
  const auto body = geometry::make_composite_body(parameters);
  const auto n_failed = std::ranges::count(samples, SampleStatus::failed, &SampleSummary::status);
  Json document{{"n_samples", statistics.n_samples},
                {"n_needed", statistics.n_needed},
                {"n_done", statistics.n_done},
                {"n_failed", n_failed},
                {"n_undecided", std::ranges::count_if(samples, is_undecided)},
                {"n_unbroken", std::ranges::count_if(samples, is_unbroken)},
                {"n_held", std::ranges::count_if(samples, is_held)},
                {"headline_load", headline_load(samples)},
                {"n_left", statistics.n_needed - statistics.n_done - n_failed},
                {"notes", origin.notes},
                {"warnings", ensemble_warnings(samples)},
                {"input", parameters.text}};
  geometry::for_each_member(geometry::outline_of(*body),
                            [&](const char* name, const Shape& shape, const auto& values, const char*,
                                const char*) { document["specimen"][name] = table(values, shape); });
  document["results"] =
      describe_results(result_statistics(samples, statistics.confidence, origin, statistics.replicates));
  if (statistics.has_strength_scatter && statistics.replicates == 1)
    document["weibull"] = weibull_of(samples, statistics.confidence);
  document["samples"] = samples_of(samples, statistics, origin);
  document["crack_path"] = crack_path(
      samples, parameters.sections,
      {static_cast<std::size_t>(statistics.n_starts), static_cast<std::size_t>(statistics.n_sections)});
  document["crack_path"]["leader"] = leaders(samples, frame);
  document["sampling"] = sampling_of(parameters);
  document["statistics"] =
      statistics_of(with_running_half_widths(statistics, samples, frame), frame, samples, parameters);
  if (!parameters.sections.planes.empty()) {
    document["plane_traces"] = traces_of(samples, statistics, parameters.sections.planes);
    document["statistics"]["traces"] = trace_statistics(statistics);
  }
  if (statistics.fragments.n_of > 0) {
    document["fragments"] = fragments_of(samples);
    document["statistics"]["fragments"] = fragment_statistics(statistics.fragments);
  }
  if (!parameters.random.empty()) {
    document["inputs"] = inputs_of(samples, parameters.random);
    if (with_sensitivities) document["sensitivities"] = sensitivities_of(samples, parameters);
  }
  // A file name in a message may not be valid UTF-8.
  return document.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace crackle::analysis
