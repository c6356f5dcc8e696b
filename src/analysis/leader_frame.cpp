// SPDX-License-Identifier: GPL-3.0-or-later
#include "analysis/leader_frame.h"

#include "common/index.h"
#include "geometry/outline.h"
#include "geometry/symmetry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace crackle::analysis {

namespace {

constexpr double tolerance = 1e-12;  ///< for matching sections, relative to the body's largest size

/// The section of a sample that a symmetry maps onto a section of the frame.
struct Preimage {
  int section = -1;              ///< its number; -1 if the input has none there
  std::optional<double> extent;  ///< sum of the coordinates on both, if reflected [m]
};

/// The points of a section that determine its image: for a line, its ends.
std::array<geometry::Point, 2> ends_of(const geometry::Body& body, const input::Section& section) {
  std::array<geometry::Point, 2> ends{body.bounds().lower, body.bounds().upper};
  if (section.axis == 0) {
    const auto& [from, to] = section.line;
    return {geometry::Point{0, from[0], from[1]}, geometry::Point{0, to[0], to[1]}};
  }
  for (geometry::Point& end : ends) end[index(section.axis)] = section.position;
  return ends;
}

/// The same for a section that is a line.
Preimage preimage_of_line(const geometry::Body& body, const geometry::Symmetry& symmetry,
                          const geometry::CrossPlane& line, const std::array<geometry::Point, 2>& ends,
                          const std::vector<input::Section>& sections) {
  const double allowed = tolerance * std::ranges::max(body.size());
  const std::array<geometry::Point, 2> from{symmetry.preimage(ends[0]), symmetry.preimage(ends[1])};
  const auto are_near = [&](const geometry::Point& a, const geometry::Point& b) {
    return std::max(std::abs(a[1] - b[1]), std::abs(a[2] - b[2])) <= allowed;
  };
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (sections[i].axis != 0) continue;
    const auto there = ends_of(body, sections[i]);
    if (are_near(from[0], there[0]) && are_near(from[1], there[1])) return {static_cast<int>(i), {}};
    if (are_near(from[0], there[1]) && are_near(from[1], there[0])) return {static_cast<int>(i), line.length};
  }
  return {};
}

Preimage preimage_of(const geometry::Body& body, const geometry::Symmetry& symmetry, std::size_t number,
                     const std::vector<input::Section>& sections) {
  const input::Section& section = sections[number];
  const auto [lower, upper] = ends_of(body, section);
  if (section.axis == 0)
    return preimage_of_line(body, symmetry, geometry::plane_of(section), {lower, upper}, sections);
  const geometry::Point from = symmetry.preimage(lower);
  const geometry::Point to = symmetry.preimage(upper);
  const auto gap = [&](std::size_t i) {
    const std::size_t axis = index(sections[i].axis);
    return std::max(std::abs(from[axis] - sections[i].position), std::abs(to[axis] - sections[i].position));
  };
  std::size_t nearest = number;  // among equally near ones, preferably the section itself
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (sections[i].axis != 0 && gap(i) < gap(nearest)) nearest = i;
  const geometry::Point size = body.size();
  if (gap(nearest) > tolerance * *std::ranges::max_element(size)) return {};
  Preimage found{static_cast<int>(nearest), {}};
  const std::size_t along = 3 - index(sections[nearest].axis);
  if (from[along] > to[along]) found.extent = lower[index(3 - section.axis)] + from[along];
  return found;
}

/// Bit i is set if the symmetry reverses axis i.
std::uint8_t reflected_by(const geometry::Symmetry& symmetry, const geometry::Box& bounds) {
  const geometry::Point lower = symmetry.image(bounds.lower);
  const geometry::Point upper = symmetry.image(bounds.upper);
  unsigned axes = 0;
  for (std::size_t i = 0; i < 3; ++i)
    if (lower[i] > upper[i]) axes |= 1u << i;
  return static_cast<std::uint8_t>(axes);
}

}  // namespace

LeaderFrame::LeaderFrame(const input::Model& model, const input::Sections& sections)
    : LeaderFrame(model, sections, *geometry::make_composite_body(model)) {}

LeaderFrame::LeaderFrame(const input::Model& model, const input::Sections& sections,
                         const geometry::Body& body)
    : LeaderFrame(body, geometry::loaded_symmetries(body, model), sections) {}

LeaderFrame::LeaderFrame(const geometry::Body& body, const std::vector<geometry::Symmetry>& symmetries,
                         const input::Sections& sections)
    : n_sections_(static_cast<int>(sections.size())) {
  const std::vector<input::Section> planes = sections.all();
  for (std::size_t leading = 0; leading < body.crack_starts().size(); ++leading) {
    const geometry::Symmetry& symmetry = *std::ranges::min_element(
        symmetries, {}, [&](const geometry::Symmetry& some) { return some.crack_start[leading]; });
    Mapping mapping{};
    mapping.axes = reflected_by(symmetry, body.bounds());
    mapping.start.resize(body.crack_starts().size());
    for (std::size_t start = 0; start < mapping.start.size(); ++start)
      mapping.start[index(symmetry.crack_start[start])] = static_cast<int>(start);
    for (std::size_t section = 0; section < planes.size(); ++section) {
      const Preimage found = preimage_of(body, symmetry, section, planes);
      mapping.section.push_back(found.section);
      mapping.extent.push_back(found.extent);
    }
    reference_.push_back(symmetry.crack_start[leading]);
    symmetries_.push_back(std::move(mapping));
  }
  start_names_ = geometry::outline_of(body).names;
  for (std::string& name : start_names_) std::ranges::replace(name, '-', ' ');
}

LeaderFrame::LeaderFrame(int n_starts, int n_sections)
    : n_sections_(n_sections), reference_(static_cast<std::size_t>(n_starts)) {
  std::iota(reference_.begin(), reference_.end(), 0);
  for (const auto start : reference_) start_names_.push_back(std::to_string(start));
  const auto n = static_cast<std::size_t>(n_sections);
  Mapping none{0, std::vector<int>(reference_.size()), std::vector<int>(n),
               std::vector<std::optional<double>>(n)};
  std::iota(none.start.begin(), none.start.end(), 0);
  std::iota(none.section.begin(), none.section.end(), 0);
  symmetries_.assign(reference_.size(), none);
}

std::optional<LeaderFrame::Source> LeaderFrame::source(int leading, int start, int section) const {
  const Mapping& mapping = symmetries_[index(leading)];
  const int there = mapping.section[index(section)];
  if (there < 0) return std::nullopt;
  return Source{mapping.start[index(start)], there, mapping.extent[index(section)]};
}

FramedPosition framed_position(const LeaderFrame& frame, const SampleSummary& row, int reference, int start,
                               int section) {
  if (row.leading_start < 0 || frame.reference()[index(row.leading_start)] != reference) return {};
  const auto source = frame.source(row.leading_start, start, section);
  if (!source) return {};
  const auto i = index(source->start * frame.n_sections() + source->section);
  return {true, source->extent ? *source->extent - row.position[i] : row.position[i], row.z_spread[i]};
}

}  // namespace crackle::analysis
