// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/realization.h"

#include <algorithm>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace crackle::ensemble {

/// Makes the realization of a sample; throws on failure.
using RealizationMaker = std::function<geometry::Realization(std::uint64_t sample)>;

/// Makes a sample's realization with the random numbers of the given attempt.
using AttemptMaker = std::function<geometry::Realization(std::uint64_t sample, int attempt)>;
inline constexpr int max_attempts = 3;

/// Returns the first of at most three attempts that succeeds; the realization's report records which. If all
/// fail, the exception contains all reasons.
RealizationMaker with_retries(AttemptMaker make);

/// A realization ready to be handed out, or the reason for its failure.
struct PreparedSample {
  std::uint64_t sample = 0;
  geometry::Realization realization;
  std::string error;   ///< empty unless meshing failed
  double seconds = 0;  ///< wall time taken to make it
  bool failed() const { return !error.empty(); }
};

/// Makes one realization now; exceptions of `make` are stored in `error`.
PreparedSample prepare(const RealizationMaker& make, std::uint64_t sample);

/// Size of a realization's arrays [byte].
std::size_t size_in_bytes(const geometry::Realization& realization);

/// Maximum size of the realizations made ahead of need [byte]; a master of any number of groups on meshes of
/// 300,000 tetrahedra thus takes less than 2 GB.
inline constexpr std::size_t most_bytes_ahead = 1'500'000'000;

/// Limits on the realizations made ahead of need.
struct QueueLimits {
  std::size_t n_realizations = 2;
  std::size_t n_bytes = most_bytes_ahead;  ///< one realization is kept whatever its size

  /// Most that a master holds of realizations of this size, the one that it hands out included [byte].
  double most_held(double size) const {
    const double ahead =
        std::min(static_cast<double>(n_realizations), std::floor(static_cast<double>(n_bytes) / size));
    return (std::max(1.0, ahead) + 1) * size;
  }
};
/// So many realizations that all groups may ask at once while the next is made.
inline QueueLimits queue_limits(int n_groups) {
  return {.n_realizations = static_cast<std::size_t>(n_groups) + 1};
}

/// Makes realizations ahead of need, one at a time, in the order of `samples`, in its own thread, so that the
/// master can serve requests while a mesh is being made. The thread makes no MPI calls and sleeps while the
/// queue is full. Samples can also be passed on, to be meshed elsewhere.
class RealizationQueue {
public:
  /// @param make called from the queue's thread; empty: all samples are passed on
  RealizationQueue(RealizationMaker make, std::vector<std::uint64_t> samples, QueueLimits limits);
  /// Stops after the realization under way.
  ~RealizationQueue();
  RealizationQueue(const RealizationQueue&) = delete;
  RealizationQueue& operator=(const RealizationQueue&) = delete;

  /// The next realization; empty while none is ready.
  std::optional<PreparedSample> try_take();
  /// The next sample whose realization is not begun; the queue leaves it to the caller. Empty if all are
  /// begun.
  std::optional<std::uint64_t> pass_on();
  /// True once every sample has been taken or passed on.
  bool exhausted() const;

private:
  void work(const std::stop_token& stop);
  bool has_room() const;

  RealizationMaker make_;
  std::vector<std::uint64_t> samples_;
  QueueLimits limits_;
  mutable std::mutex mutex_;
  std::condition_variable_any room_;
  std::deque<PreparedSample> ready_;
  std::size_t bytes_ = 0;    ///< total size of `ready_`
  std::size_t largest_ = 0;  ///< largest realization so far: expected size of the next one
  std::size_t n_begun_ = 0;  ///< samples made, being made or passed on
  std::size_t n_taken_ = 0;
  std::jthread thread_;  ///< last member: joined before the others are destroyed
};

}  // namespace crackle::ensemble
