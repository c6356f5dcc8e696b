// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "crackle/geometry/body.h"
#include "crackle/input/parameters.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace crackle::analysis {

/// Crack positions in the frame of the leading crack.
///
/// Notches (any crack starts) that a symmetry of the body maps onto each other form a class; the one with the
/// lowest number is the reference. A sample led by another notch of the class is transformed by the first
/// symmetry that maps this notch onto the reference: its other notches go to their images, and y and z to
/// width - y and length - z if the symmetry reflects them. Thus a section is mapped onto the section at width
/// - y or length - z; if the input has none there (to 1e-12 of the body's largest size), the position belongs
/// to no section, and the section only counts samples that are not reflected across it. A line is mapped onto
/// the line whose ends are its images; if these are reversed, positions are measured from the other end. A
/// notch without an image forms its own class.
class LeaderFrame {
public:
  /// Source of a position of a transformed sample: that of `notch` at `section`.
  struct Source {
    int notch;
    int section;
    std::optional<double> extent;  ///< of the body, or the line, along the position, if that is reflected [m]
  };

  LeaderFrame(const geometry::Body& body, const input::Sections& sections);
  /// For a body without symmetry: each notch is a class of its own.
  LeaderFrame(int n_notches, int n_sections);

  int n_notches() const { return static_cast<int>(reference_.size()); }
  int n_sections() const { return n_sections_; }

  /// The reference notch of each notch's class.
  const std::vector<std::int32_t>& reference() const { return reference_; }

  /// Axes reflected by the symmetry that transforms a sample led by `leading`: bit 1 for y, 2 for z.
  std::uint8_t reflected_axes(int leading) const { return turns_[static_cast<std::size_t>(leading)].axes; }

  /// For each notch of the frame, the corresponding notch in a sample led by `leading`.
  const std::vector<int>& notches(int leading) const {
    return turns_[static_cast<std::size_t>(leading)].notch;
  }

  /// The crack of `notch` at `section` in the frame of a sample led by `leading`; empty if such a sample does
  /// not count.
  std::optional<Source> source(int leading, int notch, int section) const;

private:
  struct Turn {
    std::uint8_t axes;                          ///< reflected
    std::vector<int> notch;                     ///< in the sample, for each notch of the frame
    std::vector<int> section;                   ///< likewise; -1 for none
    std::vector<std::optional<double>> extent;  ///< of each section, see Source
  };

  int n_sections_;
  std::vector<std::int32_t> reference_;
  std::vector<Turn> turns_;  ///< by leading notch of the sample
};

}  // namespace crackle::analysis
