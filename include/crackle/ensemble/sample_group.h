// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/parallel/communicator.h"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>

namespace crackle::ensemble {

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
  std::array<std::uint64_t, 9> lengths{};  ///< lengths of the subdomain's arrays
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

}  // namespace crackle::ensemble
