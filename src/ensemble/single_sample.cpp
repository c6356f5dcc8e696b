// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/ensemble/single_sample.h"

#include "crackle/common/failure.h"
#include "crackle/dynamics/model_limits.h"
#include "crackle/ensemble/base_points.h"
#include "crackle/ensemble/folder_lock.h"
#include "crackle/ensemble/memory.h"
#include "crackle/ensemble/sample_plan.h"
#include "crackle/input/reader.h"
#include "crackle/io/checkpoint_file.h"
#include "crackle/io/sample_file.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"
#include "crackle/parallel/sleeping_wait.h"

#include "case_run.h"

#include <fmt/format.h>

#include <optional>
#include <stdexcept>
#include <utility>

namespace crackle::ensemble {

namespace {

/// Refuses to replace an existing file of the sample.
void check_is_free(const std::filesystem::path& file, const input::Parameters& parameters,
                   std::uint64_t sample) {
  if (!std::filesystem::exists(std::filesystem::symlink_status(file))) return;
  bool has_failed = false;
  try {
    has_failed = summary_reader(parameters)(file, sample).status == analysis::SampleStatus::failed;
  } catch (const std::exception&) {
    // Damaged files are not silently replaced either.
  }
  fail("{} holds this sample already{}; keep it with --resume, or compute it again with {}--overwrite",
       file.string(), has_failed ? ", as one that failed" : "", has_failed ? "--retry-failed or " : "");
}

/// Plans the work on the sample; reads only.
SamplePlan plan_sample(const input::Parameters& parameters, const SingleSampleOptions& options) {
  const auto n_samples = static_cast<std::uint64_t>(parameters.ensemble.samples);
  const std::uint64_t sample = options.sample;
  if (sample >= n_samples) {
    fail("there is no sample {}: ensemble.samples = {} has samples 0 to {}", sample, n_samples,
         n_samples - 1);
  }
  const PlanOptions as_range{
      .resume = true, .retry_failed = options.retry_failed, .range = SampleRange{sample, sample}};
  if (options.resume) return make_plan(options.folder, parameters, as_range, summary_reader(parameters));
  check_folder(options.folder, parameters, as_range);
  SamplePlan plan;
  plan.range = {sample, sample};
  plan.to_do = {sample};
  if (options.overwrite) {
    plan.anew = {sample};
    return plan;
  }
  check_is_free(io::sample_path(options.folder, sample), parameters, sample);
  const auto checkpoint = io::checkpoint_path(options.folder, sample);
  if (std::filesystem::exists(std::filesystem::symlink_status(checkpoint))) {
    throw std::runtime_error(
        checkpoint.string() +
        " is a checkpoint of this sample; continue from it with --resume, or start again with --overwrite");
  }
  return plan;
}

}  // namespace

SampleReport run_single_sample(const parallel::Communicator& ranks, const input::Parameters& parameters,
                               const SingleSampleOptions& options, const SampleFunction& sample_function,
                               const dynamics::SampleLog& log) {
  const auto body = parallel::agree(ranks, [&] { return geometry::make_body(parameters); });
  geometry::MotherPoints base;
  const auto say = [&](const std::string& line) {
    if (log && ranks.is_root()) log(line);
  };
  StopLatch stop(options.stop, say);
  PreparedSample prepared;
  SamplePlan plan;
  std::optional<FolderLock> lock;
  parallel::agree_on_root(ranks, [&] { plan = plan_sample(parameters, options); });
  check_memory(ranks, parameters, *body, one_group(ranks.size()), !plan.to_do.empty());
  parallel::agree_on_root(ranks, [&] {
    if (const auto notice = input::bits_notice(parameters.time.engine); !notice.empty()) say(notice);
    if (!plan.to_do.empty()) base = make_shared_points(*body, parameters, say);
    lock.emplace(options.folder, SampleRange{options.sample, options.sample});
    for (const auto& line : lock->taken_over()) say(line);
    // Another run may have used the folder since the plan was made.
    plan = plan_sample(parameters, options);
    if (!plan.to_do.empty() && base.position.empty() && parameters.mesh.base == input::Base::shared)
      base = make_shared_points(*body, parameters, say);
    for (const auto& line : prepare_folder(options.folder, parameters, plan)) say(line);
    for (const auto& warning : dynamics::model_warnings(parameters, *body)) say("warning: " + warning);
  });
  SampleSteps steps =
      guarded(make_sample_steps(parameters, *body, base, options.folder, ranks.size(), sample_function),
              share_mark(ranks, lock));
  steps.log = log;
  steps.progress = options.progress;
  steps.stop = [&stop] { return stop(); };
  steps.checkpoint_interval = options.checkpoint_interval;
  parallel::agree_on_root(ranks, [&] {
    if (!plan.to_do.empty()) prepared = prepare(steps.make, options.sample);
  });

  SampleGroup group(ranks);
  SampleReport report;
  if (group.is_root()) {
    if (!plan.kept.empty()) {
      say(fmt::format("sample {} is finished already; it is kept", options.sample));
      report.sample = options.sample;
      report.summary = plan.kept.front().summary;
      report.stored = true;
    } else {
      report = prepared.failed() ? report_failure(steps, options.sample, prepared.error, prepared.seconds)
                                 : lead_sample(group, steps, std::move(prepared));
    }
    if (const auto fast = dynamics::fast_loading_warning(parameters, report.summary.first_break_time);
        !fast.empty())
      say("warning: " + fast);
    // Another rank may have seen the time limit first; poll here to log the reason.
    if (report.parked) stop();
    send_end(group);
  } else {
    follow_samples(group, steps);
  }
  parallel::barrier_asleep(ranks);
  report.summary.status = parallel::share(ranks, report.summary.status);
  report.parked = parallel::share(ranks, report.parked);
  return report;
}

}  // namespace crackle::ensemble
