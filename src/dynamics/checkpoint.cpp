// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/dynamics/checkpoint.h"

#include "crackle/parallel/collectives.h"

#include <algorithm>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace crackle::dynamics {

namespace {

void put(Packer& packer, const MotionCheckpoint& motion) {
  parallel::put(packer, motion.nodes);
  packer.put(motion.has_force);
  for (const auto* tables : {&motion.rate_work, &motion.reaction_work, &motion.remainder}) {
    packer.put<std::uint64_t>(tables->size());
    for (const auto& rows : *tables) parallel::put(packer, rows);
  }
  packer.put(motion.n_steps);
  packer.put(motion.n_forces);
}

MotionCheckpoint get_motion(Unpacker& unpacker) {
  MotionCheckpoint motion;
  motion.nodes = parallel::get_rows(unpacker);
  motion.has_force = unpacker.get<bool>();
  for (auto* tables : {&motion.rate_work, &motion.reaction_work, &motion.remainder}) {
    const auto n = unpacker.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < n; ++i) tables->push_back(parallel::get_rows(unpacker));
  }
  motion.n_steps = unpacker.get<std::int64_t>();
  motion.n_forces = unpacker.get<std::int64_t>();
  return motion;
}

void put(Packer& packer, const EndedPhase& phase) {
  for (const double value : {phase.load_time, phase.time, phase.kinetic, phase.external_work})
    packer.put(value);
  packer.put(phase.n_steps);
  packer.put(phase.n_forces);
  packer.put(phase.releases.breaks);
  packer.put(phase.releases.bridge_releases);
  parallel::put(packer, phase.displacement);
}

EndedPhase get_ended(Unpacker& unpacker) {
  EndedPhase phase;
  for (double* value : {&phase.load_time, &phase.time, &phase.kinetic, &phase.external_work})
    *value = unpacker.get<double>();
  phase.n_steps = unpacker.get<std::int64_t>();
  phase.n_forces = unpacker.get<std::int64_t>();
  phase.releases.breaks = unpacker.get_vector<fracture::Break>();
  phase.releases.bridge_releases = unpacker.get_vector<fracture::BridgeRelease>();
  phase.displacement = parallel::get_rows(unpacker);
  return phase;
}

void put(Packer& packer, const RunningPhase& phase) {
  packer.put(phase.load_time);
  packer.put(phase.step);
  packer.put(phase.last_break);
  packer.put(phase.separation.looked_at);
  packer.put(phase.separation.found.value_or(-1));
  packer.put(phase.releases.breaks);
  packer.put(phase.releases.bridge_releases);
  put(packer, phase.motion);
}

RunningPhase get_running(Unpacker& unpacker) {
  RunningPhase phase;
  phase.load_time = unpacker.get<double>();
  phase.step = unpacker.get<std::int64_t>();
  phase.last_break = unpacker.get<std::int64_t>();
  phase.separation.looked_at = unpacker.get<std::int64_t>();
  if (const auto found = unpacker.get<std::int64_t>(); found >= 0) phase.separation.found = found;
  phase.releases.breaks = unpacker.get_vector<fracture::Break>();
  phase.releases.bridge_releases = unpacker.get_vector<fracture::BridgeRelease>();
  phase.motion = get_motion(unpacker);
  return phase;
}

/// All but the frames, which the other ranks do not need.
std::vector<std::byte> shared_part(const Checkpoint& checkpoint) {
  Packer packer;
  packer.put(checkpoint.precision);
  packer.put(checkpoint.engine);
  packer.put(checkpoint.first_break_reaction);
  packer.put<std::uint64_t>(checkpoint.ended.size());
  for (const auto& phase : checkpoint.ended) put(packer, phase);
  packer.put(checkpoint.running.has_value());
  if (checkpoint.running) put(packer, *checkpoint.running);
  parallel::put(packer, checkpoint.memory);
  packer.put(checkpoint.energy);
  return packer.bytes();
}

Checkpoint from_shared_part(std::span<const std::byte> bytes) {
  Unpacker unpacker(bytes);
  Checkpoint checkpoint;
  checkpoint.precision = unpacker.get<input::Precision>();
  checkpoint.engine = unpacker.get<input::Engine>();
  checkpoint.first_break_reaction = unpacker.get<double>();
  const auto n_ended = unpacker.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < n_ended; ++i) checkpoint.ended.push_back(get_ended(unpacker));
  if (unpacker.get<bool>()) checkpoint.running = get_running(unpacker);
  checkpoint.memory = parallel::get_rows(unpacker);
  checkpoint.energy = unpacker.get_vector<EnergyRow>();
  return checkpoint;
}

}  // namespace

std::vector<std::byte> to_bytes(const Checkpoint& checkpoint) {
  Packer packer;
  packer.put(shared_part(checkpoint));
  packer.put<std::uint64_t>(checkpoint.frames.size());
  for (const Frame& frame : checkpoint.frames) {
    packer.put(frame.time);
    packer.put(frame.displacement);
    packer.put(frame.velocity);
    packer.put(frame.broken);
  }
  return packer.bytes();
}

Checkpoint share_checkpoint(const parallel::Communicator& group, std::span<const std::byte> bytes) {
  std::vector<std::byte> shared;
  std::vector<Frame> frames;
  if (group.is_root()) {
    try {
      Unpacker unpacker(bytes);
      shared = unpacker.get_vector<std::byte>();
      const auto n_frames = unpacker.get<std::uint64_t>();
      for (std::uint64_t i = 0; i < n_frames; ++i) {
        Frame& frame = frames.emplace_back();
        frame.time = unpacker.get<double>();
        frame.displacement = unpacker.get_vector<float>();
        frame.velocity = unpacker.get_vector<float>();
        frame.broken = unpacker.get<std::int64_t>();
      }
    } catch (const std::runtime_error&) {
      shared.clear();  // which every rank finds too short
    }
  }
  Checkpoint checkpoint = from_shared_part(parallel::share_bytes(group, std::move(shared)));
  checkpoint.frames = std::move(frames);
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
  // Breaks at one load, one after the other, can release edges of the same tetrahedron.
  std::ranges::sort(all, {}, [](const fracture::BridgeRelease& t) {
    return std::tuple(t.load_time, t.phase_time, t.tetrahedron, t.edges);
  });
  return all;
}

Releases ReleasesSince::gather(const parallel::Communicator& group) const {
  return {gather_breaks(group, body_->breaks().subspan(n_breaks_)),
          gather_bridge_releases(group, body_->bridge_releases().subspan(n_bridge_releases_))};
}

parallel::NumberedRows gather_memory(const parallel::Communicator& group,
                                     const geometry::Subdomain& subdomain,
                                     const fracture::Criterion& criterion) {
  parallel::NumberedRows local;
  const auto memory = criterion.memory();
  for (std::size_t t = 0; t < memory.size(); ++t)
    if (subdomain.counted[t] != 0 && memory[t] != 0) local.add(subdomain.tetrahedron_number[t], memory[t]);
  return parallel::gather_rows(group, local);
}

void restore_memory(const parallel::NumberedRows& memory, const geometry::Subdomain& subdomain,
                    fracture::Criterion& criterion) {
  for (std::size_t t = 0; t < criterion.memory().size(); ++t)
    criterion.set_memory(t, memory.number_at(subdomain.tetrahedron_number[t]));
}

}  // namespace crackle::dynamics
