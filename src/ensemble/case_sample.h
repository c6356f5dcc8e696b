// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "ensemble/case.h"

#include <optional>

namespace crackle::ensemble {

/// The steps of a sample of a case: geometry, crack surface and summary, files in the case's folder. They use
/// the case's input and body or, with random inputs, those of the sample's draw.
class CaseSample : public SampleSteps {
public:
  /// @param of must outlive this
  CaseSample(const Case& of, std::uint64_t sample) : case_(of), sample_(sample) {}

  /// The first attempt at a realization that succeeds. @throws std::runtime_error with all reasons
  geometry::Realization make();

  std::vector<geometry::Subdomain> split(const geometry::Realization& realization, int n_parts) override;
  dynamics::SampleResult compute(const parallel::Communicator& group, const geometry::Subdomain& subdomain,
                                 dynamics::SampleControl control) override;
  SampleAnalysis analyse(const geometry::Realization& realization,
                         const dynamics::SampleResult& result) override;
  void write(const geometry::Realization& realization, const dynamics::SampleResult& result,
             const SampleAnalysis& analysis) override;
  void write_failure(const analysis::SampleSummary& failure, const PartialSample* partial) override;
  analysis::SampleSummary failure_row(const std::string& reason) override;
  bool keeps_checkpoints() const override { return true; }
  std::vector<std::byte> read_checkpoint() override;
  void write_checkpoint(std::span<const std::byte> bytes) override;
  void remove_checkpoint() override;

private:
  // Drawn when first used. They throw std::runtime_error when the drawn values make an invalid input.
  const input::Parameters& parameters();
  const geometry::Body& body();
  void write_file(const PartialSample& content, const analysis::SampleSummary& summary);

  const Case& case_;
  std::uint64_t sample_;
  int n_ranks_ = 1;  ///< of the group, recorded in the file
  std::optional<input::Parameters> drawn_;
  std::unique_ptr<const geometry::Body> drawn_body_;
};

}  // namespace crackle::ensemble
