// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/sample_schedule.h"

#include "crackle/common/packing.h"
#include "crackle/common/stopwatch.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/message.h"
#include "crackle/parallel/sleeping_wait.h"

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

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
  parallel::send_array(world, prepared.realization.nodes, rank, work_tag);
  parallel::send_array(world, prepared.realization.tetrahedra, rank, work_tag);
  parallel::send_array(world, prepared.realization.boundary, rank, work_tag);
}

/// Master: answers a request with the end of work.
void send_no_work(const parallel::Communicator& world, int rank) {
  parallel::send_array(world, std::vector<std::byte>{}, rank, work_tag);
}

/// Master: asks a busy group to park its sample.
void send_stop(const parallel::Communicator& world, int rank) {
  parallel::check_mpi(MPI_Send(nullptr, 0, MPI_BYTE, rank, stop_tag, world.get()), "MPI_Send");
}

/// Root of a group: true if the master has asked it to park.
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
/// @param make for samples without a realization from the master
std::optional<PreparedSample> receive_work(const parallel::Communicator& world,
                                           const RealizationMaker& make) {
  const auto bytes = parallel::receive_array<std::byte>(world, master, work_tag);
  if (bytes.empty()) return std::nullopt;
  Unpacker header(bytes);
  PreparedSample prepared;
  prepared.sample = header.get<std::uint64_t>();
  if (header.empty()) return prepare(make, prepared.sample);
  prepared.seconds = header.get<double>();
  prepared.realization.report = header.get<geometry::RealizationReport>();
  prepared.realization.nodes = parallel::receive_array<geometry::Point>(world, master, work_tag);
  prepared.realization.tetrahedra = parallel::receive_array<geometry::Tetrahedron>(world, master, work_tag);
  prepared.realization.boundary =
      parallel::receive_array<geometry::BoundaryTriangle>(world, master, work_tag);
  return prepared;
}

bool is_enough(const ScheduleEvents& events) {
  return events.enough && events.enough();
}

bool is_needed(const ScheduleEvents& events, std::uint64_t sample) {
  return !events.is_needed || events.is_needed(sample);
}

bool is_asked(const std::function<bool()>& stop) {
  return stop && stop();
}

void report_end(const ScheduleEvents& events, const SampleReport& report) {
  if (!report.parked)
    events.finished(report);
  else if (events.parked)
    events.parked(report);
}

void serve_groups(const parallel::Communicator& world, int n_groups, RealizationQueue& queue,
                  const SampleSteps& steps, const ScheduleEvents& events, bool groups_make) {
  std::deque<int> waiting;  // roots waiting for work, in order of their requests
  std::set<int> at_work;    // roots computing a sample
  bool is_stopping = false;
  int n_ended = 0;
  parallel::BackOff back_off;
  while (n_ended < n_groups) {
    bool idle = true;
    // Before the requests: a sample's progress must be handled before its report.
    while (const auto line = poll_progress(world)) steps.progress(*line);
    while (const auto request = poll_request(world)) {
      if (request->report) {
        report_end(events, *request->report);
        // A parked group means that everyone stops.
        is_stopping = is_stopping || request->report->parked;
      }
      at_work.erase(request->rank);
      waiting.push_back(request->rank);
      idle = false;
    }
    is_stopping = is_stopping || is_asked(steps.stop);
    if (is_stopping) {
      for (const int rank : at_work) send_stop(world, rank);
      at_work.clear();
    }
    while (!waiting.empty()) {
      if (is_stopping || queue.exhausted() || is_enough(events)) {
        send_no_work(world, waiting.front());
        waiting.pop_front();
        ++n_ended;
      } else if (const auto prepared = queue.try_take()) {
        if (!is_needed(events, prepared->sample)) continue;
        if (prepared->failed()) {
          events.finished(report_failure(steps, prepared->sample, prepared->error, prepared->seconds));
          continue;
        }
        send_work(world, waiting.front(), *prepared);
        at_work.insert(waiting.front());
        waiting.pop_front();
        events.started(prepared->sample);
      } else if (const auto sample = groups_make ? queue.pass_on() : std::nullopt) {
        if (!is_needed(events, *sample)) continue;
        send_sample(world, waiting.front(), *sample);
        at_work.insert(waiting.front());
        waiting.pop_front();
        events.started(*sample);
      } else {
        break;
      }
      idle = false;
    }
    events.tick();
    if (idle) {
      back_off.sleep();
    } else {
      back_off.reset();
    }
  }
  // Progress overtaken by the last reports must not reach a later schedule.
  while (poll_progress(world)) {
  }
}

SampleReport lead_or_report(SampleGroup& group, const SampleSteps& steps, PreparedSample prepared) {
  if (prepared.failed()) return report_failure(steps, prepared.sample, prepared.error, prepared.seconds);
  return lead_sample(group, steps, std::move(prepared));
}

/// @param tells_progress sends progress to the master
void work_in_group(const parallel::Communicator& world, SampleGroup& group, SampleSteps steps,
                   bool tells_progress) {
  if (!group.is_root()) {
    follow_samples(group, steps);
    return;
  }
  steps.stop = [&world, own = steps.stop] { return is_asked(own) || is_asked_to_stop(world); };
  steps.progress = {};
  if (tells_progress) {
    steps.progress = [&world, last = std::optional<Stopwatch>()](const std::string& line) mutable {
      if (last && last->seconds() < progress_interval) return;
      send_progress(world, line);
      last.emplace();
    };
  }
  std::optional<SampleReport> report;
  for (;;) {
    send_request(world, report);
    auto prepared = receive_work(world, steps.make);
    if (!prepared) break;
    report = lead_or_report(group, steps, std::move(*prepared));
  }
  discard_stop(world);
  send_end(group);
}

void work_alone(SampleGroup& group, const std::vector<std::uint64_t>& samples, const SampleSteps& steps,
                const ScheduleEvents& events) {
  for (const std::uint64_t sample : samples) {
    if (is_asked(steps.stop) || is_enough(events)) break;
    if (!is_needed(events, sample)) continue;
    events.started(sample);
    events.tick();
    const auto report = lead_or_report(group, steps, prepare(steps.make, sample));
    report_end(events, report);
    if (report.parked) break;
  }
}

}  // namespace

void schedule_samples(const parallel::Communicator& world, const GroupLayout& layout,
                      const std::vector<std::uint64_t>& samples, const SampleSteps& steps,
                      const ScheduleEvents& events, QueueLimits limits, input::MeshMakers makers) {
  const int group_number = layout.group_of(world.rank());
  // One line cannot show the samples of many groups.
  const bool tells_progress = parallel::share(world, steps.progress && layout.n_groups == 1);
  // MPI_Comm_split colors must be non-negative: ranks without a group form an idle one of their own.
  const parallel::Communicator ranks =
      world.split(group_number >= 0 ? group_number : layout.n_groups, world.rank());
  if (layout.shared()) {
    SampleGroup group(ranks);
    work_alone(group, samples, steps, events);
  } else if (world.is_root()) {
    const bool groups_only = makers == input::MeshMakers::groups;
    RealizationQueue queue(groups_only ? RealizationMaker() : steps.make, samples, limits);
    serve_groups(world, layout.n_groups, queue, steps, events, makers != input::MeshMakers::master);
  } else if (group_number >= 0) {
    SampleGroup group(ranks);
    work_in_group(world, group, steps, tells_progress);
  }
  parallel::barrier_asleep(world);
}

}  // namespace crackle::ensemble
