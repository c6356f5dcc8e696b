// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/parallel/communicator.h"
#include "crackle/parallel/sleeping_wait.h"

#include <exception>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

namespace crackle::parallel {

/// The same failure on every rank of a group: the message of the lowest failing rank.
class AgreedError : public std::runtime_error {
public:
  AgreedError(int failing_rank, const std::string& message)
      : std::runtime_error(message), failing_rank_(failing_rank) {}
  int failing_rank() const { return failing_rank_; }

private:
  int failing_rank_;
};

/// Collective. `error` is this rank's failure, or empty.
/// @throws AgreedError on every rank when any rank failed
void agree_on_error(const Communicator& group, const std::optional<std::string>& error);

/// The message of the exception that is being handled; for use in a catch block.
std::string current_error();

/// Runs `work`, which must not communicate, on every rank; afterwards either all ranks have its value or all
/// ranks throw the same AgreedError. Collective.
template <class Work>
auto agree(const Communicator& group, Work&& work) {
  std::optional<std::string> error;
  using Result = std::invoke_result_t<Work>;
  if constexpr (std::is_void_v<Result>) {
    try {
      std::forward<Work>(work)();
    } catch (...) {
      error = current_error();
    }
    agree_on_error(group, error);
  } else {
    std::optional<Result> result;
    try {
      result.emplace(std::forward<Work>(work)());
    } catch (...) {
      error = current_error();
    }
    agree_on_error(group, error);
    return std::move(*result);
  }
}

/// Runs `work` on the root, which may take long, while the other ranks sleep; afterwards either all ranks go
/// on or all throw the same AgreedError. Collective.
template <class Work>
void agree_on_root(const Communicator& group, Work&& work) {
  std::optional<std::string> error;
  if (group.is_root()) {
    try {
      std::forward<Work>(work)();
    } catch (...) {
      error = current_error();
    }
  }
  barrier_asleep(group);
  agree_on_error(group, error);
}

/// The root's text on every rank; what the others pass is replaced. Collective.
std::string share_text(const Communicator& group, std::string text);

}  // namespace crackle::parallel
