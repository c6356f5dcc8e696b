// SPDX-License-Identifier: GPL-3.0-or-later
#include "ensemble/sample_schedule.h"

#include "common/packing.h"
#include "common/stopwatch.h"
#include "parallel/collectives.h"
#include "parallel/message.h"
#include "parallel/sleeping_wait.h"

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace crackle::ensemble {

namespace {

constexpr double progress_interval = 0.5;  // [s]

// Messages between the master and the roots of the groups.

constexpr int master = 0;
constexpr int request_tag = 1;
constexpr int work_tag = 2;
constexpr int stop_tag = 3;
constexpr int progress_tag = 4;

/// Root of a group to the master: requests work and reports its previous sample, if any.
void send_request(const parallel::Communicator& world, const std::optional<SampleReport>& report) {
  parallel::send_array(world, report ? to_bytes(*report) : std::vector<std::byte>{}, master, request_tag);
}

struct Request {
  int rank = 0;  ///< requesting rank
  std::optional<SampleReport> report;
};

/// Master: a request that has arrived, or empty.
std::optional<Request> poll_request(const parallel::Communicator& world) {
  const auto status = parallel::poll_message(world, MPI_ANY_SOURCE, request_tag);
  if (!status) return std::nullopt;
  Request request;
  request.rank = status->MPI_SOURCE;
  const auto bytes = parallel::receive_array<std::byte>(world, request.rank, request_tag);
  if (!bytes.empty()) request.report = from_bytes<SampleReport>(bytes);
  return request;
}

/// Master: answers a request with a sample for the group to mesh.
void send_sample(const parallel::Communicator& world, int rank, std::uint64_t sample) {
  Packer header;
  header.put(sample);
  parallel::send_array(world, header.bytes(), rank, work_tag);
}

/// Master: answers a request with a realization.
void send_work(const parallel::Communicator& world, int rank, const PreparedSample& prepared) {
  Packer header;
  header.put(prepared.sample);
  header.put(prepared.seconds);
  header.put(prepared.realization.report);
  parallel::send_array(world, header.bytes(), rank, work_tag);
  geometry::for_each_array(prepared.realization,
                           [&](const auto& array) { parallel::send_array(world, array, rank, work_tag); });
}

/// Master: answers a request with the end of work.
void send_no_work(const parallel::Communicator& world, int rank) {
  parallel::send_array(world, std::vector<std::byte>{}, rank, work_tag);
}

/// Master: asks a busy group to suspend its sample.
void send_stop(const parallel::Communicator& world, int rank) {
  parallel::check_mpi(MPI_Send(nullptr, 0, MPI_BYTE, rank, stop_tag, world.get()), "MPI_Send");
}

/// Root of a group: true if the master has asked it to suspend.
bool is_asked_to_stop(const parallel::Communicator& world) {
  return parallel::poll_message(world, master, stop_tag).has_value();
}

/// Root of a group whose work has ended: receives a stop request that came too late.
void discard_stop(const parallel::Communicator& world) {
  if (!is_asked_to_stop(world)) return;
  parallel::check_mpi(MPI_Recv(nullptr, 0, MPI_BYTE, master, stop_tag, world.get(), MPI_STATUS_IGNORE),
                      "MPI_Recv");
}

/// Root of a group to the master: the status line of its sample.
void send_progress(const parallel::Communicator& world, const std::string& line) {
  parallel::send_array(world, std::vector<char>(line.begin(), line.end()), master, progress_tag);
}

/// Master: a status line that has arrived, or empty.
std::optional<std::string> poll_progress(const parallel::Communicator& world) {
  const auto status = parallel::poll_message(world, MPI_ANY_SOURCE, progress_tag);
  if (!status) return std::nullopt;
  const auto line = parallel::receive_array<char>(world, status->MPI_SOURCE, progress_tag);
  return std::string(line.begin(), line.end());
}

/// Root of a group: sleeps until the answer comes; empty when the work has ended.
/// @param source makes the realization of a sample that comes without one
std::optional<PreparedSample> receive_work(const parallel::Communicator& world, SampleSource& source) {
  const auto bytes = parallel::receive_array<std::byte>(world, master, work_tag);
  if (bytes.empty()) return std::nullopt;
  Unpacker header(bytes);
  PreparedSample prepared;
  prepared.sample = header.get<std::uint64_t>();
  if (header.empty()) return prepare(source, prepared.sample);
  prepared.seconds = header.get<double>();
  prepared.realization.report = header.get<geometry::RealizationReport>();
  geometry::for_each_array(prepared.realization, [&]<class T>(std::vector<T>& array) {
    array = parallel::receive_array<T>(world, master, work_tag);
  });
  return prepared;
}

bool is_asked(const std::function<bool()>& stop) {
  return stop && stop();
}

void report_end(ScheduleEvents& events, const SampleReport& report) {
  if (report.suspended)
    events.suspended(report);
  else
    events.finished(report);
}

/// The master's part in a schedule: answers the groups until all have been told that no work is left.
class Master {
public:
  Master(const parallel::Communicator& world, int n_groups, RealizationQueue& queue, SampleSource& source,
         ScheduleEvents& events, bool groups_make)
      : world_(world),
        n_groups_(n_groups),
        queue_(queue),
        source_(source),
        control_(source.control()),
        events_(events),
        groups_make_(groups_make) {}

  void serve() {
    parallel::BackOff back_off;
    while (n_ended_ < n_groups_) {
      // Before the requests: a sample's progress must be handled before its report.
      while (const auto line = poll_progress(world_)) control_.progress(*line);
      const bool has_news = receive_requests();
      stop_if_asked();
      const bool has_answered = answer();
      events_.tick();
      if (has_news || has_answered)
        back_off.reset();
      else
        back_off.sleep();
    }
    // Progress overtaken by the last reports must not reach a later schedule.
    while (poll_progress(world_)) {
    }
  }

private:
  /// @return true if there were any
  bool receive_requests() {
    bool is_any = false;
    while (const auto request = poll_request(world_)) {
      if (request->report) {
        report_end(events_, *request->report);
        // When one group suspends its sample, everyone stops.
        is_stopping_ = is_stopping_ || request->report->suspended;
      }
      at_work_.erase(request->rank);
      waiting_.push_back(request->rank);
      is_any = true;
    }
    return is_any;
  }

  void stop_if_asked() {
    is_stopping_ = is_stopping_ || is_asked(control_.stop);
    if (!is_stopping_) return;
    for (const int rank : at_work_) send_stop(world_, rank);
    at_work_.clear();
  }

  /// Answers waiting groups while there is something to answer. @return true if anything was done
  bool answer() {
    bool is_any = false;
    for (; !waiting_.empty(); is_any = true) {
      if (is_stopping_ || queue_.exhausted() || events_.is_enough()) {
        send_no_work(world_, waiting_.front());
        waiting_.pop_front();
        ++n_ended_;
      } else if (const auto prepared = queue_.try_take()) {
        if (!events_.is_needed(prepared->sample)) continue;
        if (prepared->failed())
          events_.finished(report_failure(*source_.steps(prepared->sample), prepared->sample, prepared->error,
                                          prepared->seconds));
        else
          hand_out(prepared->sample, [&](int rank) { send_work(world_, rank, *prepared); });
      } else if (const auto sample = groups_make_ ? queue_.pass_on() : std::nullopt) {
        if (events_.is_needed(*sample))
          hand_out(*sample, [&](int rank) { send_sample(world_, rank, *sample); });
      } else {
        break;
      }
    }
    return is_any;
  }

  template <class Send>
  void hand_out(std::uint64_t sample, const Send& send) {
    send(waiting_.front());
    at_work_.insert(waiting_.front());
    waiting_.pop_front();
    events_.started(sample);
  }

  const parallel::Communicator& world_;
  int n_groups_;
  RealizationQueue& queue_;
  SampleSource& source_;
  dynamics::SampleControl control_;
  ScheduleEvents& events_;
  bool groups_make_;
  std::deque<int> waiting_;  ///< roots waiting for work, in order of their requests
  std::set<int> at_work_;    ///< roots computing a sample
  bool is_stopping_ = false;
  int n_ended_ = 0;
};

/// @param tells_progress sends progress to the master
void work_in_group(const parallel::Communicator& world, SampleGroup& group, SampleSource& source,
                   bool tells_progress) {
  dynamics::SampleControl control = source.control();
  if (!group.is_root()) {
    follow_samples(group, source, control);
    return;
  }
  control.stop = [&world, own = control.stop] { return is_asked(own) || is_asked_to_stop(world); };
  control.progress = {};
  if (tells_progress) {
    control.progress = [&world, last = std::optional<Stopwatch>()](const std::string& line) mutable {
      if (last && last->seconds() < progress_interval) return;
      send_progress(world, line);
      last.emplace();
    };
  }
  std::optional<SampleReport> report;
  for (;;) {
    send_request(world, report);
    auto prepared = receive_work(world, source);
    if (!prepared) break;
    report = lead_sample(group, source, control, std::move(*prepared));
  }
  discard_stop(world);
  send_end(group);
}

/// All ranks are one group, whose root is also the master.
void work_alone(SampleGroup& group, const std::vector<std::uint64_t>& samples, SampleSource& source,
                ScheduleEvents& events) {
  const dynamics::SampleControl control = source.control();
  if (!group.is_root()) {
    follow_samples(group, source, control);
    return;
  }
  for (const std::uint64_t sample : samples) {
    if (is_asked(control.stop) || events.is_enough()) break;
    if (!events.is_needed(sample)) continue;
    events.started(sample);
    events.tick();
    const auto report = lead_sample(group, source, control, prepare(source, sample));
    report_end(events, report);
    if (report.suspended) break;
  }
  send_end(group);
}

}  // namespace

void schedule_samples(const parallel::Communicator& world, const GroupLayout& layout,
                      const std::vector<std::uint64_t>& samples, SampleSource& source, ScheduleEvents& events,
                      QueueLimits limits, input::MeshMakers makers) {
  const int group_number = layout.group_of(world.rank());
  // One line cannot show the samples of many groups.
  const bool tells_progress = parallel::share(world, source.control().progress && layout.n_groups == 1);
  // MPI_Comm_split colors must be non-negative: ranks without a group form an idle one of their own.
  const parallel::Communicator ranks =
      world.split(group_number >= 0 ? group_number : layout.n_groups, world.rank());
  if (layout.shared()) {
    SampleGroup group(ranks);
    work_alone(group, samples, source, events);
  } else if (world.is_root()) {
    const auto make = [&source](std::uint64_t sample) { return source.make(sample); };
    const bool groups_only = makers == input::MeshMakers::groups;
    RealizationQueue queue(groups_only ? RealizationMaker() : make, samples, limits);
    Master(world, layout.n_groups, queue, source, events, makers != input::MeshMakers::master).serve();
  } else if (group_number >= 0) {
    SampleGroup group(ranks);
    work_in_group(world, group, source, tells_progress);
  }
  parallel::barrier_asleep(world);
}

}  // namespace crackle::ensemble
