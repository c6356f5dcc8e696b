// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "analysis/sample_summary.h"
#include "geometry/body.h"
#include "input/study.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace crackle::analysis {

/// Crack positions in the frame of the leading crack.
///
/// Crack starts that a symmetry of the loaded body maps onto each other form a class; the one with the
/// lowest number is the reference. A sample led by another start of the class is transformed by the first
/// symmetry that maps this start onto the reference: its other starts go to their images, and y and z to
/// width - y and length - z if the symmetry reflects them. Thus a section is mapped onto the section at width
/// - y or length - z; if the input has none there (to 1e-12 of the body's largest size), the position belongs
/// to no section, and the section only counts samples that are not reflected across it. A line is mapped onto
/// the line whose ends are its images; if these are reversed, positions are measured from the other end. A
/// start without an image forms its own class.
class LeaderFrame {
public:
  /// Source of a position of a transformed sample: that of `start` at `section`.
  struct Source {
    int start;
    int section;
    std::optional<double> extent;  ///< of the body, or the line, along the position, if that is reflected [m]
  };

  /// For the symmetries of the body that its boundary conditions share (geometry::loaded_symmetries).
  LeaderFrame(const input::Model& model, const input::Sections& sections);
  /// @param symmetries of the body, the identity among them
  LeaderFrame(const geometry::Body& body, const std::vector<geometry::Symmetry>& symmetries,
              const input::Sections& sections);
  /// For a body without symmetry: each start is a class of its own.
  LeaderFrame(int n_starts, int n_sections);

  int n_starts() const { return static_cast<int>(reference_.size()); }
  int n_sections() const { return n_sections_; }

  /// For people, such as "notch 0" or "free surface"; numbers without a body.
  const std::vector<std::string>& start_names() const { return start_names_; }

  /// The reference start of each start's class.
  const std::vector<std::int32_t>& reference() const { return reference_; }

  /// Axes reflected by the symmetry that transforms a sample led by `leading`: bit 1 for y, 2 for z.
  std::uint8_t reflected_axes(int leading) const {
    return symmetries_[static_cast<std::size_t>(leading)].axes;
  }

  /// For each start of the frame, the corresponding start in a sample led by `leading`.
  const std::vector<int>& starts(int leading) const {
    return symmetries_[static_cast<std::size_t>(leading)].start;
  }

  /// The crack of `start` at `section` in the frame of a sample led by `leading`; empty if such a sample does
  /// not count.
  std::optional<Source> source(int leading, int start, int section) const;

private:
  LeaderFrame(const input::Model& model, const input::Sections& sections, const geometry::Body& body);

  /// A symmetry of the body, as it maps a sample into the frame.
  struct Mapping {
    std::uint8_t axes;                          ///< reflected
    std::vector<int> start;                     ///< in the sample, for each start of the frame
    std::vector<int> section;                   ///< likewise; -1 for none
    std::vector<std::optional<double>> extent;  ///< of each section, see Source
  };

  int n_sections_;
  std::vector<std::int32_t> reference_;
  std::vector<std::string> start_names_;
  std::vector<Mapping> symmetries_;  ///< by leading start of the sample
};

/// A sample's crack at a section of the frame.
struct FramedPosition {
  bool counts = false;           ///< true if a crack that arrives counts there
  double value = not_a_number;   ///< [m]; NaN if none arrived
  double spread = not_a_number;  ///< through the thickness [m]; likewise
};

/// The crack of `start`; it counts if a start of the class of `reference` leads the sample.
FramedPosition framed_position(const LeaderFrame& frame, const SampleSummary& row, int reference, int start,
                               int section);

}  // namespace crackle::analysis
