// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/realization.h"

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

/// Makes the realization of a sample; a failure is an exception.
using RealizationMaker = std::function<geometry::Realization(std::uint64_t sample)>;

/// Makes a sample's realization from the random numbers of an attempt.
using AttemptMaker = std::function<geometry::Realization(std::uint64_t sample, int attempt)>;
inline constexpr int max_attempts = 3;

/// The first of at most three attempts that succeeds; which one stands in the realization's report. When all
/// fail, the exception has the reasons of all.
RealizationMaker with_retries(AttemptMaker make);

/// A realization ready to be handed out, or the reason why there is none.
struct PreparedSample {
  std::uint64_t sample = 0;
  geometry::Realization realization;
  std::string error;   ///< empty unless making failed
  double seconds = 0;  ///< wall time that making took
  bool failed() const { return !error.empty(); }
};

/// Makes one realization now; never throws what `make` throws.
PreparedSample prepare(const RealizationMaker& make, std::uint64_t sample);

/// Bytes that a realization's arrays take.
std::size_t size_in_bytes(const geometry::Realization& realization);

/// Bytes of realizations that are kept ahead of need at most.
inline constexpr std::size_t most_bytes_ahead = std::size_t{2} << 30;

/// How far ahead of need realizations are made.
struct QueueLimits {
  std::size_t n_realizations = 2;
  std::size_t n_bytes = most_bytes_ahead;  ///< one realization is kept whatever its size
};

/// Makes realizations ahead of need, one at a time, in the order of `samples`, in a thread of its own: the
/// master serves requests at once while a mesh is being made. The thread makes no MPI calls and sleeps while
/// the queue is full. Samples can be passed on to whoever makes their realizations elsewhere.
class RealizationQueue {
public:
  /// @param make is called from the queue's thread; empty: all samples are to be passed on
  RealizationQueue(RealizationMaker make, std::vector<std::uint64_t> samples, QueueLimits limits);
  /// Stops after the realization under way.
  ~RealizationQueue();
  RealizationQueue(const RealizationQueue&) = delete;
  RealizationQueue& operator=(const RealizationQueue&) = delete;

  /// The next realization, or nothing while none is ready.
  std::optional<PreparedSample> try_take();
  /// The next sample whose realization is not begun: the queue leaves it to the caller. Nothing when all are.
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
  std::size_t bytes_ = 0;    ///< of all in `ready_`
  std::size_t largest_ = 0;  ///< realization so far: what the next one is expected to take
  std::size_t n_begun_ = 0;  ///< samples that are made, being made or passed on
  std::size_t n_taken_ = 0;
  std::jthread thread_;  ///< last: it ends before what it uses
};

}  // namespace crackle::ensemble
