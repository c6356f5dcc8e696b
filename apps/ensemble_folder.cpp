// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble_folder.h"

#include "commands.h"
#include "crackle/common/failure.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/results.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/input/reader.h"
#include "crackle/io/ensemble_file.h"
#include "crackle/io/sample_file.h"
#include "crackle/parallel/collectives.h"

#include <system_error>

namespace crackle::apps {

namespace {

namespace fs = std::filesystem;

/// The first sample file of a folder; empty where it has none.
fs::path first_sample_file(const fs::path& folder) {
  fs::path first;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder / "samples", ignored))
    if (entry.path().extension() == ".h5" && (first.empty() || entry.path() < first)) first = entry.path();
  return first;
}

}  // namespace

input::Parameters input_of(const parallel::Communicator& world, const fs::path& folder) {
  const fs::path copy = folder / "input.toml";
  const fs::path results = ensemble::results_file(folder);
  // The folder holds the points too, since the input names them relative to where it was.
  const input::PointsFile points{
      .path = fs::exists(ensemble::points_copy(folder)) ? ensemble::points_copy(folder) : fs::path(),
      .digest = {}};
  if (parallel::share(world, fs::exists(copy))) return read_input(world, copy, points);
  return share_input(world, results, [&] {
    if (fs::exists(results)) return input::parse(io::read_ensemble(results).input_text, results, points);
    if (const fs::path sample = first_sample_file(folder); !sample.empty())
      return input::parse(io::read_input_text(sample), sample, points);
    fail("'{}' is not the folder of an ensemble: it holds neither input.toml nor ensemble.h5 nor samples",
         folder.string());
  });
}

}  // namespace crackle::apps
