// SPDX-License-Identifier: GPL-3.0-or-later
// Damping and absorbing faces against exact solutions: the decay of free motion and of a vibration, and the
// reflection of plane waves by Lysmer and Kuhlemeyer's dashpots.
#include "mechanics/elasticity.h"

#include "support/box_mesh.h"
#include "support/effort.h"
#include "support/elastic_motion.h"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

namespace crackle::dynamics {
namespace CRACKLE_TEST_FILE {

using input::BoundaryKind;
using plane::Face;
using std::numbers::pi;

/// @return the largest error of a velocity component, relative to its start
double error_of_free_decay(MovingBody& motion, MotionState& state, const std::array<double, 3>& start,
                           double rate, int n_steps, double step) {
  const Splitting& map = splitting(input::Integrator::verlet);
  for (int i = 0; i < n_steps; ++i) motion.step(map.even, step, i * step);
  motion.read(state);
  double error = 0;
  for (std::size_t i = 0; i < state.velocity.owned().size(); ++i)
    error = std::max(error,
                     std::abs(state.velocity.owned()[i] / start[i % 3] - std::exp(-rate * n_steps * step)));
  return error;
}

TEST(Damping, LetsFreeMotionDecayHoweverSlow) {
  const parallel::Communicator self(MPI_COMM_SELF);
  const auto mesh = test::make_box({.size = {0.004, 0.006, 0.012}, .cells = {2, 3, 6}, .disturbance = 0.2});
  const auto subdomain = test::whole(mesh);
  fracture::BreakableBody body(subdomain, test::epoxy());
  const mechanics::Conditions loads;
  auto law = test::unbreakable(subdomain);
  const double rate = 5000, step = 2e-8;
  const MotionContext context{&self, &body, &loads, &law, rate};
  // In mixed precision the last component loses far less than a quantum per step.
  const std::array<double, 3> start{10, -3, 1e-4};
  double mass = 0;
  for (const double m : body.operators().node_mass) mass += m;
  for (const char* format : {"plain", "mixed", "double"}) {
    MotionState state{parallel::NodeField(self, subdomain.layout),
                      parallel::NodeField(self, subdomain.layout)};
    for (std::size_t i = 0; i < state.velocity.owned().size(); ++i) state.velocity.owned()[i] = start[i % 3];
    const auto motion =
        std::string(format) == "plain"
            ? make_reference_motion(context, 0, state)
            : make_fixed_point_motion(
                  context,
                  std::string(format) == "mixed" ? input::Precision::mixed : input::Precision::double_, 0,
                  1e-4, state);
    const double error = error_of_free_decay(*motion, state, start, rate, 5000, step);
    double kinetic = 0;
    for (std::size_t i = 0; i < state.velocity.owned().size(); ++i)
      kinetic += 0.5 * body.operators().node_mass[i / 3] * std::pow(state.velocity.owned()[i], 2);
    const double at_start = 0.5 * mass * (100 + 9 + 1e-8);
    const double imbalance = std::abs(at_start - kinetic - motion->dissipated_energy()) / at_start;
    std::printf("%s: after %.2f of 1/rate off the exact decay by %.1e, energy by %.1e\n", format,
                rate * 5000 * step, error, imbalance);
    // In mixed precision the slow component has a few hundred quanta.
    EXPECT_LT(error, std::string(format) == "mixed" ? 0.01 : 1e-7);
    EXPECT_LT(imbalance, std::string(format) == "mixed" ? 1e-6 : 1e-12);
  }
}

constexpr double length = 0.012;

/// A column with walls that let plane waves pass along z.
/// @param axis of the motion: 2 for P waves, 0 for S waves
input::Parameters column(int axis) {
  input::Parameters parameters;
  parameters.specimen.size = {0.001, 0.001, length};
  parameters.materials[0] = test::epoxy();
  for (const Face face : {Face::y_min, Face::y_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {false, true, false}));
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {axis == 2, false, axis == 0}));
  return parameters;
}

