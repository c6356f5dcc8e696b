// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble_folder.h"

#include "analysis/result_list.h"
#include "commands.h"
#include "common/failure.h"
#include "common/regular_file.h"
#include "ensemble/base_points.h"
#include "ensemble/results.h"
#include "ensemble/sample_plan.h"
#include "ensemble/sweep_table.h"
#include "geometry/body.h"
#include "input/reader.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "parallel/collectives.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;

/// The first sample file of a folder; empty if there is none.
fs::path first_sample_file(const fs::path& folder) {
  fs::path first;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder / "samples", ignored))
    if (entry.path().extension() == ".h5" && (first.empty() || entry.path() < first)) first = entry.path();
  return first;
}

/// The rows of a read-only ensemble: those of ensemble.h5, and of sample files not yet included.
std::vector<analysis::SampleSummary> stored_rows(const fs::path& folder,
                                                 const input::Parameters& parameters) {
  const auto n_samples = static_cast<std::size_t>(parameters.ensemble.samples);
  if (!is_taken(ensemble::results_file(folder))) return io::read_summaries(folder, parameters, 0, n_samples);
  const fs::path file = ensemble::results_file(folder);
  auto samples = io::read_ensemble(file).samples;
  if (samples.size() > n_samples)
    fail("{} holds {} samples, but ensemble.samples of {} is {}; give at least {} there", file.string(),
         samples.size(), (folder / "input.toml").string(), n_samples, samples.size());
  samples.resize(n_samples);
  const io::SampleReader reader(folder, parameters);
  for (std::size_t i = 0; i < n_samples; ++i) {
    if (samples[i].status == analysis::SampleStatus::pending) samples[i] = reader.row(i);
  }
  return samples;
}

fs::path folder_of_file(const fs::path& given) {
  std::error_code ignored;
  if (!fs::is_regular_file(given, ignored)) return given;
  const fs::path folder = given.has_parent_path() ? given.parent_path() : fs::path(".");
  if (ensemble::results_file(folder).filename() == given.filename()) return folder;
  if (given.extension() == ".h5" && folder.filename() == "samples")
    fail("{} is the file of one sample; give the ensemble's folder, {}", given.string(),
         (folder / "..").lexically_normal().string());
  fail("{} is a file; give the folder of an ensemble, or its ensemble.h5", given.string());
}

}  // namespace

fs::path folder_of(const parallel::Communicator& world, const fs::path& given) {
  std::string folder;
  // File systems may present different contents to ranks.
  parallel::agree_on_root(world, [&] { folder = folder_of_file(given).string(); });
  return parallel::share(world, folder);
}

analysis::Origin origin_of(const fs::path& folder) {
  const std::int64_t version = io::format_version(folder);
  analysis::Origin origin;
  analysis::for_each_result([&](const analysis::ResultInfo& info, auto) {
    if (info.since > version) origin.lacking.emplace_back(info.name);
  });
  const std::int64_t model = io::stored_model(folder);
  if (model != 0 && model != io::model_version)
    origin.notes.push_back(
        fmt::format("these samples are of model {}; this program's model {} gives other results", model,
                    io::model_version));
  return origin;
}

void tell_unusable(std::size_t sample, const analysis::SampleSummary& row) {
  if (row.status == analysis::SampleStatus::pending && !row.error.empty())
    notify(fmt::format("sample {} is left out: {}", sample, row.error));
}

StoredSamples stored_samples(const fs::path& folder, const input::Parameters& parameters) {
  return {stored_rows(folder, parameters), origin_of(folder)};
}

input::Parameters input_of(const parallel::Communicator& world, const fs::path& folder) {
  parallel::agree_on_root(world, [&] {
    if (is_taken(ensemble::sweep_input(folder)))
      fail("'{}' holds a sweep; give the folder of one of its cases, such as {}", folder.string(),
           (folder / "case-0").string());
  });
  const fs::path copy = folder / "input.toml";
  const fs::path results = ensemble::results_file(folder);
  parallel::agree_on_root(world, [&] { require_regular(copy); });
  // The folder also contains the files that the input names relative to its original location.
  const input::GivenFiles files = ensemble::copied_files(folder);
  const bool has_copy = parallel::share(world, is_taken(copy));
  const fs::path name = has_copy ? copy : results;
  const auto from_results = [&] {
    if (is_taken(results)) return input::parse(io::read_ensemble(results).input_text, results, files);
    if (const fs::path sample = first_sample_file(folder); !sample.empty())
      return input::parse(io::read_input_text(sample), sample, files);
    fail("'{}' is not the folder of an ensemble: it holds neither input.toml nor ensemble.h5 nor samples",
         folder.string());
  };
  input::Parameters parameters =
      has_copy ? read_input(world, copy, files) : share_input(world, name, from_results);
  bool has_own_bases = false;
  parallel::agree_on_root(world,
                          [&] { has_own_bases = io::stored_model(folder) >= io::first_model_of_own_bases; });
  if (parallel::share(world, has_own_bases)) return parameters;
  return share_input(world, name, [&] {
    return input::parse(input::completed(parameters.text, {{"mesh.base", "\"shared\""}}), name, files);
  });
}

std::vector<StoredEnsemble> stored_ensembles(const parallel::Communicator& world,
                                             const std::vector<std::string>& folders) {
  std::vector<StoredEnsemble> ensembles;
  std::vector<fs::path> found;
  for (const std::string& given : folders) found.push_back(folder_of(world, given));
  for (const fs::path& folder : found) ensembles.push_back({input_of(world, folder), {}});
  parallel::agree_on_root(world, [&] {
    for (std::size_t i = 0; i < ensembles.size(); ++i) {
      StoredEnsemble& ensemble = ensembles[i];
      ensemble.samples = stored_samples(found[i], ensemble.parameters);
      for (std::size_t k = 0; k < ensemble.samples.rows.size(); ++k)
        tell_unusable(k, ensemble.samples.rows[k]);
      const analysis::Statistics statistics =
          analysis::make_statistics(ensemble.samples.rows, ensemble.parameters);
      analysis::leave_out_surplus(statistics, 0, ensemble.samples.rows);
      if (statistics.n_done == 0) fail("'{}' has no completed sample", folders[i]);
    }
  });
  return ensembles;
}

}  // namespace crackle::apps
