// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parallel/communicator.h"
#include "parallel/reproducible.h"

#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace crackle::mechanics {

/// Preconditioned conjugate gradients in single precision, equivalent to KSPCG with the natural norm, but
/// bitwise equal for every partition if the system is.
///
/// @tparam System has
///   std::span<float> direction()  the owned values of the direction, at a place of the system's own;
///   double multiply(std::span<float> image)  image = K direction; returns direction . image of all ranks;
///   double precondition(std::span<const float> residual, std::span<float> result)  result = M^-1 residual;
///     returns residual . result of all ranks
template <class System>
class ConjugateGradients {
public:
  /// The references must outlive the object.
  ConjugateGradients(const parallel::Communicator& group, System& system)
      : group_(&group),
        system_(&system),
        preconditioned_(system.direction().size()),
        image_(preconditioned_.size()) {}

  struct Outcome {
    bool has_converged;
    int n_iterations;
  };
  /// How a run starts: with the preconditioned residual, or with its part conjugate to the last direction of
  /// the previous run. The latter continues after recomputing the residual as if there had been no
  /// interruption (Strzodka and Goeddeke 2006).
  enum class Start { afresh, beside_the_last };

  /// Solves from zero until the norm of the residual r in the preconditioner's scalar product, sqrt(r . M^-1
  /// r), is at most `tolerance` or NaN, or the matrix turns out not to be positive definite.
  /// Allocates nothing. Collective; does not call check_peers() before.
  /// @param residual the right-hand side on entry, the residual on return
  Outcome solve(std::span<float> residual, std::span<float> solution, double tolerance, int max_iterations,
                Start start = Start::afresh) {
    const std::span<float> p = system_->direction();
    const std::span<float> z = preconditioned_, w = image_;
    for (float& x : solution) x = 0;
    const bool goes_on = start == Start::beside_the_last && last_curvature_ > 0;
    double beta_before = 0;
    for (int n = 0;; ++n) {
      const double beta = system_->precondition(residual, z);
      const double norm = std::sqrt(std::abs(beta));
      if (norm <= tolerance) return {true, n};
      if (n == max_iterations || !std::isfinite(norm)) return {false, n};
      const auto ratio = static_cast<float>(n > 0     ? beta / beta_before
                                            : goes_on ? -dot(z, w) / last_curvature_
                                                      : 0);
      if (n == 0 && !goes_on)
        for (std::size_t i = 0; i < p.size(); ++i) p[i] = z[i];
      else
        for (std::size_t i = 0; i < p.size(); ++i) p[i] = z[i] + ratio * p[i];
      // The last direction is not exactly orthogonal to a recomputed residual.
      const double slope = n == 0 && goes_on ? dot(p, residual) : beta;
      last_curvature_ = system_->multiply(w);
      if (!(last_curvature_ > 0)) return {false, n + 1};
      const auto step = static_cast<float>(slope / last_curvature_);
      for (std::size_t i = 0; i < p.size(); ++i) {
        solution[i] += step * p[i];
        residual[i] -= step * w[i];
      }
      beta_before = beta;
    }
  }

private:
  double dot(std::span<const float> a, std::span<const float> b) const {
    return parallel::reproducible_dot(group_->get(), a, b);
  }

  const parallel::Communicator* group_;
  System* system_;
  std::vector<float> preconditioned_, image_;
  double last_curvature_ = 0;  // direction . K direction; 0 before the first one
};

}  // namespace crackle::mechanics
