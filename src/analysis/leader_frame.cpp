// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/leader_frame.h"

#include "crackle/common/index.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr double tolerance = 1e-12;  ///< of sections, in the body's largest size

/// The section of a sample that a symmetry maps on a section of the frame.
struct Preimage {
  int section = -1;              ///< its number; -1 where the input has none there
  std::optional<double> extent;  ///< the sum of the coordinates on both, where one is reflected [m]
};

Preimage preimage_of(const geometry::Body& body, const geometry::Symmetry& symmetry, std::size_t number,
                     const std::vector<input::Section>& sections) {
  const input::Section& section = sections[number];
  // Two of the section's points tell where it comes from.
  geometry::Point lower = body.bounds().lower;
  geometry::Point upper = body.bounds().upper;
  lower[index(section.axis)] = upper[index(section.axis)] = section.position;
  const geometry::Point from = symmetry.preimage(lower);
  const geometry::Point to = symmetry.preimage(upper);
  const auto gap = [&](std::size_t i) {
    const std::size_t axis = index(sections[i].axis);
    return std::max(std::abs(from[axis] - sections[i].position), std::abs(to[axis] - sections[i].position));
  };
  std::size_t nearest = number;  // of equally near ones the section itself, where it is one of them
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (gap(i) < gap(nearest)) nearest = i;
  const geometry::Point size = body.size();
  if (gap(nearest) > tolerance * *std::ranges::max_element(size)) return {};
  Preimage found{static_cast<int>(nearest), {}};
  const std::size_t along = 3 - index(sections[nearest].axis);
  if (from[along] > to[along]) found.extent = lower[index(3 - section.axis)] + from[along];
  return found;
}

/// Bit i is set where the symmetry turns the direction of axis i round.
std::uint8_t reflected_by(const geometry::Symmetry& symmetry, const geometry::Box& bounds) {
  const geometry::Point lower = symmetry.image(bounds.lower);
  const geometry::Point upper = symmetry.image(bounds.upper);
  unsigned axes = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (lower[i] > upper[i]) axes |= 1u << i;
  return static_cast<std::uint8_t>(axes);
}

}  // namespace

LeaderFrame::LeaderFrame(const geometry::Body& body, const input::Sections& sections)
    : n_sections_(static_cast<int>(sections.size())) {
  const std::vector<geometry::Symmetry> symmetries = body.symmetries();
  const std::vector<input::Section> planes = sections.all();
  for (std::size_t leading = 0; leading < body.crack_starts().size(); ++leading) {
    const geometry::Symmetry& symmetry = *std::ranges::min_element(
        symmetries, {}, [&](const geometry::Symmetry& some) { return some.crack_start[leading]; });
    Turn turn{};
    turn.axes = reflected_by(symmetry, body.bounds());
    turn.notch.resize(body.crack_starts().size());
    for (std::size_t start = 0; start < turn.notch.size(); ++start)
      turn.notch[index(symmetry.crack_start[start])] = static_cast<int>(start);
    for (std::size_t section = 0; section < planes.size(); ++section) {
      const Preimage found = preimage_of(body, symmetry, section, planes);
      turn.section.push_back(found.section);
      turn.extent.push_back(found.extent);
    }
    reference_.push_back(symmetry.crack_start[leading]);
    turns_.push_back(std::move(turn));
  }
}

LeaderFrame::LeaderFrame(int n_notches, int n_sections)
    : n_sections_(n_sections), reference_(static_cast<std::size_t>(n_notches)) {
  std::iota(reference_.begin(), reference_.end(), 0);
  const auto n = static_cast<std::size_t>(n_sections);
  Turn none{0, std::vector<int>(reference_.size()), std::vector<int>(n),
            std::vector<std::optional<double>>(n)};
  std::iota(none.notch.begin(), none.notch.end(), 0);
  std::iota(none.section.begin(), none.section.end(), 0);
  turns_.assign(reference_.size(), none);
}

std::optional<LeaderFrame::Source> LeaderFrame::source(int leading, int notch, int section) const {
  const Turn& turn = turns_[index(leading)];
  const int there = turn.section[index(section)];
  if (there < 0) return std::nullopt;
  return Source{turn.notch[index(notch)], there, turn.extent[index(section)]};
}

}  // namespace crackle::analysis
