// SPDX-License-Identifier: GPL-3.0-or-later
// Stress intensity of pre-cracks from the static energies of two sizes: of a disk (Sneddon 1946), half
// ellipses in a surface (Newman and Raju 1981) and a crack through a strip (Feddersen).
#include "dynamics/quasi_static.h"
#include "dynamics/sample_run.h"
#include "geometry/pre_crack.h"
#include "parallel/agreement.h"
#include "parallel/exact_sum.h"

#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/job.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using std::numbers::pi;

constexpr double mm = 1e-3, stress = 1e6, modulus = 32e9, nu = 0.2;

/// A block pulled along z by a stress, free to bend: lines hold it that meet no
/// resistance.
/// @param fine where the mesh is fine
input::Parameters block(const Vector& size, const plane::Region& fine, double fine_spacing) {
  input::Parameters parameters;
  parameters.seed = 3;
  parameters.specimen.size = size;
  parameters.materials[0] = {modulus, nu, 2450};
  parameters.fracture = {.strength = 1e12, .impulse = 1e4};
  parameters.mesh.spacing = parameters.mesh.notch_spacing = 3 * mm;
  parameters.mesh.growth = 0.25;
  parameters.mesh.perturbation = 0.2;
  parameters.mesh.regions = {{fine, fine_spacing}};
  const auto hold = [&](plane::Face face, const std::array<bool, 3>& components, double z) {
    parameters.boundaries.push_back(test::boundary(face, input::BoundaryKind::fix, components));
    parameters.boundaries.back().region[2] = {z, z};
  };
  for (const double end : {0.0, size[2]}) hold(plane::Face::x_max, {true, false, false}, end);
  hold(plane::Face::y_min, {false, true, true}, size[2] / 2);
  hold(plane::Face::y_min, {false, true, false}, 0);
  for (const auto& [face, sign] : {std::pair{plane::Face::z_min, -1.0}, {plane::Face::z_max, 1.0}})
    parameters.boundaries.push_back(
        test::boundary(face, input::BoundaryKind::traction, {}, {0, 0, sign * stress}));
  return parameters;
}

