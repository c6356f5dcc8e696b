// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mpi.h>

#include <functional>
#include <string_view>
#include <utility>

namespace crackle::parallel {

/// @throws std::runtime_error with MPI's message unless `code` is MPI_SUCCESS
void check_mpi(int code, const char* call);

/// Move-only owner of a duplicated or split MPI communicator. Errors are returned. One rank needs no MPI.
class Communicator {
public:
  /// Duplicates `communicator`; where MPI is not started, this process alone. Collective over it.
  explicit Communicator(MPI_Comm communicator);
  ~Communicator();
  Communicator(Communicator&& other) noexcept { *this = std::move(other); }
  Communicator& operator=(Communicator&& other) noexcept;
  Communicator(const Communicator&) = delete;
  Communicator& operator=(const Communicator&) = delete;

  /// The sub-communicator of the ranks with the same non-negative color. Collective.
  Communicator split(int color, int key) const;

  MPI_Comm get() const { return communicator_; }
  int rank() const { return rank_; }
  int size() const { return size_; }
  bool is_root() const { return rank_ == 0; }

  using StageHook = std::function<void(std::string_view stage)>;

  /// Begins a stage of local work on this rank; its name is prefixed to the message of a failure. Local.
  /// @param stage of static storage duration
  /// @throws what on_stage() throws
  void enter(const char* stage) const {
    stage_ = stage;
    if (on_stage_) on_stage_(stage);
  }
  /// The stage entered last on this rank; empty before the first one.
  const char* stage() const { return stage_; }
  /// Calls `hook` at the beginning of every stage from now on, as tests do to inject failures; may be empty.
  void on_stage(StageHook hook) {
    stage_ = "";
    on_stage_ = std::move(hook);
  }

private:
  Communicator() = default;
  void set_up();
  MPI_Comm communicator_ = MPI_COMM_NULL;
  int rank_ = 0;
  int size_ = 1;
  mutable const char* stage_ = "";
  StageHook on_stage_;
};

}  // namespace crackle::parallel
