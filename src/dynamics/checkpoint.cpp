// SPDX-License-Identifier: GPL-3.0-or-later
#include "dynamics/checkpoint.h"

#include "common/packing.h"
#include "parallel/collectives.h"

#include <algorithm>
#include <concepts>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace crackle::fracture {

// Found by its argument.
void for_each_field(std::derived_from<Releases> auto& releases, const auto& visit) {
  visit(releases.breaks, releases.bridge_releases, releases.stiffness_reductions);
}

}  // namespace crackle::fracture

namespace crackle::dynamics {

void for_each_field(std::derived_from<MotionCheckpoint> auto& motion, const auto& visit) {
  visit(motion.nodes, motion.has_force, motion.terms, motion.n_steps, motion.n_forces, motion.frozen,
        motion.frozen_energy);
}

void for_each_field(std::derived_from<Record> auto& record, const auto& visit) {
  visit(record.name, record.unit, record.meaning, record.value);
}

void for_each_field(std::derived_from<HistoryRow> auto& row, const auto& visit) {
  visit(row.load_time, row.phase, row.energy, row.load, row.load_displacement, row.force, row.displacement,
        row.probes, row.records, row.tools, row.is_output);
}

void for_each_field(std::derived_from<EndedPhase> auto& phase, const auto& visit) {
  visit(phase.load_time, phase.time, phase.kinetic, phase.external_work, phase.dissipated, phase.separated_at,
        phase.last_break, phase.n_steps, phase.n_forces, phase.releases, phase.displacement, phase.history,
        phase.ended_loads, phase.cuts);
}

void for_each_field(std::derived_from<RunningPhase> auto& phase, const auto& visit) {
  visit(phase.load_time, phase.step, phase.last_break, phase.separation.checked_at, phase.separation.found,
        phase.separation.unloaded, phase.releases, phase.motion, phase.history, phase.load_check.checked_at,
        phase.load_check.broke_at, phase.ended_loads);
}

void for_each_field(std::derived_from<Frame> auto& frame, const auto& visit) {
  visit(frame.time, frame.displacement, frame.velocity, frame.broken);
}

/// All fields but those that only the root needs.
void for_each_field(std::derived_from<Checkpoint> auto& checkpoint, const auto& visit) {
  visit(checkpoint.precision, checkpoint.engine, checkpoint.first_break_reaction, checkpoint.ended,
        checkpoint.running, checkpoint.memory, checkpoint.energy);
}

std::vector<std::byte> to_bytes(const Checkpoint& checkpoint) {
  Packer packer;
  packer.put(crackle::to_bytes(checkpoint));
  packer.put(checkpoint.frames);
  packer.put(checkpoint.fragment_history);
  return packer.bytes();
}

Checkpoint share_checkpoint(const parallel::Communicator& group, std::span<const std::byte> bytes) {
  std::vector<std::byte> shared;
  std::vector<Frame> frames;
  std::vector<FragmentCount> fragment_history;
  if (group.is_root()) {
    try {
      Unpacker unpacker(bytes);
      shared = unpacker.get<std::vector<std::byte>>();
      frames = unpacker.get<std::vector<Frame>>();
      fragment_history = unpacker.get<std::vector<FragmentCount>>();
    } catch (const std::runtime_error&) {
      shared.clear();  // found too short on every rank
    }
  }
  auto checkpoint = from_bytes<Checkpoint>(parallel::share(group, std::move(shared)));
  checkpoint.frames = std::move(frames);
  checkpoint.fragment_history = std::move(fragment_history);
  return checkpoint;
}

std::vector<fracture::Break> gather_breaks(const parallel::Communicator& group,
                                           std::span<const fracture::Break> local) {
  auto all = parallel::gather_on_root(group, local);
  std::ranges::sort(
      all, {}, [](const fracture::Break& b) { return std::tuple(b.load_time, b.phase_time, b.tetrahedron); });
  return all;
}

std::vector<fracture::BridgeRelease> gather_bridge_releases(const parallel::Communicator& group,
                                                            std::span<const fracture::BridgeRelease> local) {
  auto all = parallel::gather_on_root(group, local);
  // Successive breaks at the same load can release edges of the same tetrahedron.
  std::ranges::sort(all, {}, [](const fracture::BridgeRelease& t) {
    return std::tuple(t.load_time, t.phase_time, t.tetrahedron, t.edges);
  });
  return all;
}

std::vector<fracture::StiffnessReduction> gather_stiffness_reductions(
    const parallel::Communicator& group, std::span<const fracture::StiffnessReduction> local) {
  auto all = parallel::gather_on_root(group, local);
  std::ranges::sort(all, {}, [](const fracture::StiffnessReduction& fall) {
    return std::tuple(fall.load_time, fall.phase_time, fall.tetrahedron, -fall.share);
  });
  return all;
}

fracture::Releases ReleasesSince::gather(const parallel::Communicator& group) const {
  return {gather_breaks(group, body_->breaks().subspan(n_breaks_)),
          gather_bridge_releases(group, body_->bridge_releases().subspan(n_bridge_releases_)),
          gather_stiffness_reductions(group, body_->stiffness_reductions().subspan(n_stiffness_reductions_))};
}

}  // namespace crackle::dynamics
