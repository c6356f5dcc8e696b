// SPDX-License-Identifier: GPL-3.0-or-later
#include "observed_samples.h"

#include "crackle/analysis/statistics.h"
#include "crackle/common/failure.h"
#include "crackle/geometry/symmetry.h"
#include "crackle/io/sample_file.h"
#include "crackle/uncertainty/random_inputs.h"

#include "ensemble_folder.h"

#include <utility>

namespace crackle::apps {

namespace {

/// Adds the crack of a sample, if its file is usable.
bool add_crack(const io::SampleReader& reader, const input::Parameters& parameters,
               const geometry::Body& body, const std::vector<geometry::Symmetry>& symmetries,
               experiment::ObservedSample& sample) {
  const io::StoredSample stored = reader.whole(sample.number);
  tell_unusable(sample.number, stored.summary);
  if (stored.summary.status != analysis::SampleStatus::done) return false;
  if (parameters.random.empty()) {
    add_arms(body, symmetries, stored.surface, sample);
  } else {
    const input::Parameters own = uncertainty::sample_parameters(parameters, sample.number);
    const auto own_body = geometry::make_body(own);
    add_arms(*own_body, geometry::loaded_symmetries(*own_body, own), stored.surface, sample);
  }
  return true;
}

}  // namespace

experiment::ObservedSamples observed_samples(const std::filesystem::path& folder,
                                             const input::Parameters& parameters, const geometry::Body& body,
                                             bool with_arms) {
  auto rows = stored_samples(folder, parameters).rows;
  for (std::size_t i = 0; i < rows.size(); ++i) tell_unusable(i, rows[i]);
  analysis::leave_out_surplus(analysis::make_statistics(rows, parameters), 0, rows);
  auto found = experiment::sort_samples(rows, parameters.ensemble.seed);
  found.symmetries = geometry::loaded_symmetries(body, parameters);
  if (found.samples.empty()) fail("'{}' has no sample that is done and decided", folder.string());
  if (!with_arms) return found;
  const io::SampleReader reader(folder, parameters);
  std::vector<experiment::ObservedSample> with_crack;
  for (experiment::ObservedSample& sample : found.samples) {
    if (add_crack(reader, parameters, body, found.symmetries, sample))
      with_crack.push_back(std::move(sample));
    else
      found.missing.push_back(sample.number);
  }
  if (with_crack.empty())
    fail(
        "'{}' holds no sample files; paths and tips are compared with the cracks in these, loads alone with "
        "ensemble.h5, too",
        folder.string());
  found.samples = std::move(with_crack);
  return found;
}

}  // namespace crackle::apps
