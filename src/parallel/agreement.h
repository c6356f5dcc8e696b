// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"
#include "parallel/sleeping_wait.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

namespace crackle::parallel {

/// A failure agreed on by all ranks of a group: the message of the lowest failing rank.
class AgreedError : public std::runtime_error {
public:
  AgreedError(int failing_rank, const std::string& message)
      : std::runtime_error(message), failing_rank_(failing_rank) {}
  int failing_rank() const { return failing_rank_; }

private:
  int failing_rank_;
};

/// Collective. `error` is this rank's failure, or empty. Allocates only for the error.
/// @throws AgreedError on every rank when any rank failed
void agree_on_error(const Communicator& group, const std::optional<std::string>& error);

/// The message of the current exception; for use in a catch block.
std::string current_error();

/// The same, prefixed with the group's stage; empty if it cannot be allocated.
std::string current_error(const Communicator& group) noexcept;

/// Declares that this rank has not failed. Call directly before communication within run_collectively().
/// Collective.
/// @throws AgreedError on every rank when any rank has failed
inline void check_peers(const Communicator& group) {
  agree_on_error(group, {});
}

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
      error = current_error(group);
    }
    agree_on_error(group, error);
  } else {
    std::optional<Result> result;
    try {
      result.emplace(std::forward<Work>(work)());
    } catch (...) {
      error = current_error(group);
    }
    agree_on_error(group, error);
    return std::move(*result);
  }
}

/// True if the current exception is one of these.
template <class... Exceptions>
bool is_being_handled() {
  [[maybe_unused]] const auto is = [](auto* type) {
    try {
      throw;
    } catch (const std::remove_pointer_t<decltype(type)>&) {
      return true;
    } catch (...) {
      return false;
    }
  };
  return (is(static_cast<Exceptions*>(nullptr)) || ...);
}

/// Runs `work`, which communicates over `group`; afterwards either all ranks continue or all throw the same
/// AgreedError, or one of the exceptions in Common, which `work` throws on all ranks. Collective.
///
/// Communication must be directly preceded by an agreement on `group`: check_peers(), agree_on_error() or a
/// function that begins with one. Then a rank may fail anywhere in its local work: it enters the agreement
/// that the others reach before they would wait for it. `work` must not continue after catching an
/// AgreedError, or an exception thrown on a single rank.
template <class... Common, class Work>
void run_collectively(const Communicator& group, Work&& work) {
  std::optional<std::string> error;
  try {
    std::forward<Work>(work)();
  } catch (const AgreedError&) {
    throw;
  } catch (...) {
    if (is_being_handled<Common...>()) {
      check_peers(group);
      throw;
    }
    error = current_error(group);
  }
  agree_on_error(group, error);
}

/// Runs `work`, which may take long, on the root while the other ranks sleep; afterwards either all ranks
/// continue or all throw the same AgreedError. Collective.
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

}  // namespace crackle::parallel
