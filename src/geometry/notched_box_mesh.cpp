// SPDX-License-Identifier: GPL-3.0-or-later
// Spacing sources and symmetries of a notched box.
#include "notched_box.h"
#include "reflection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace crackle::geometry {

std::vector<SpacingSource> NotchedBox::spacing_sources(const input::Mesh& mesh) const {
  std::vector<SpacingSource> sources;
  const double growth = shape_growth(mesh);
  for (std::size_t i = 0; i < notches_.size(); ++i) {
    const Box& slot = slots_[i];
    const input::Notch& notch = notches_[i];
    sources.push_back({faces()[8 + 3 * i].patch.domain, mesh.notch_spacing, mesh.growth,
                       fmt::format("notch_spacing at notch {}", i + 1)});
    sources.push_back(
        {slot, std::min(notch.height, notch.depth), growth,
         fmt::format("the {} of notch {}", notch.depth < notch.height ? "depth" : "height", i + 1)});
    for (std::size_t j = 0; j < i; ++j)
      sources.push_back({between(slot, slots_[j]), distance(slot, slots_[j]), growth,
                         fmt::format("the distance of notches {} and {}", j + 1, i + 1)});
    for (std::size_t id = 2; id < 6; ++id) {
      const Box& face = faces()[id].patch.domain;
      if (const double gap = distance(slot, face); gap > 0)
        sources.push_back(
            {between(slot, face), gap, growth, fmt::format("the distance of notch {} from a face", i + 1)});
    }
  }
  return sources;
}

/// The reflections that map slots onto slots, to the tolerance. A box has all eight, a plate with two
/// anti-symmetric notches has 0, x, yz and xyz.
std::vector<Symmetry> NotchedBox::symmetries() const {
  const Point size = this->size();
  std::array<std::vector<double>, 3> planes;
  for (std::size_t face = 0; face < faces().size(); ++face)
    planes[index(axis_[face])].push_back(faces()[face].patch.domain.lower[index(axis_[face])]);
  std::vector<Symmetry> result;
  for (unsigned axes = 0; axes < 8; ++axes) {
    const Reflection reflection{axes, bounds(), planes, wall_tolerance * *std::ranges::max_element(size)};
    std::vector<std::int32_t> images;
    for (const Box& slot : slots_) {
      const Point a = reflection(slot.lower);
      const Point b = reflection(slot.upper);
      const auto image = std::ranges::find_if(slots_, [&](const Box& other) {
        bool same = true;
        for (std::size_t i = 0; i < 3; ++i)
          same = same && std::min(a[i], b[i]) == other.lower[i] && std::max(a[i], b[i]) == other.upper[i];
        return same;
      });
      if (image == slots_.end()) break;
      images.push_back(static_cast<std::int32_t>(image - slots_.begin()));
    }
    if (images.size() < slots_.size()) continue;
    result.push_back(reflection.symmetry(std::move(images)));
  }
  return result;
}

}  // namespace crackle::geometry
