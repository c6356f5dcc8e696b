// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/subdomain.h"
#include "crackle/parallel/communicator.h"

#include <cstdint>
#include <optional>

namespace crackle::ensemble {

/// The ranks that share a sample. The runtime's own messages and the sample's are on separate communicators.
class SampleGroup {
public:
  /// Collective over `ranks`, which is duplicated twice.
  explicit SampleGroup(const parallel::Communicator& ranks);

  const parallel::Communicator& control() const { return control_; }
  const parallel::Communicator& computation() const { return computation_; }
  bool is_root() const { return control_.is_root(); }
  int size() const { return control_.size(); }

  /// Replaces the computation's communicator, so that messages which a failed sample left behind cannot meet
  /// the next sample. Collective.
  void renew();

private:
  parallel::Communicator control_;
  parallel::Communicator computation_;
};

/// What a rank other than the root gets for a sample.
struct SampleShare {
  std::uint64_t sample = 0;
  geometry::Subdomain subdomain;
};

/// Root: sends one rank its share.
void send_share(const SampleGroup& group, int rank, std::uint64_t sample,
                const geometry::Subdomain& subdomain);

/// Root: tells the other ranks that no more samples come.
void send_end(const SampleGroup& group);

/// Other ranks: sleeps until the root sends a share; nothing when no more come.
std::optional<SampleShare> receive_share(const SampleGroup& group);

}  // namespace crackle::ensemble
