// SPDX-License-Identifier: GPL-3.0-or-later
// The saw-tooth law, and the energy dissipated by single tetrahedra.
#include "fracture/breakable_body.h"
#include "fracture/equivalent_stress.h"
#include "fracture/softening.h"

#include "support/box_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <vector>

namespace crackle::fracture {
namespace CRACKLE_TEST_FILE {

using input::SofteningCurve;
using mechanics::Symmetric;

constexpr double strength = 35e6;
constexpr auto curves = {SofteningCurve::linear, SofteningCurve::exponential};

double exact_peak(SofteningCurve curve, double opening, double ductility) {
  // The area under the curve is half the ductility, in units of strength times elastic strain at the
  // strength.
  return curve == SofteningCurve::linear ? 1 - opening / ductility : std::exp(-opening / (ductility / 2));
}

TEST(SofteningLaw, DissipatesExactlyWhatItShould) {
  double worst = 0;
  for (const auto curve : curves) {
    for (const int n_teeth : {2, 5, 10, 30, 100}) {
      for (const double ductility : {2.5, 4.0, 10.0, 100.0}) {
        const auto teeth = SofteningLaw(curve, n_teeth).teeth(ductility);
        ASSERT_EQ(std::ssize(teeth), n_teeth);
        EXPECT_EQ(teeth.front().share, 1);
        EXPECT_EQ(teeth.front().threshold, 1);
        for (std::size_t k = 1; k < teeth.size(); ++k) {
          EXPECT_LT(teeth[k].share, teeth[k - 1].share);
          EXPECT_GT(teeth[k].threshold, teeth[k - 1].threshold);
          EXPECT_NEAR(teeth[k].share * teeth[k].threshold, 1 - static_cast<double>(k) / n_teeth, 1e-11);
        }
        EXPECT_GT(teeth.back().share, 0);
        worst = std::max(worst, std::abs(dissipation(teeth) / ductility - 1));
      }
    }
  }
  std::printf("largest error of the dissipated energy: %.1e\n", worst);
  EXPECT_LT(worst, 1e-10);
}

TEST(SofteningLaw, FollowsItsCurveTheCloserTheMoreTeethThereAre) {
  for (const auto curve : curves) {
    double last = 1;
    for (const int n_teeth : {5, 20, 80}) {
      double worst = 0;
      for (const auto& [share, threshold] : SofteningLaw(curve, n_teeth).teeth(8)) {
        const double stress = share * threshold;
        worst = std::max(worst, std::abs(stress - exact_peak(curve, threshold - stress, 8)));
      }
      std::printf("%3d teeth: peaks within %.4f of the strength of the %s curve\n", n_teeth, worst,
                  curve == SofteningCurve::linear ? "linear" : "exponential");
      EXPECT_LT(worst, 0.5 * last);
      last = worst;
    }
    EXPECT_LT(last, 0.03);
  }
}

TEST(SofteningLaw, BreaksAtOnceWhatWouldSnapBack) {
  for (const double ductility : {0.0, 0.5, 1.0})
    EXPECT_EQ(SofteningLaw(SofteningCurve::linear, 10).teeth(ductility).size(), 1U);
  EXPECT_EQ(SofteningLaw(SofteningCurve::linear, 10).teeth(1.01).size(), 10U);
  EXPECT_EQ(SofteningLaw(SofteningCurve::exponential, 10).teeth(1.5).size(), 1U);
}

/// A tetrahedron stretched increasingly in one strain direction.
class OneTetrahedron : public testing::Test {
protected:
  /// @return the strain at each tooth, as a multiple of that at which the stress reaches the strength
  std::vector<double> stretch(const Symmetric& direction, const SofteningLaw& law, double dissipation) {
    body_.set_release(std::make_unique<Softening>(law, std::vector<double>(6, dissipation)));
    const Symmetric unit = scaled(direction, strength / value_(body_.intact_stress(0, direction)));
    std::vector<double> at;
    for (double strain = 0.5; !body_.is_broken(0); strain += 1e-3) {
      const double load = value_(body_.intact_stress(0, scaled(unit, strain)));
      if (load <= law_.strength(0)) continue;
      const std::size_t n_changes = body_.changes().size();
      body_.release(0, scaled(unit, strain), 0, 0);
      law_.take_over(body_, body_.changes().subspan(n_changes));
      at.push_back(strain);
      // Unloading returns to the origin, with the remaining stiffness.
      for (const double back : {0.7, 0.2}) {
        const Symmetric less = scaled(unit, back * strain);
        const double share = body_.is_broken(0) ? 0 : body_.stiffness_reductions().back().share;
        const Symmetric expected = body_.intact_stress(0, less),
                        found = body_.residual_stiffness().stress(0, less);
        for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(found[i], share * expected[i], 1e-6 * strength);
      }
    }
    return at;
  }
  static std::unique_ptr<Release> exponential() {
    return std::make_unique<Softening>(SofteningLaw(SofteningCurve::exponential, 7),
                                       std::vector<double>(6, 1e7));
  }
  double released() const {
    const auto energies = body_.released_energies();
    EXPECT_TRUE(std::ranges::all_of(energies, [](double energy) { return energy > 0; }));
    return std::accumulate(energies.begin(), energies.end(), 0.0);
  }
  static Symmetric scaled(Symmetric tensor, double factor) {
    for (double& component : tensor) component *= factor;
    return tensor;
  }

