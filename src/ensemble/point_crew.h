// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/crew.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

namespace crackle::ensemble {

/// The mother points that a crew places.
struct PointTask {
  std::uint64_t subject = 0;  ///< what the caller numbers, such as cases or samples
  int attempt = 0;
};

/// Ranks of a run that place its shared mother points. Each needs memory for all points.
inline constexpr int most_placing = 8;

/// The first ranks of a group place mother points together.
class PointCrew final : public geometry::Crew {
public:
  /// Collective.
  /// @param world must outlive the crew
  /// @param most ranks that place points; the others sleep
  explicit PointCrew(const parallel::Communicator& world, int most = std::numeric_limits<int>::max())
      : world_(world), places_(world.rank() < most) {
    if (world.size() > most) first_.emplace(world.split(places_ ? 0 : 1, world.rank()));
  }

  /// Runs `work` on the root, which may place points with for_task(). The other ranks sleep, but those of the
  /// crew run `help` with the root's task and with the regions of its mesh whenever it places points.
  /// Afterwards either all ranks continue or all throw the same AgreedError. Collective.
  void agree_on_root(const std::function<void()>& work,
                     const std::function<void(const PointTask&, std::vector<input::MeshRegion>)>& help);

  /// Root, within agree_on_root(): the crew for the points of a task; null if there are no other ranks.
  geometry::Crew* for_task(const PointTask& task);

  std::size_t size() const override { return static_cast<std::size_t>(group().size()); }
  std::size_t rank() const override { return static_cast<std::size_t>(group().rank()); }
  void run(const std::vector<input::MeshRegion>& regions, const std::function<void()>& work) override;
  void share(std::span<double> values, std::span<const std::size_t> first) override;
  std::vector<std::array<std::int32_t, 2>> gather(std::span<const std::array<std::int32_t, 2>> mine) override;

private:
  const parallel::Communicator& group() const { return first_ ? *first_ : world_; }
  void work_or_help(const std::function<void()>& work,
                    const std::function<void(const PointTask&, std::vector<input::MeshRegion>)>& help);

  const parallel::Communicator& world_;
  bool places_;
  std::optional<parallel::Communicator> first_;  ///< ranks, if not all place points; elsewhere the others
  PointTask task_;
};

}  // namespace crackle::ensemble
