// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/results.h"

#include "common/failure.h"
#include "common/packing.h"
#include "common/regular_file.h"
#include "cracks/crack_pattern.h"
#include "ensemble/folder_lock.h"
#include "geometry/body.h"
#include "io/ensemble_file.h"
#include "io/sample_file.h"
#include "parallel/agreement.h"
#include "parallel/collectives.h"
#include "uncertainty/random_inputs.h"

#include <fmt/format.h>

#include <optional>
#include <system_error>
#include <utility>

namespace crackle::ensemble {

namespace fs = std::filesystem;

namespace {

/// Longer than the lifetime of an untouched lock: a writer on another node may have been killed.
constexpr double lock_patience = LockFile::lifetime + 60;  // [s]

/// This rank's share of the samples, as [first, end).
std::pair<std::size_t, std::size_t> share_of_samples(const parallel::Communicator& world,
                                                     const input::Ensemble& ensemble) {
  const auto n_samples = static_cast<std::size_t>(ensemble.samples);
  const auto rank = static_cast<std::size_t>(world.rank()), n_ranks = static_cast<std::size_t>(world.size());
  return {n_samples * rank / n_ranks, n_samples * (rank + 1) / n_ranks};
}

/// This rank's share of the rows, read back from the sample files.
io::EnsembleBlock read_block(const parallel::Communicator& world, const input::Parameters& parameters,
                             const std::filesystem::path& folder) {
  const auto [first, end] = share_of_samples(world, parameters.ensemble);
  return {first, io::read_summaries(folder, parameters, first, end - first)};
}

void check_sample_files(const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder / "samples", ignored))
    if (entry.path().extension() == ".h5") return;
  fail(
      "'{}' holds no sample files, from which crossings at other sections are computed; ensemble.h5 has only "
      "its own sections",
      folder.string());
}

/// Sends rows of samples that failed without a file from the master to the rank that writes them. Collective.
void complete_block(const parallel::Communicator& world,
                    const std::map<std::uint64_t, analysis::SampleSummary>& unstored,
                    io::EnsembleBlock& block) {
  const auto packed = parallel::agree(world, [&] {
    Packer packer;
    for (const auto& [sample, row] : unstored) {
      packer.put(sample);
      packer.put(row.error);
      packer.put(row.inputs);
    }
    return packer.bytes();
  });
  const auto bytes = parallel::share(world, packed);
  parallel::agree(world, [&] {
    for (Unpacker unpacker(bytes); !unpacker.empty();) {
      const auto sample = unpacker.get<std::uint64_t>();
      auto reason = unpacker.get<std::string>();
      auto inputs = unpacker.get<std::vector<double>>();
      if (sample < block.first || sample >= block.first + block.rows.size()) continue;
      auto& row = block.rows[sample - block.first];
      if (row.status != analysis::SampleStatus::pending) continue;
      row.status = analysis::SampleStatus::failed;
      row.error = std::move(reason);
      row.inputs = std::move(inputs);
    }
  });
}

/// Fills rows of the block that have no sample file from ensemble.h5. Damaged files are still reported.
/// @throws std::runtime_error when ensemble.h5 cannot be read, or belongs to another input
void keep_rows(const fs::path& file, const input::Parameters& parameters, io::EnsembleBlock& block) {
  if (!is_taken(file)) return;
  auto known = io::read_ensemble(file, parameters).samples;
  for (std::size_t i = 0; i < block.rows.size() && block.first + i < known.size(); ++i) {
    analysis::SampleSummary& row = block.rows[i];
    if (row.status == analysis::SampleStatus::pending && row.error.empty())
      row = std::move(known[block.first + i]);
  }
}

/// @pre no other process writes ensemble.h5
void remove_partial_results(const fs::path& folder) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    const fs::path& file = entry.path();
    if (is_of_results(file) && file.extension() == ".partial") fs::remove(file, ignored);
  }
}

fs::path results_lock(const fs::path& folder) {
  return folder / "lock-ensemble.h5";
}

}  // namespace

