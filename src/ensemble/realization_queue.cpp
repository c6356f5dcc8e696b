// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/realization_queue.h"

#include "parallel/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

RealizationMaker with_retries(AttemptMaker make) {
  return [make = std::move(make)](std::uint64_t sample) {
    std::string reasons;
    for (int attempt = 0;; ++attempt) {
      try {
        return make(sample, attempt);
      } catch (const std::exception& error) {
        reasons += fmt::format("{}attempt {}: {}", attempt == 0 ? "" : "; ", attempt + 1, error.what());
        if (attempt + 1 == max_attempts) throw std::runtime_error(reasons);
      }
    }
  };
}

PreparedSample prepare(const RealizationMaker& make, std::uint64_t sample) {
  const auto start = std::chrono::steady_clock::now();
  PreparedSample prepared;
  prepared.sample = sample;
  try {
    prepared.realization = make(sample);
  } catch (...) {
    prepared.error = "mesh: " + parallel::current_error();
  }
  prepared.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return prepared;
}

std::size_t size_in_bytes(const geometry::Realization& realization) {
  std::size_t size = 0;
  geometry::for_each_array(realization,
                           [&]<class T>(const std::vector<T>& array) { size += array.size() * sizeof(T); });
  return size;
}

RealizationQueue::RealizationQueue(RealizationMaker make, std::vector<std::uint64_t> samples,
                                   QueueLimits limits)
    : make_(std::move(make)), samples_(std::move(samples)), limits_(limits) {
  if (make_) thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
}

RealizationQueue::~RealizationQueue() = default;

bool RealizationQueue::has_room() const {
  return ready_.empty() || (ready_.size() < limits_.n_realizations && bytes_ + largest_ <= limits_.n_bytes);
}

void RealizationQueue::work(const std::stop_token& stop) {
  for (;;) {
    std::uint64_t sample = 0;
    {
      std::unique_lock lock(mutex_);
      if (!room_.wait(lock, stop, [this] { return has_room(); })) return;
      if (n_begun_ == samples_.size()) return;
      sample = samples_[n_begun_++];
    }
    if (stop.stop_requested()) return;
    PreparedSample prepared = prepare(make_, sample);
    const std::lock_guard lock(mutex_);
    const std::size_t size = size_in_bytes(prepared.realization);
    bytes_ += size;
    largest_ = std::max(largest_, size);
    ready_.push_back(std::move(prepared));
  }
}

std::optional<PreparedSample> RealizationQueue::try_take() {
  std::optional<PreparedSample> taken;
  {
    const std::lock_guard lock(mutex_);
    if (ready_.empty()) return std::nullopt;
    taken = std::move(ready_.front());
    ready_.pop_front();
    bytes_ -= size_in_bytes(taken->realization);
    ++n_taken_;
  }
  room_.notify_one();
  return taken;
}

std::optional<std::uint64_t> RealizationQueue::pass_on() {
  const std::lock_guard lock(mutex_);
  if (n_begun_ == samples_.size()) return std::nullopt;
  ++n_taken_;
  return samples_[n_begun_++];
}

bool RealizationQueue::exhausted() const {
  const std::lock_guard lock(mutex_);
  return n_taken_ == samples_.size();
}

}  // namespace crackle::ensemble
