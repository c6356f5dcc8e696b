// SPDX-License-Identifier: GPL-3.0-or-later
#include "crackle/analysis/sample_summary.h"

#include "crackle/mechanics/elasticity.h"
#include "crackle/parallel/agreement.h"
#include "crackle/parallel/collectives.h"

#include <climits>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>

namespace crackle::analysis {

namespace {

class Packer {
public:
  template <class Value>
  requires std::is_trivially_copyable_v<Value>
  void operator()(const Value& value) { append(&value, sizeof value); }
  void operator()(const std::string& text) { sequence(text.data(), text.size()); }
  template <class Value>
  void operator()(const std::vector<Value>& values) {
    sequence(values.data(), values.size());
  }
  std::vector<std::byte> take() { return std::move(bytes_); }

private:
  template <class Value>
  void sequence(const Value* values, std::size_t n) {
    (*this)(n);
    append(values, n * sizeof(Value));
  }
  void append(const void* data, std::size_t size) {
    const auto* first = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), first, first + size);
  }
  std::vector<std::byte> bytes_;
};

class Unpacker {
public:
  explicit Unpacker(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class Value>
  requires std::is_trivially_copyable_v<Value>
  void operator()(Value& value) { take(&value, sizeof value); }
  void operator()(std::string& text) { sequence(text); }
  template <class Value>
  void operator()(std::vector<Value>& values) {
    sequence(values);
  }
  bool at_end() const { return rest_.empty(); }

private:
  template <class Sequence>
  void sequence(Sequence& values) {
    std::size_t n = 0;
    (*this)(n);
    if (n > rest_.size() / sizeof(typename Sequence::value_type)) throw_truncated();
    values.resize(n);
    take(values.data(), n * sizeof(typename Sequence::value_type));
  }
  void take(void* target, std::size_t size) {
    if (size > rest_.size()) throw_truncated();
    if (size > 0) std::memcpy(target, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }
  [[noreturn]] static void throw_truncated() {
    throw std::runtime_error("message with a sample's row ends too early");
  }
  std::span<const std::byte> rest_;
};

/// Visits every field, in the order of the message.
template <class Summary, class Visitor>
void for_each_field(Summary& row, Visitor& visit) {
  visit(row.status);
  visit(row.error);
  visit(row.onset_force);
  visit(row.onset_time);
  visit(row.outcome);
  visit(row.pattern);
  visit(row.overlap);
  visit(row.bifurcations);
  visit(row.kinks);
  visit(row.breaks);
  visit(row.crack_area);
  visit(row.crack_speed_max);
  visit(row.energy_error);
  visit(row.crack_speed_ratio);
  visit(row.traced_area);
  visit(row.effective_toughness);
  visit(row.z);
  visit(row.z_spread);
  visit(row.branches);
  visit(row.wall_time);
}

double traced_length(const std::vector<CrackLine>& lines) {
  double length = 0;
  for (const CrackLine& line : lines)
    for (std::size_t i = 1; i < line.points.size(); ++i)
      length += std::hypot(line.points[i].y - line.points[i - 1].y, line.points[i].z - line.points[i - 1].z);
  return length;
}

}  // namespace

SampleSummary empty_summary(int n_notches, int n_sections, SampleStatus status, std::string error) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  SampleSummary row;
  row.status = status;
  row.error = std::move(error);
  row.onset_force = none;
  row.onset_time = none;
  row.overlap = none;
  row.crack_area = none;
  row.crack_speed_max = none;
  row.energy_error = none;
  row.crack_speed_ratio = none;
  row.traced_area = none;
  row.effective_toughness = none;
  const std::size_t n = static_cast<std::size_t>(n_notches) * static_cast<std::size_t>(n_sections);
  row.z.assign(n, none);
  row.z_spread.assign(n, none);
  row.branches.assign(n, 0);
  return row;
}

SampleSummary summarize(const geometry::Body& body, const dynamics::SampleResult& result,
                        const CrackSurface& surface, const std::vector<CrackLine>& lines,
                        const input::Material& material, std::span<const double> sections) {
  SampleSummary row;
  row.status = SampleStatus::done;
  row.onset_force = result.onset_force;
  row.onset_time = result.onset_time;
  row.outcome = static_cast<std::int32_t>(result.outcome);
  row.pattern = static_cast<std::int32_t>(classify(body, surface));
  row.overlap = pattern_overlap(body, surface);
  row.bifurcations = count_bifurcations(body, surface);
  row.kinks = count_kinks(lines);
  row.breaks = static_cast<std::int64_t>(result.breaks.size());
  row.crack_area = surface.area();
  row.crack_speed_max = max_crack_speed(body, surface);
  row.energy_error = result.energy_error;
  row.crack_speed_ratio = row.crack_speed_max / mechanics::rayleigh_speed(material);
  row.traced_area = body.size()[0] * traced_length(lines);
  row.effective_toughness = row.traced_area > 0 && !result.energy.empty()
                                ? result.energy.back().released / row.traced_area
                                : std::numeric_limits<double>::quiet_NaN();
  for (const SectionCrossing& crossing : section_crossings(body, surface, sections)) {
    row.z.push_back(crossing.z);
    row.z_spread.push_back(crossing.spread);
    row.branches.push_back(crossing.branches);
  }
  const dynamics::SampleTimings& timings = result.timings;
  row.wall_time = timings.mesh + timings.setup + timings.quasi_static + timings.dynamic;
  return row;
}

std::vector<std::byte> to_bytes(const SampleSummary& summary) {
  Packer pack;
  for_each_field(summary, pack);
  return pack.take();
}

SampleSummary summary_from_bytes(std::span<const std::byte> bytes) {
  SampleSummary row;
  Unpacker unpack(bytes);
  for_each_field(row, unpack);
  if (!unpack.at_end()) throw std::runtime_error("message with a sample's row is too long");
  return row;
}

std::vector<SampleSummary> all_gather(const parallel::Communicator& group,
                                      std::span<const SampleSummary> rows) {
  Packer pack;
  pack(rows.size());
  for (const SampleSummary& row : rows) pack(to_bytes(row));
  const std::vector<std::byte> mine = pack.take();

  long long total = static_cast<long long>(mine.size());
  parallel::check_mpi(MPI_Allreduce(MPI_IN_PLACE, &total, 1, MPI_LONG_LONG, MPI_SUM, group.get()),
                      "MPI_Allreduce");
  if (total > INT_MAX) throw std::runtime_error("the rows of all samples are too large for one message");
  const auto all = parallel::gather_all<std::byte>(group, mine);

  std::vector<SampleSummary> gathered;
  Unpacker unpack(all);
  while (!unpack.at_end()) {
    std::size_t n_rows = 0;
    unpack(n_rows);
    for (std::size_t i = 0; i < n_rows; ++i) {
      std::vector<std::byte> row;
      unpack(row);
      gathered.push_back(summary_from_bytes(row));
    }
  }
  return gathered;
}

}  // namespace crackle::analysis