  geometry::Realization mesh_ = test::make_box({.size = {1e-3, 1e-3, 1e-3}, .cells = {1, 1, 1}});
  geometry::Subdomain subdomain_ = test::whole(mesh_);
  BreakableBody body_{subdomain_, test::epoxy()};
  FractureLaw law_ = test::tuler_butcher({.strength = strength, .exponent = 2, .impulse = 1e4}, subdomain_);
  LargestPrincipalStress value_;
};

/// For strains as at crack fronts, and one with shear.
class InAnyStrain : public OneTetrahedron, public testing::WithParamInterface<Symmetric> {};

TEST_P(InAnyStrain, DissipatesItsToughnessForTheWidthOfItsBand) {
  const double band = 0.1e-3, toughness = 150;
  const auto at = stretch(GetParam(), {SofteningCurve::linear, 20}, toughness / band);
  const double volume = body_.operators().tetrahedra[0].volume;
  const double found = released() / (volume / band);
  std::printf("%zu teeth at %.3f to %.3f of the strain at the strength: %.3f J/m^2 of %.0f\n", at.size(),
              at.front(), at.back(), found, toughness);
  EXPECT_NEAR(at.front(), 1, 2e-3);
  EXPECT_NEAR(found, toughness, 2e-3 * toughness);  // strains increase in steps of 1e-3
  EXPECT_EQ(body_.stiffness_reductions().size() + 1, at.size());
}

INSTANTIATE_TEST_SUITE_P(Strains, InAnyStrain,
                         testing::Values(Symmetric{-0.38, -0.38, 1, 0, 0, 0}, Symmetric{0, 0, 1, 0, 0, 0},
                                         Symmetric{0, 1, 1, 0, 0, 0}, Symmetric{1, 1, 1, 0, 0, 0},
                                         Symmetric{0.2, -0.1, 1, 0.5, -0.3, 0.2}));

TEST_F(OneTetrahedron, BreaksAtOnceWhereItHoldsMoreThanTheToughness) {
  const double held = strength * strength / (2 * test::epoxy().youngs_modulus);
  const auto at = stretch({-0.38, -0.38, 1, 0, 0, 0}, {SofteningCurve::linear, 20}, 0.9 * held);
  EXPECT_EQ(at.size(), 1U);
  EXPECT_TRUE(body_.stiffness_reductions().empty());
  EXPECT_NEAR(released(), held * body_.operators().tetrahedra[0].volume, 5e-3 * released());
}

/// The records suffice for continuing.
TEST_F(OneTetrahedron, GoesOnFromItsRecords) {
  body_.set_release(exponential());
  const Symmetric strain = scaled({-0.38, -0.38, 1, 0, 0, 0}, strength / test::epoxy().youngs_modulus);
  for (int i = 0; i < 3; ++i) body_.release(2, scaled(strain, 1 + i), 1, 2);
  BreakableBody restored(subdomain_, test::epoxy(), exponential());
  const auto falls = body_.stiffness_reductions();
  restored.restore({{}, {}, {falls.begin(), falls.end()}});
  EXPECT_EQ(restored.release_law().threshold(2), body_.release_law().threshold(2));
  EXPECT_GT(restored.release_law().threshold(2), 1);
  EXPECT_EQ(restored.residual_stiffness().stress(2, strain), body_.residual_stiffness().stress(2, strain));
  EXPECT_EQ(restored.released_energies(), body_.released_energies());
  EXPECT_TRUE(std::ranges::equal(restored.changes(), body_.changes()));
}

/// After the first tooth the criterion has no more delay.
TEST_F(OneTetrahedron, GivesWayWithoutDelayOnceItHasBegunTo) {
  const double over = 1.0001;
  EXPECT_FALSE(law_.advance(0, over * strength, over * strength, over * strength));
  law_.criterion().soften(0, 1.5);
  EXPECT_EQ(law_.strength(0), 1.5 * strength);
  EXPECT_FALSE(law_.advance(0, 1.4 * strength, 1.45 * strength, 1.47 * strength));
  EXPECT_TRUE(law_.advance(0, 1.4 * strength, 1.45 * strength, 1.49 * strength));
  EXPECT_EQ(law_.time_to_failure(0, 1.51 * strength), 0);
  EXPECT_EQ(law_.time_to_failure(0, 1.49 * strength), infinity);
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::fracture