TEST(Damping, LetsAVibrationDecayAsTheDampedOscillatorDoes) {
  input::Parameters parameters = column(2);
  const double omega = pi / length * mechanics::dilatational_speed(parameters.material());
  const double period = 2 * pi / omega;
  parameters.damping = {.mass = 0.2 * omega};
  const double decay = 0.1 * omega, damped = std::sqrt(omega * omega - decay * decay);
  test::ElasticMotion motion(test::irregular_box(parameters.specimen.size, 0.4e-3), parameters,
                             input::Integrator::verlet);
  const double amplitude = 1e-6;
  const auto shape = [&](std::size_t n) { return std::cos(pi * motion.subdomain().nodes[n][2] / length); };
  for (std::size_t n = 0; n < motion.n_nodes(); ++n)
    motion.state().displacement.local()[3 * n + 2] = amplitude * shape(n);
  motion.start(3 * period);
  const double start = motion.energy();
  const auto n_steps = static_cast<std::int64_t>(std::ceil(period / 8 / (0.4 * motion.stable_step())));
  double error = 0, imbalance = 0;
  for (int moment = 1; moment <= 24; ++moment) {
    motion.advance(n_steps, period / 8 / static_cast<double>(n_steps));
    const double t = moment * period / 8;
    const double exact =
        std::exp(-decay * t) * (std::cos(damped * t) + decay / damped * std::sin(damped * t));
    double projection = 0, norm = 0;
    for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
      projection += motion.mass(n) * motion.displacement(n, 2) * shape(n);
      norm += motion.mass(n) * shape(n) * shape(n);
    }
    error = std::max(error, std::abs(projection / norm / amplitude - exact));
    imbalance = std::max(imbalance, std::abs(start - motion.energy() - motion.dissipated_energy()) / start);
  }
  std::printf(
      "vibration with 0.1 of critical damping: off by %.1e of the amplitude; %.3f of its energy left, "
      "balance %.1e\n",
      error, motion.energy() / start, imbalance);
  EXPECT_LT(error, 0.01);
  EXPECT_LT(imbalance, 2e-3);
  EXPECT_GT(motion.dissipated_energy(), 0.9 * start);
}

TEST(AbsorbingFace, IsLeftByPulsesThatMeetItStraightOn) {
  for (const int axis : {2, 0}) {
    input::Parameters parameters = column(axis);
    parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::absorbing));
    const double speed = axis == 2 ? mechanics::dilatational_speed(parameters.material())
                                   : mechanics::shear_speed(parameters.material());
    test::ElasticMotion motion(test::irregular_box(parameters.specimen.size, 0.25e-3), parameters,
                               input::Integrator::verlet);
    const double width = 0.6e-3, middle = 0.6 * length;
    for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
      const double s = (motion.subdomain().nodes[n][2] - middle) / width;
      const std::size_t i = 3 * n + static_cast<std::size_t>(axis);
      motion.state().displacement.local()[i] = 1e-6 * std::exp(-s * s / 2);
      motion.state().velocity.local()[i] = speed * 1e-6 * s / width * std::exp(-s * s / 2);
    }
    const double duration = 0.75 * length / speed;
    motion.start(duration);
    const double start = motion.energy();
    const auto n_steps = static_cast<std::int64_t>(std::ceil(duration / (0.5 * motion.stable_step())));
    motion.advance(n_steps, duration / static_cast<double>(n_steps));
    const double left = motion.energy() / start;
    const double imbalance = std::abs(1 - left - motion.dissipated_energy() / start);
    std::printf("%s pulse on an absorbing face: %.2e of its energy comes back (target 0.01), balance %.1e\n",
                axis == 2 ? "P" : "S", left, imbalance);
    EXPECT_LT(left, 0.01);
    EXPECT_LT(imbalance, 2e-3);
  }
}

using Complex = std::complex<double>;

