// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "cracks/crack_history.h"
#include "dynamics/sample_run.h"
#include "ensemble/realization_queue.h"
#include "ensemble/sample_report.h"
#include "geometry/subdomain.h"
#include "parallel/communicator.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// A group of ranks computes a sample.
namespace crackle::ensemble {

/// Roles of the ranks: rank 0 is the master, followed by groups of `ranks_per_group` consecutive ranks that
/// share one sample each; ranks that do not fill a group stay idle until the final collective. If all ranks
/// form one group, its root is also the master.
struct GroupLayout {
  int n_ranks = 1;
  int ranks_per_group = 1;
  int n_groups = 1;
  int n_left_over = 0;

  bool shared() const { return n_ranks == ranks_per_group; }
  /// Group of a rank; -1 for the master and for leftover ranks.
  int group_of(int rank) const;
  /// The lowest rank of a group; it communicates with the master.
  int root_of(int group) const { return shared() ? 0 : 1 + group * ranks_per_group; }
};

/// @throws std::runtime_error stating the number of ranks needed, when there are too few for one group
GroupLayout make_group_layout(int n_ranks, int ranks_per_sample);

/// The layout in which all ranks share one sample.
GroupLayout one_group(int n_ranks);

/// One line for the log: ranks, master, groups, leftover ranks.
std::string describe(const GroupLayout& layout);

/// The ranks that share a sample. Control messages and the sample's computation use separate communicators.
class SampleGroup {
public:
  /// Collective over `ranks`, which is duplicated twice.
  explicit SampleGroup(const parallel::Communicator& ranks)
      : control_(ranks.get()), computation_(ranks.get()) {}

  const parallel::Communicator& control() const { return control_; }
  const parallel::Communicator& computation() const { return computation_; }
  bool is_root() const { return control_.is_root(); }
  int size() const { return control_.size(); }

  /// Calls `hook` at every stage of the sample's local work on this rank, until renew().
  void on_stage(parallel::Communicator::StageHook hook) { computation_.on_stage(std::move(hook)); }

  /// Replaces the communicator of the computation, so that stale messages of a failed sample cannot reach the
  /// next one. Collective.
  void renew() { computation_ = parallel::Communicator(control_.get()); }

private:
  parallel::Communicator control_;
  parallel::Communicator computation_;
};

/// Header sent to a non-root rank before its part of a sample.
struct ShareHeader {
  std::uint64_t sample = 0;
  std::int64_t n_nodes_global = 0;
  std::int64_t n_tetrahedra_global = 0;
  std::int64_t n_owned = 0;
  std::array<std::uint64_t, 14> lengths{};  ///< lengths of the subdomain's arrays
};

/// Root: sends every other rank its part of a sample. Collective, with receive_header() and receive_share()
/// on the other ranks.
/// @param parts one for each rank; emptied, except for the root's
/// @throws AgreedError on every rank when one cannot allocate its part
void send_shares(const SampleGroup& group, std::uint64_t sample, std::span<geometry::Subdomain> parts);

/// Root: informs the other ranks that no more samples come.
void send_end(const SampleGroup& group);

/// Other ranks: sleeps until the root sends a share; empty when no more come.
std::optional<ShareHeader> receive_header(const SampleGroup& group);

/// Other ranks: the share that follows its header.
/// @throws AgreedError on every rank when one cannot allocate its part
geometry::Subdomain receive_share(const SampleGroup& group, const ShareHeader& header);

/// Results of a sample derived from its mechanics.
struct SampleAnalysis {
  cracks::CrackSurface surface;
  std::vector<cracks::CrackLine> lines;
  cracks::CrackBranches branches;
  std::vector<cracks::SectionCrossing> crossings;  ///< notches x sections
  analysis::SampleSummary summary;
  cracks::CrackHistory history;
};

/// Available data of a sample that failed part-way.
struct PartialSample {
  const geometry::Realization& realization;
  const dynamics::SampleResult& result;
  const SampleAnalysis& analysis;
};

/// The steps of processing one sample that has a realization. An exception in a step fails that sample only.
class SampleSteps {
public:
  virtual ~SampleSteps() = default;

  /// Makes one subdomain for each rank of the group; on the group's root.
  virtual std::vector<geometry::Subdomain> split(const geometry::Realization& realization, int n_parts) = 0;
  /// The mechanics, on all ranks of the group. If a rank fails, no other rank may wait for it: either all
  /// ranks throw, or the others return.
  virtual dynamics::SampleResult compute(const parallel::Communicator& group,
                                         const geometry::Subdomain& subdomain,
                                         dynamics::SampleControl control) = 0;
  /// Derives the crack surface and the ensemble row from the mechanics; on the group's root.
  virtual SampleAnalysis analyse(const geometry::Realization& realization,
                                 const dynamics::SampleResult& result) = 0;
  /// Writes the sample's file; on the group's root.
  virtual void write(const geometry::Realization& realization, const dynamics::SampleResult& result,
                     const SampleAnalysis& analysis) = 0;
  /// Writes a failure to the sample's file, with the available mechanics (nullptr: none); on the group's
  /// root, or on the master if no realization was made.
  virtual void write_failure(const analysis::SampleSummary& failure, const PartialSample* partial) = 0;
  /// A row without results, for a failed sample.
  virtual analysis::SampleSummary failure_row(const std::string& reason) = 0;

  /// True, on every rank, if the following are used. An empty checkpoint means none.
  virtual bool keeps_checkpoints() const { return false; }
  virtual std::vector<std::byte> read_checkpoint() { return {}; }         ///< on the group's root
  virtual void write_checkpoint(std::span<const std::byte> /*bytes*/) {}  ///< on the group's root
  virtual void remove_checkpoint() {}                                     ///< as write_failure
};

/// The samples of a run, by number.
class SampleSource {
public:
  virtual ~SampleSource() = default;

  /// Makes the realization of a sample; throws on failure. The master calls it from a separate thread.
  virtual geometry::Realization make(std::uint64_t sample) = 0;
  virtual std::unique_ptr<SampleSteps> steps(std::uint64_t sample) = 0;
  /// Output of the samples, the request to suspend them, and the interval of checkpoints; other members are
  /// ignored. On every rank; schedule_samples() forwards `progress` from the root of a single group to rank
  /// 0.
  virtual dynamics::SampleControl control() { return {}; }
  /// Called at the start of each stage of a sample's local work, on every rank that does it; an exception
  /// fails the sample. For tests.
  virtual void enter(std::uint64_t /*sample*/, std::string_view /*stage*/) {}
};

/// Makes the realization of a sample now, as prepare().
PreparedSample prepare(SampleSource& source, std::uint64_t sample);

/// Reports a failed sample and, if possible, records the failure in its file and removes its checkpoint.
/// @param seconds spent on the sample
/// @param partial available data; nullptr: none
SampleReport report_failure(SampleSteps& steps, std::uint64_t sample, const std::string& reason,
                            double seconds, const PartialSample* partial = nullptr);

/// Root of the group: processes one sample from its realization, or the failure to make one, to its file.
/// Collective over the group, together with follow_samples on the other ranks. A sample that cannot be
/// written is reported as failed and leaves no file, so that a resumed run recomputes it. A sample that was
/// asked to suspend is reported as suspended.
/// @param control as SampleSource::control
SampleReport lead_sample(SampleGroup& group, SampleSource& source, const dynamics::SampleControl& control,
                         PreparedSample prepared);

/// Other ranks of the group: takes part in every sample that the root leads, until send_end.
void follow_samples(SampleGroup& group, SampleSource& source, const dynamics::SampleControl& control);

}  // namespace crackle::ensemble
