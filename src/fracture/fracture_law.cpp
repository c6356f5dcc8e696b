// SPDX-License-Identifier: GPL-3.0-or-later
#include "fracture/fracture_law.h"

#include "fracture/release_time.h"
#include "parallel/agreement.h"

#include <utility>

namespace crackle::fracture {

FractureLaw::FractureLaw(const parallel::Communicator& group, const input::MaterialModel& model,
                         std::uint64_t sample, BreakableBody& body, const Steps& steps,
                         const Options& options) {
  const input::Fracture& fracture = model.fracture_of(0);
  Strengths strengths = tetrahedron_strengths(group, model, sample, body);
  for (double& strength : strengths.nucleation) strength /= options.weakening;
  auto impulses = fracture::impulses(group, model, body, strengths);
  growth_ = std::move(strengths.growth);
  criterion_ = make_criterion(fracture, std::move(strengths.nucleation), steps.used, std::move(impulses));
  screening_share_ = criterion_->screening_share(steps.stable);
  if (fracture.length > 0)
    average_ = std::make_unique<StressAverage>(body, criterion_->strengths(), fracture.length);

  if (body.changes().empty())
    body.set_release(make_release(fracture, {release_times(group, model, body), steps.used},
                                  dissipations(group, model, sample, body)));
  const bool by_means = fracture.nucleates_by_means();
  if (!options.follows_cracks || (!by_means && !fracture.separates_nucleation())) return;
  const auto spacings = local_spacings(group, body.subdomain(), body.operators());
  parallel::agree(group, [&] {
    vicinity_ = std::make_unique<CrackVicinity>(body, *criterion_, average_.get(), growth_, options.ends,
                                                spacings, by_means);
  });
  follow_cracks(group);  // those that are there from the start
}

void FractureLaw::take_over(const BreakableBody& body, std::span<const std::int32_t> changed) {
  if (!body.softens()) return;
  for (const auto t : changed)
    if (!body.is_broken(t)) criterion_->soften(index(t), body.release_law().threshold(t));
}

std::span<const std::int32_t> FractureLaw::follow_cracks(const parallel::Communicator& group,
                                                         double phase_time) {
  if (!vicinity_) return {};
  return vicinity_->update(group, phase_time);
}

parallel::NumberedRows FractureLaw::save(const parallel::Communicator& group,
                                         const geometry::Subdomain& subdomain) const {
  parallel::NumberedRows local;
  const auto memory = criterion_->memory();
  for (std::size_t t = 0; t < memory.size(); ++t)
    if (subdomain.owned[t] != 0 && memory[t] != 0) local.add(subdomain.tetrahedron_number[t], memory[t]);
  return parallel::gather_rows(group, local);
}

void FractureLaw::restore(const parallel::NumberedRows& memory, const geometry::Subdomain& subdomain) {
  for (std::size_t t = 0; t < criterion_->memory().size(); ++t)
    criterion_->set_memory(t, memory.number_at(subdomain.tetrahedron_number[t]));
}

std::span<const std::int32_t> FractureLaw::restore(const Releases& releases, BreakableBody& body,
                                                   double phase_time) {
  const std::size_t n_changes = body.changes().size();
  body.restore(releases, phase_time);
  const auto changes = body.changes().subspan(n_changes);
  take_over(body, changes);
  return changes;
}

}  // namespace crackle::fracture