/// The exact share of a plane wave's energy reflected by dashpots of impedances rho c_p and rho c_s.
/// @param angle between the wave's direction and the face's normal
double reflected_share(const input::Material& material, bool is_shear, double angle) {
  const mechanics::IsotropicElasticity elasticity(material);
  const double cp = mechanics::dilatational_speed(material), cs = mechanics::shear_speed(material);
  const double slowness = std::sin(angle) / (is_shear ? cs : cp);  // along the face
  const auto cosine = [&](double c) { return std::sqrt(Complex(1 - slowness * slowness * c * c)); };
  // Traction minus that of the dashpots on the face z = 0, over i omega, for a wave of unit amplitude.
  const auto residual = [&](double c, Complex y, Complex z, Complex uy, Complex uz) {
    const Complex normal =
        ((elasticity.lambda + 2 * elasticity.mu) * z * uz + elasticity.lambda * y * uy) / c;
    const Complex shear = elasticity.mu * (y * uz + z * uy) / c;
    return Eigen::Vector2cd(normal - material.density * cp * uz, shear - material.density * cs * uy);
  };
  const auto pressure_wave = [&](double sign) {
    return residual(cp, slowness * cp, sign * cosine(cp), slowness * cp, sign * cosine(cp));
  };
  const auto shear_wave = [&](double sign) {
    return residual(cs, slowness * cs, sign * cosine(cs), -sign * cosine(cs), slowness * cs);
  };
  Eigen::Matrix2cd reflected;
  reflected.col(0) = pressure_wave(-1);
  reflected.col(1) = shear_wave(-1);
  const Eigen::Vector2cd amplitude = reflected.inverse() * (is_shear ? shear_wave(1) : pressure_wave(1));
  const double flux_p = cp * cosine(cp).real(), flux_s = cs * cosine(cs).real();
  return (std::norm(amplitude[0]) * flux_p + std::norm(amplitude[1]) * flux_s) / (is_shear ? flux_s : flux_p);
}

/// The mean over the directions contained in a beam with a Gaussian profile.
/// @param spread standard deviation of its energy over the angle
double reflected_share_of_beam(const input::Material& material, bool is_shear, double angle, double spread) {
  double sum = 0, weight = 0;
  for (int i = -200; i <= 200; ++i) {
    const double offset = 0.02 * i;
    const double one = angle + offset * spread;
    if (std::abs(one) > 0.49 * pi) continue;
    sum += std::exp(-offset * offset / 2) * reflected_share(material, is_shear, one);
    weight += std::exp(-offset * offset / 2);
  }
  return sum / weight;
}

constexpr double wavelength = 6e-3, half_length = 3e-3, half_width = 6e-3;