void check_results(const fs::path& folder) {
  const fs::path file = results_file(folder), lock = results_lock(folder);
  if (const std::string obstacle = io::obstacle(file); !obstacle.empty())
    fail("{} {}; move it away, or use another folder", file.string(), obstacle);
  if (const std::string kind = other_kind(lock); !kind.empty())
    fail("{} is {}, not a lock; remove it", lock.string(), kind);
}

fs::path results_file(const fs::path& folder) {
  return folder / "ensemble.h5";
}

bool is_of_results(const fs::path& file) {
  const std::string name = results_file({}).string();
  const std::string other = file.filename().string();
  return other == name || other.starts_with(name + ".");
}

Results write_results(const parallel::Communicator& world, const input::Parameters& parameters,
                      const fs::path& folder,
                      const std::map<std::uint64_t, analysis::SampleSummary>& unstored,
                      const std::function<const geometry::MotherPoints&()>& base, MissingFiles missing) {
  const fs::path file = results_file(folder);
  Results results;
  std::optional<LockFile> lock;  // the root's
  try {
    parallel::agree_on_root(world, [&] {
      lock.emplace(results_lock(folder), "another process is writing it", lock_patience);
      check_results(folder);
      remove_partial_results(folder);
    });
  } catch (const parallel::AgreedError& error) {
    results.file_error = cannot_write(file, error.what());
  }
  auto block = parallel::agree(world, [&] {
    io::EnsembleBlock found = read_block(world, parameters, folder);
    if (missing == MissingFiles::keep_rows) keep_rows(file, parameters, found);
    return found;
  });
  complete_block(world, unstored, block);
  results.rows = analysis::gather_on_root(world, block.rows);
  parallel::agree_on_root(world,
                          [&] { results.statistics = analysis::make_statistics(results.rows, parameters); });
  analysis::Statistics& statistics = results.statistics;
  statistics.n_needed = parallel::share(world, statistics.n_needed);
  statistics.n_starts = parallel::share(world, statistics.n_starts);
  statistics.n_sections = parallel::share(world, statistics.n_sections);
  analysis::leave_out_surplus(results.statistics, 0, results.rows);
  analysis::leave_out_surplus(results.statistics, block.first, block.rows);
  if (!results.file_error.empty()) return results;
  try {
    const geometry::MotherPoints none;
    const geometry::MotherPoints* points = &none;
    parallel::agree_on_root(world, [&] { points = &base(); });
    io::write_ensemble(world, file, parameters, block, results.statistics, *points);
  } catch (const parallel::AgreedError& error) {
    results.file_error = cannot_write(file, error.what());
  }
  return results;
}

Results results_at(const parallel::Communicator& world, const input::Parameters& parameters,
                   const input::Study& sections, const fs::path& folder) {
  parallel::agree_on_root(world, [&] { check_sample_files(folder); });
  std::vector<analysis::SampleSummary> stored, measured;  // this rank's
  parallel::agree(world, [&] {
    const auto body = geometry::make_composite_body(parameters);
    const io::SampleReader reader(folder, parameters);
    const auto [first, end] = share_of_samples(world, parameters.ensemble);
    for (std::size_t sample = first; sample < end; ++sample) {
      io::StoredSample found = reader.whole(sample);
      const bool is_done = found.summary.status == analysis::SampleStatus::done;
      // Other samples may have no body.
      const auto own = is_done && !parameters.random.empty()
                           ? geometry::make_body(uncertainty::sample_parameters(parameters, sample))
                           : nullptr;
      const geometry::Body& of_sample = own ? *own : *body;
      stored.push_back(found.summary);
      measured.push_back(found.summary);
      analysis::measure_crossings(of_sample, found.surface, sections.sections, measured.back());
    }
  });
  const auto rows = analysis::gather_on_root(world, stored);
  Results results;
  results.rows = analysis::gather_on_root(world, measured);
  parallel::agree_on_root(world, [&] {
    const int n_needed = analysis::make_statistics(rows, parameters).n_needed;
    results.statistics = analysis::make_statistics(results.rows, sections, n_needed);
    analysis::leave_out_surplus(results.statistics, 0, results.rows);
  });
  return results;
}

}  // namespace crackle::ensemble
