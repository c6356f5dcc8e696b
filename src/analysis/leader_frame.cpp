// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/leader_frame.h"

#include "crackle/common/index.h"
#include "crackle/geometry/symmetry.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr double tolerance = 1e-12;  ///< of sections, in the body's largest size

/// The notch that a symmetry maps `notch` on.
int image_of(const geometry::Body& body, std::uint8_t axes, int notch) {
  const geometry::Box& slot = body.slot(notch);
  const geometry::Point a = geometry::reflected(body, axes, slot.lower);
  const geometry::Point b = geometry::reflected(body, axes, slot.upper);
  for (int other = 0; other < body.n_notches(); ++other) {
    const geometry::Box& box = body.slot(other);
    bool is_image = true;
    for (std::size_t i = 0; i < 3; ++i)
      is_image = is_image && std::min(a[i], b[i]) == box.lower[i] && std::max(a[i], b[i]) == box.upper[i];
    if (is_image) return other;
  }
  return -1;
}

/// Of each section the number of its mirror image, at width - y or length - z, or -1.
std::vector<int> mirrored(const geometry::Body& body, const std::vector<input::Section>& sections) {
  const double near = tolerance * *std::max_element(body.size().begin(), body.size().end());
  std::vector<int> images;
  for (const input::Section& section : sections) {
    const double mirror = body.size()[index(section.axis)] - section.position;
    const auto image = std::find_if(sections.begin(), sections.end(), [&](const input::Section& other) {
      return other.axis == section.axis && std::abs(mirror - other.position) <= near;
    });
    images.push_back(image == sections.end() ? -1 : static_cast<int>(image - sections.begin()));
  }
  return images;
}

}  // namespace

LeaderFrame::LeaderFrame(const geometry::Body& body, const input::Sections& sections)
    : n_sections_(static_cast<int>(sections.size())) {
  const std::vector<std::uint8_t> symmetries = geometry::symmetries(body);
  const std::vector<input::Section> planes = sections.all();
  const std::vector<int> mirror = mirrored(body, planes);
  for (int leading = 0; leading < body.n_notches(); ++leading) {
    int reference = body.n_notches();
    std::uint8_t axes = 0;
    for (const std::uint8_t some : symmetries) {
      const int image = image_of(body, some, leading);
      if (image < 0 || image >= reference) continue;
      reference = image;
      axes = some;
    }
    Turn turn{};
    turn.axes = axes;
    turn.notch.resize(static_cast<std::size_t>(body.n_notches()));
    for (int notch = 0; notch < body.n_notches(); ++notch)
      turn.notch[index(image_of(body, axes, notch))] = notch;
    const auto reflects = [axes](int axis) { return (axes >> axis & 1u) != 0; };
    for (int section = 0; section < n_sections_; ++section) {
      const auto i = static_cast<std::size_t>(section);
      const int along = 3 - planes[i].axis;
      turn.section.push_back(reflects(planes[i].axis) ? mirror[i] : section);
      turn.extent.push_back(reflects(along) ? std::optional(body.size()[index(along)]) : std::nullopt);
    }
    reference_.push_back(reference);
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