/// The share of its energy that a wave beam retains after hitting an absorbing face.
/// @param angle between its direction and the face's normal
double reflected_share_on_mesh(const input::Material& material, bool is_shear, double angle, double spacing) {
  const std::array<double, 2> along{std::sin(angle), std::cos(angle)}, across{along[1], -along[0]};
  // 99.9 % of its energy lie within 3.25 standard deviations of its centre along the face, and normal to it.
  constexpr double deviations = 3.25 / std::numbers::sqrt2;
  const double reach_y = deviations * std::hypot(half_length * along[0], half_width * along[1]);
  const double reach_z = deviations * std::hypot(half_length * along[1], half_width * along[0]);
  // From the start of its centre to the face, and from there to the end.
  const double way = reach_z / along[1];
  const auto cells = [&](double extent) { return static_cast<int>(std::ceil(extent / spacing)); };
  const int n_y = cells(2 * (way * along[0] + reach_y)), n_z = cells(2 * reach_z);
  const double width = n_y * spacing, height = n_z * spacing;
  input::Parameters parameters;
  parameters.specimen.size = {spacing, width, height};
  parameters.materials[0] = material;
  // Plane strain.
  for (const Face face : {Face::x_min, Face::x_max})
    parameters.boundaries.push_back(test::boundary(face, BoundaryKind::fix, {true, false, false}));
  parameters.boundaries.push_back(test::boundary(Face::z_max, BoundaryKind::absorbing));
  test::ElasticMotion motion(
      test::make_box({.size = parameters.specimen.size, .cells = {1, n_y, n_z}, .disturbance = 0.1}),
      parameters, input::Integrator::verlet);
  const double speed = is_shear ? mechanics::shear_speed(material) : mechanics::dilatational_speed(material);
  const double wave_number = 2 * pi / wavelength;
  for (std::size_t n = 0; n < motion.n_nodes(); ++n) {
    const auto& node = motion.subdomain().nodes[n];
    const double y = node[1] - width / 2, z = node[2] - height;
    const double s = along[0] * y + along[1] * z + way, w = across[0] * y + across[1] * z;
    // From a wave potential, so that it is of a single type; it travels at its wave speed.
    const Complex q(-s / (half_length * half_length), wave_number);
    const double r = -w / (half_width * half_width);
    const Complex potential =
        1e-9 *
        std::exp(Complex(-s * s / (2 * half_length * half_length) - w * w / (2 * half_width * half_width),
                         wave_number * s));
    const Complex first_s = q * potential, first_w = r * potential;
    const Complex second_s = (q * q - 1 / (half_length * half_length)) * potential, mixed = q * r * potential;
    for (std::size_t i = 0; i < 2; ++i) {
      const auto component = [&](const Complex& s_part, const Complex& w_part) {
        return is_shear ? (across[i] * s_part - along[i] * w_part).real()
                        : (along[i] * s_part + across[i] * w_part).real();
      };
      motion.state().displacement.local()[3 * n + 1 + i] = component(first_s, first_w);
      motion.state().velocity.local()[3 * n + 1 + i] = -speed * component(second_s, mixed);
    }
  }
  const double duration = 2 * way / speed;
  motion.start(duration);
  const double start = motion.energy();
  const auto n_steps = static_cast<std::int64_t>(std::ceil(duration / (0.9 * motion.stable_step())));
  motion.advance(n_steps, duration / static_cast<double>(n_steps));
  return motion.energy() / start;
}

class ReflectionOverTheAngle : public testing::TestWithParam<bool> {};

TEST_P(ReflectionOverTheAngle, ConvergesToThatOfTheDashpots) {
  const bool is_shear = GetParam();
  const input::Material material = test::epoxy();
  constexpr double coarse = 0.45e-3, fine = 0.3e-3;
  const std::vector<double> all{0, 30, 60}, usual{0, 45};
  for (const double degrees : test::is_full() ? all : usual) {
    const double angle = degrees * pi / 180;
    const double exact = reflected_share_of_beam(material, is_shear, angle,
                                                 wavelength / (2 * pi * half_width * std::numbers::sqrt2));
    const double share = reflected_share_on_mesh(material, is_shear, angle, fine);
    const double on_coarse_mesh = reflected_share_on_mesh(material, is_shear, angle, coarse);
    std::printf(
        "%s wave at %2.0f degrees: %.4f of its energy reflected with 13 points in the wavelength, %.4f "
        "with 20, theory %.4f (of a plane wave %.4f)\n",
        is_shear ? "S" : "P", degrees, on_coarse_mesh, share, exact,
        reflected_share(material, is_shear, angle));
    EXPECT_LT(std::abs(share - exact), 0.8 * std::abs(on_coarse_mesh - exact));
    EXPECT_NEAR(share, exact, 0.01 + 0.3 * exact);
    if (degrees == 0) {
      EXPECT_LT(share, 0.01);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(AbsorbingFace, ReflectionOverTheAngle, testing::Values(false, true),
                         [](const auto& info) { return info.param ? "S" : "P"; });

}  // namespace CRACKLE_TEST_FILE
}  // namespace crackle::dynamics
