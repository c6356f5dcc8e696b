// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "geometry/crew.h"
#include "parallel/communicator.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace crackle::ensemble {

/// The mother points that a crew places.
struct PointTask {
  std::uint64_t subject = 0;  ///< what the caller numbers, such as cases or samples
  int attempt = 0;
};

/// The ranks of a group place mother points together.
class PointCrew final : public geometry::Crew {
public:
  /// @param group must outlive the crew
  explicit PointCrew(const parallel::Communicator& group) : group_(group) {}

  /// Runs `work` on the root, which may place points with its crew(). The other ranks sleep, but run `help`
  /// with the root's task and with the regions of its mesh whenever it places points. Afterwards either all
  /// ranks continue or all throw the same AgreedError. Collective.
  void agree_on_root(const std::function<void()>& work,
                     const std::function<void(const PointTask&, std::vector<input::MeshRegion>)>& help);

  /// Root: the crew for the points of a task; null if there are no other ranks.
  geometry::Crew* for_task(const PointTask& task);

  std::size_t size() const override { return static_cast<std::size_t>(group_.size()); }
  std::size_t rank() const override { return static_cast<std::size_t>(group_.rank()); }
  void run(const std::vector<input::MeshRegion>& regions, const std::function<void()>& work) override;
  void share(std::span<double> values, std::span<const std::size_t> first) override;
  std::vector<std::array<std::int32_t, 2>> gather(std::span<const std::array<std::int32_t, 2>> mine) override;

private:
  const parallel::Communicator& group_;
  PointTask task_;
};

}  // namespace crackle::ensemble