double strain_energy(const input::Parameters& parameters, std::uint64_t sample) {
  auto mesh = test::realization(parameters, sample);
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  const auto subdomain = test::whole(mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  fracture::BreakableBody body(subdomain, parameters.material());
  body.set_release(fracture::make_release({}));
  const auto loads = mechanics::make_boundary_loads(self, parameters, subdomain);
  auto law = test::tuler_butcher(parameters.fracture, subdomain);
  const QuasiStaticLoading loading(self, body, loads, law, 1e-5);
  return parallel::exact_sum(self, body.strain_energies(loading.displacement().local()));
}

/// Of a mean over some meshes.
double tolerance() {
  return test::repetitions(2, 6) > 2 ? 0.04 : 0.07;
}

/// The gain of strain energy while an ellipse grows by a factor from 1 / sqrt(growth) to sqrt(growth).
double gain(input::Parameters parameters, const plane::PreCrack& crack, double growth) {
  double sum = 0;
  const int n = test::repetitions(2, 6);
  for (int sample = 0; sample < n; ++sample)
    for (const double sign : {-1.0, 1.0}) {
      plane::PreCrack sized = crack;
      for (double& axis : sized.semi_axes) axis *= std::pow(growth, sign / 2);
      parameters.specimen.cracks = {sized};
      sum += sign * strain_energy(parameters, static_cast<std::uint64_t>(sample)) / n;
    }
  return sum;
}

TEST(PreCracks, ADiskHasSneddonsStressIntensity) {
  const double a = 3 * mm, growth = 1.25;
  // Of the cylinder of equal cross-section (Tada, Paris and Irwin).
  const double share = a / (24 * mm / std::sqrt(pi));
  const double finite = (1 - share / 2 + 0.148 * std::pow(share, 3)) / std::sqrt(1 - share);
  double mean = 0;
  for (const double spacing : {0.7 * mm, 0.5 * mm}) {
    const auto parameters = block({24 * mm, 24 * mm, 30 * mm},
                                  {{{7 * mm, 17 * mm}, {7 * mm, 17 * mm}, {14 * mm, 16 * mm}}}, spacing);
    plane::PreCrack crack;
    crack.center = {12 * mm, 12 * mm, 15 * mm};
    crack.semi_axes = {a, a};
    crack.normal = {0, 0, 1};
    const double exact = 8 * (1 - nu * nu) / (3 * modulus) * std::pow(stress * finite, 2) * std::pow(a, 3) *
                         (std::pow(growth, 1.5) - std::pow(growth, -1.5));
    const double found = std::sqrt(gain(parameters, crack, growth) / exact);
    mean += found / 2;
    std::printf("disk, spacing %.1f mm: K over Sneddon's %.3f (reference 1)\n", 1e3 * spacing, found);
    EXPECT_NEAR(found, 1, tolerance());
  }
  EXPECT_NEAR(mean, 1, tolerance() - 0.01);
}

/// K^2 of a half ellipse in the surface of a plate under tension, at a place of its front [Pa^2 m].
/// @param a depth, @param c half length, @param t thickness, @param b half width of the plate [m]
double newman_raju(double a, double c, double t, double b, double angle) {
  const double shape = a / c, depth = a / t;
  const double m1 = 1.13 - 0.09 * shape, m2 = -0.54 + 0.89 / (0.2 + shape);
  const double m3 = 0.5 - 1 / (0.65 + shape) + 14 * std::pow(1 - shape, 24);
  const double q = 1 + 1.464 * std::pow(shape, 1.65);
  const double of_angle =
      std::sqrt(std::sqrt(std::pow(shape * std::cos(angle), 2) + std::pow(std::sin(angle), 2)));
  const double at_surface = 1 + (0.1 + 0.35 * depth * depth) * std::pow(1 - std::sin(angle), 2);
  const double width = 1 / std::sqrt(std::cos(pi * c / (2 * b) * std::sqrt(depth)));
  const double factor = (m1 + m2 * depth * depth + m3 * std::pow(depth, 4)) * of_angle * at_surface * width;
  return stress * stress * pi * a / q * factor * factor;
}

TEST(PreCracks, HalfEllipsesHaveTheStressIntensityOfNewmanAndRaju) {
  const double t = 6 * mm, b = 20 * mm, shape = 0.6, growth = 1.25;
  const std::vector<double> usual{0.4}, all{0.25, 0.4, 0.55};
  for (const double depth : test::is_full() ? all : usual) {
    const double a = depth * t;
    auto parameters =
        block({t, 2 * b, 40 * mm}, {{{0, 5 * mm}, {b - 7 * mm, b + 7 * mm}, {19 * mm, 21 * mm}}}, 0.4 * mm);
    parameters.mesh.spacing = parameters.mesh.notch_spacing = 1.5 * mm;
    parameters.mesh.growth = 0.15;
    plane::PreCrack crack;
    crack.center = {0, b, 20 * mm};
    crack.semi_axes = {a, a / shape};
    crack.normal = {0, 0, 1};
    // The front moves by its place times the growth, along its normal: per angle by a c.
    double exact = 0;
    constexpr int n_sizes = 20, n_angles = 60;
    for (int i = 0; i < n_sizes; ++i) {
      const double size = std::pow(growth, (i + 0.5) / n_sizes - 0.5),
                   step = size * std::log(growth) / n_sizes;
      for (int k = 0; k < n_angles; ++k)
        exact += newman_raju(a * size, a * size / shape, t, b, pi * (k + 0.5) / n_angles) * a * size * a /
                 shape * step * pi / n_angles;
    }
    exact *= (1 - nu * nu) / modulus;
    const double found = std::sqrt(gain(parameters, crack, growth) / exact);
    std::printf("half ellipse, depth %.2f of the thickness: K over Newman and Raju's %.3f (reference 1)\n",
                depth, found);
    EXPECT_NEAR(found, 1, tolerance());
  }
}

/// Beside the slots of test_stress_intensity.cpp.
TEST(PreCracks, ACrackThroughAStripHasFeddersensStressIntensity) {
  auto parameters = test::job("verification/notched-strip.toml");
  parameters.specimen.notches.clear();
  const double width = parameters.specimen.size[1], shorter = 7 * mm, longer = 9 * mm;
  const double traction = parameters.boundaries.back().value[2];
  double exact = 0;
  constexpr int n = 100;
  for (int i = 0; i < n; ++i) {
    const double a = shorter + (longer - shorter) * (i + 0.5) / n;
    exact += pi * a / std::cos(pi * a / (2 * width)) * (longer - shorter) / n;
  }
  const auto& material = parameters.materials[0];
  exact *= traction * traction * parameters.specimen.size[0] * (1 - std::pow(material.poisson_ratio, 2)) /
           material.youngs_modulus;
  double sum = 0;
  const int n_samples = test::repetitions(2, 6);
  for (int sample = 0; sample < n_samples; ++sample)
    for (const auto& [sign, end] : {std::pair{-1.0, shorter}, {1.0, longer}}) {
      plane::PreCrack crack;
      crack.line = {{{0, 30 * mm}, {end, 30 * mm}}};
      parameters.specimen.cracks = {crack};
      parameters.mesh.regions = {{{plane::unbounded, {5 * mm, 11 * mm}, {28 * mm, 32 * mm}}, 0.5 * mm}};
      sum += sign * strain_energy(parameters, static_cast<std::uint64_t>(sample)) / n_samples;
    }
  const double found = std::sqrt(sum / exact);
  std::printf("through a strip: K over Feddersen's %.3f (reference 1)\n", found);
  EXPECT_NEAR(found, 1, tolerance());
}

TEST(PreCracks, MustLeaveTheBodyInOnePiece) {
  auto parameters = test::brittle({4 * mm, 6 * mm, 12 * mm});
  parameters.boundaries = {test::boundary(plane::Face::z_min, input::BoundaryKind::fix, {true, true, true}),
                           test::boundary(plane::Face::z_max, input::BoundaryKind::displacement,
                                          {true, true, true}, {}, {0, 0, 1e-6})};
  plane::PreCrack crack;
  crack.line = {{{-1 * mm, 6.2 * mm}, {7 * mm, 6.2 * mm}}};
  auto mesh = test::make_box({.size = parameters.specimen.size, .cells = {4, 6, 12}, .disturbance = 0.2});
  parameters.specimen.cracks = {crack};
  geometry::open_pre_cracks(parameters.specimen.cracks, {{}, parameters.specimen.size}, mesh);
  const parallel::Communicator self(MPI_COMM_SELF);
  try {
    run_sample(self, parameters, parameters.output, test::whole(mesh));
    ADD_FAILURE() << "a body in two pieces has no equilibrium";
  } catch (const parallel::AgreedError& error) {
    EXPECT_NE(std::string(error.what()).find("cut the body apart"), std::string::npos) << error.what();
  }
}

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
