// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/ensemble_run.h"

#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/memory.h"
#include "crackle/ensemble/run_log.h"
#include "crackle/ensemble/sample_schedule.h"
#include "crackle/input/reader.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include "case_run.h"

#include <optional>
#include <vector>

namespace crackle::ensemble {

RunOutcome run_ensemble(const parallel::Communicator& outer, const input::Parameters& parameters,
                        const RunOptions& options, const SampleFunction& sample_function) {
  const parallel::Communicator world(outer.get());
  const double start = seconds_now();
  std::optional<RunLog> log;
  if (world.is_root() && options.log != nullptr)
    log.emplace(*options.log, options.terminal_width, seconds_now);
  RunLog* const log_or_null = log ? &*log : nullptr;
  const auto layout = parallel::agree(
      world, [&] { return make_group_layout(world.size(), parameters.ensemble.ranks_per_sample); });
  const auto body = parallel::agree(world, [&] { return geometry::make_body(parameters); });
  MasterState master;
  parallel::agree_on_root(world, [&] { plan_run(parameters, options, master); });
  check_memory(world, parameters, *body, layout, !master.plan.to_do.empty());
  geometry::MotherPoints base;
  parallel::agree_on_root(world, [&] {
    const auto say = [&](const std::string& line) {
      if (log) log->line(line);
    };
    say(describe(layout));
    if (const auto notice = input::bits_notice(parameters.time.engine); !notice.empty()) say(notice);
    base = master.plan.to_do.empty() ? base_points(options.folder, parameters)
                                     : make_shared_points(*body, parameters, say);
    lock_run(parameters, options, master);
    prepare_run(parameters, options, layout, master, log_or_null);
  });

  if (parameters.ensemble.meshes != input::MeshMakers::master) share_base(world, layout, base);

  const LockMark mark = share_mark(world, master.lock);
  StopLatch stop(with_loss(world, options.stop, mark), [log_or_null](const std::string& line) {
    if (log_or_null != nullptr) log_or_null->line(line);
  });
  SampleSteps steps = guarded(
      make_sample_steps(parameters, *body, base, options.folder, layout.ranks_per_group, sample_function),
      mark);
  steps.checkpoint_interval = options.checkpoint_interval;
  steps.enter = options.enter;
  steps.stop = [&stop] { return stop(); };
  if (log && options.terminal_width > 0) {
    steps.progress = [&master, log_or_null](const std::string& where) {
      master.progress->at_work(where);
      log_or_null->show(*master.progress, false);
    };
  }
  ScheduleEvents events = make_events(master, log_or_null);
  events.finished = [&, tell = events.finished](const SampleReport& report) {
    tell(report);
    // Stop: further samples could not be stored.
    if (!report.stored && !loss(master.lock).empty()) stop.set();
  };
  events.parked = [&, tell = events.parked](const SampleReport& report) {
    // A signal sent to all ranks may reach the group first; poll here too, so that the log names it.
    if (!stop()) stop.set();
    tell(report);
  };
  schedule_samples(world, layout, master.plan.to_do, steps, events,
                   QueueLimits{.n_realizations = static_cast<std::size_t>(layout.n_groups) + 1},
                   parameters.ensemble.meshes);
  // True if the master was asked to stop, by a signal, the time limit or another rank.
  const bool is_stopping = parallel::share(world, stop.is_set());

  return finish_run(world, parameters, options, master, base, is_stopping, log_or_null,
                    seconds_now() - start);
}

}  // namespace crackle::ensemble
