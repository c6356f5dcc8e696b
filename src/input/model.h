// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/index.h"
#include "common/real.h"
#include "common/vector.h"
#include "input/body_load.h"
#include "input/boundary_kind.h"
#include "input/profile.h"
#include "input/random_input.h"
#include "input/release_kind.h"
#include "input/tool.h"
#include "plane/plate.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// The model of a sample: its body, materials, conditions and duration. All values are in SI units.
namespace crackle::input {

/// Maximum number of base mother points, one per node: making such a mesh takes about 30 GB, and its numbers
/// of tetrahedra and facets stay far below 2^31.
inline constexpr double max_mother_points = 2e7;

/// How realizations are oriented in a body with symmetries.
enum class MeshSymmetry {
  random,  ///< each by a random symmetry
  none,    ///< all as the base distribution
};

/// Base mother points of the samples.
enum class Base {
  shared,  ///< one set for all samples
  own,     ///< separate for each sample, so that samples are independent
};

/// A box with a refined mesh.
struct MeshRegion {
  plane::Region box = plane::everywhere;
  double spacing = 0;  ///< maximum inside [m]
};

struct Mesh {
  double spacing = 0;        ///< far from notches and regions [m]
  double notch_spacing = 0;  ///< at the notch tips [m]
  double growth = 0;         ///< increase of spacing per unit distance from a notch tip or a region
  double perturbation = 0;   ///< amplitude of the perturbation, in local spacings
  double min_quality = 0;    ///< minimum mean-ratio quality of every tetrahedron
  MeshSymmetry symmetry = MeshSymmetry::random;
  Base base = Base::shared;
  std::optional<std::filesystem::path> points;  ///< file with base mother points, to be used instead
  std::string points_digest;  ///< of that file's contents, which are part of the input; empty without a file
  std::vector<MeshRegion> regions;

  /// The finest spacing that the input gives [m].
  double finest_spacing() const {
    double finest = notch_spacing > 0 ? std::min(spacing, notch_spacing) : spacing;
    for (const MeshRegion& region : regions) finest = std::min(finest, region.spacing);
    return finest;
  }
};

enum class Distribution { weibull, lognormal };

/// The property multiplied by a material's random field of stiffness.
enum class StiffnessVaries { stiffness, density, both };

/// Heterogeneity of stiffness or density: a random factor of mean 1 (lognormal) or scale 1 (Weibull).
struct StiffnessVariation {
  StiffnessVaries of = StiffnessVaries::stiffness;
  Distribution distribution = Distribution::lognormal;
  double modulus = 0;                   ///< of Weibull
  double coefficient_of_variation = 0;  ///< of the lognormal distribution
  double correlation_length = 0;        ///< [m]; 0: independent for each tetrahedron
  double with_strength = 0;  ///< correlation of the underlying normal field with that of [fracture.variation]
};

struct Material {
  double youngs_modulus = 0;  ///< [Pa]
  double poisson_ratio = 0;
  double density = 0;     ///< [kg/m^3]
  std::string name = {};  ///< empty if the body has one material
  std::optional<StiffnessVariation> variation = {};
  // In place of those of [fracture]; 0 if not given.
  double strength = 0;                      ///< [Pa]
  double toughness = 0;                     ///< [J/m^2]
  double fracture_toughness = 0;            ///< [Pa m^0.5]
  double impulse = 0;                       ///< [Pa^beta s]
  std::optional<double> release_time = {};  ///< [s]
  double release_speed = 0;                 ///< [m/s]
};

/// The property that a raster gives for each tetrahedron.
enum class MapOf { material, stiffness, strength, stiffness_and_strength };

/// A raster of material numbers or of factors, sampled at the centroids of the tetrahedra: the value of the
/// cell that contains it.
struct MaterialMap {
  std::string file;              ///< with "{sample}" for the number of the sample, if each has its own
  std::filesystem::path folder;  ///< to which the file is relative
  std::string dataset;           ///< in an HDF5 file
  MapOf of = MapOf::material;
  std::vector<int> axes;        ///< of the body, for each axis of the raster; constant along others
  std::vector<double> origin;   ///< middle of the first cell along each axis of the raster [m]
  std::vector<double> spacing;  ///< of the cells; negative if they are in descending order [m]
  double scale = 1;             ///< by which values are multiplied
  std::string checksum;         ///< of the contents of the files of all samples

  std::filesystem::path path(std::uint64_t sample) const;
  bool has_file_per_sample() const { return file.find("{sample}") != std::string::npos; }
};

/// Number of the material with this name, or -1.
int material_named(const std::vector<Material>& materials, const std::string& name);

/// The slowest longitudinal wave in a bar of one of the materials [m/s].
double slowest_bar_speed(const std::vector<Material>& materials);

/// True if the materials are given as [[material]], each with a name.
inline bool is_list(const std::vector<Material>& materials) {
  return !materials.front().name.empty();
}

/// The tetrahedra with a node on a boundary between two materials.
struct Interface {
  std::array<std::string, 2> between;  ///< names of the materials
  // In place of those of the tetrahedra's own material; 0 if not given.
  double strength = 0;   ///< [Pa]
  double toughness = 0;  ///< [J/m^2]
};

enum class Accumulation { cumulative, step };  ///< of damage
/// The stress that must reach the strength where there is no crack: beside the tetrahedron's own the mean
/// around one of its corners, or its own alone.
enum class Nucleation { nodal_mean, own_stress };
/// Shape of the curve of stress over opening.
enum class SofteningCurve { linear, exponential };
enum class Contact { none, frictionless };  ///< of the body's surfaces and of cracks that close again

/// [contact]
struct SurfaceContact {
  double friction = 0;     ///< Coulomb's coefficient
  double stiffness = 0.2;  ///< share of the squared largest frequency, see dynamics::ContactScale
};

/// The quantity multiplied by the material's random field. The toughness of a strength criterion is
/// proportional to the strength squared, so both share one field f: with `toughness` the strength is
/// multiplied by its square root.
enum class Varies { strength, toughness, both };

/// Heterogeneity of the material.
struct Variation {
  Varies of = Varies::strength;
  Distribution distribution = Distribution::weibull;
  double modulus = 0;                   ///< of Weibull
  double reference_volume = 0;          ///< for which the strength or toughness equals Weibull's scale [m^3]
  double coefficient_of_variation = 0;  ///< of the lognormal distribution, whose mean is the input's value
  double correlation_length = 0;        ///< [m]; 0: independent for each tetrahedron
};

/// Random pre-cracks, round ones, with their middles uniform in a region of the body.
struct Flaws {
  std::optional<int> number = {};  ///< in each sample
  double density = 0;              ///< instead: of a Poisson process [1/m^3]
  double radius = 0;               ///< of all [m]; 0: of a distribution
  RandomInput radii = {};
  std::optional<Vector> normal = {};  ///< of all, of any length; empty: isotropic
  double spread = 0;                  ///< standard deviation of their angle from this normal [rad]
  plane::Region region = plane::everywhere;
};

struct Fracture {
  double strength = 0;  ///< sigma_0 [Pa]; 0 if derived from the toughness
  double exponent = 2;  ///< beta
  double impulse = 0;   ///< K_f [Pa^beta s]; 0: see fracture::impulses
  Accumulation accumulation = Accumulation::cumulative;
  Release release = Release::element;
  SofteningCurve softening = SofteningCurve::linear;
  int teeth = 10;  ///< steps in which a tetrahedron's stiffness decreases
  /// In dynamic phases the stiffness of a breaking tetrahedron falls to nothing over this time [s], 0: at
  /// once, or over its spacing divided by this speed [m/s], 0: not given. At most one of the two is given;
  /// without either, see fracture::release_speed.
  std::optional<double> release_time = {};
  double release_speed = 0;
  Contact contact = Contact::none;
  /// Energy per crack area [J/m^2], from which the strength is derived; 0 if the strength is given. With
  /// softening, given in addition to the strength.
  double toughness = 0;
  double fracture_toughness =
      0;              ///< K_Ic from which the toughness is derived [Pa m^0.5]; 0: toughness given directly
  double length = 0;  ///< radius of the ball for averaging the stress [m]; 0: no averaging
  Nucleation nucleation = Nucleation::nodal_mean;
  std::optional<Variation> variation = {};

  /// True if tetrahedra lose their stiffness in steps that dissipate the toughness.
  bool softens() const { return traits(release).softens; }
  bool has_strength_and_toughness() const { return strength > 0 && toughness > 0; }
  /// True if the strength applies to the nucleation of cracks only, and the toughness to their growth.
  bool separates_nucleation() const { return has_strength_and_toughness() && !softens(); }
  /// True if the stress at the nucleation of cracks is a mean around nodes.
  bool nucleates_by_means() const {
    return nucleation == Nucleation::nodal_mean && strength > 0 && length == 0 && !softens();
  }
};

/// One prescribed quantity on a face or on a box region of it.
///
/// The prescribed vector at time t is value + rate t or, with a history, value times the factor interpolated
/// linearly in the history (constant before its first and after its last entry).
struct Boundary {
  std::string on = name_of(plane::Face::z_min);  ///< name of one or several faces
  plane::Region region = plane::everywhere;
  BoundaryKind kind = BoundaryKind::fix;
  std::array<bool, 3> components{};  ///< the prescribed components (fix, velocity, displacement)
  Vector value{};
  Vector rate{};
  std::vector<std::pair<double, double>> history;  ///< (time [s], factor), times ascending
  std::string name = {};  ///< conditions with the same name add up to one load of the machine; empty: none
  /// Multiplies the prescribed quantity from place to place. That of a total force only distributes it.
  std::optional<Profile> factor = {};
};

/// How a stress from the start is given.
enum class InitialStressKind {
  surface,      ///< the parabola of tempered glass
  profile,      ///< stress along an axis
  temperature,  ///< change of temperature along an axis, times an expansion
};

/// A stress that the body has without any load. Several add up.
struct InitialStress {
  int along = 0;  ///< axis along which it changes
  InitialStressKind kind = InitialStressKind::profile;
  /// The normal stresses of a surface stress or a profile; empty: the two across the axis.
  std::optional<std::array<bool, 3>> components = {};
  double surface = 0;                                  ///< [Pa]
  std::vector<std::pair<double, double>> profile;      ///< (coordinate [m], stress [Pa]), ascending
  double expansion = 0;                                ///< [1/K]
  std::vector<std::pair<double, double>> temperature;  ///< (coordinate [m], change [K]), ascending
  std::string material = {};                           ///< whose thermal expansion it is; empty: that of all
  std::vector<std::pair<double, double>> history;      ///< as of a Boundary

  /// True if it is the stress of this component, where nothing moves.
  bool has(int component) const { return components ? (*components)[index(component)] : component != along; }
};

/// Stress, or change of temperature, at a coordinate along the axis [Pa or K].
/// @param extent of the body along the axis [m]
double value_at(const InitialStress& initial, const std::pair<double, double>& extent, double coordinate);

enum class Start { quasi_static, equilibrium, rest };
enum class Integrator { bilateral4, verlet };
/// Implementation of the dynamic phases. With PETSc, samples are bitwise reproducible on the same number of
/// ranks only.
enum class Engine { fixed_point, petsc };
/// As spelled in the input.
constexpr const char* to_string(Engine engine) {
  return engine == Engine::petsc ? "petsc" : "fixed-point";
}
/// Number format of dynamic phases: fixed point in 32 or in 64 bits; double_ with Engine::petsc.
enum class Precision { mixed, double_ };

struct Time {
  Start start = Start::quasi_static;
  Engine engine = Engine::fixed_point;
  std::optional<double> step;  ///< [s]; empty: a fraction of the stable step ("auto")
  double duration = 0;         ///< of the dynamic phase [s]
  /// Largest share of mass that may be added for a longer step, see dynamics::scale_masses; 0: none.
  double mass_scaling = 0;
  Integrator integrator = Integrator::bilateral4;
  Precision precision = Precision::mixed;
  /// Time without a break after which a dynamic phase counts as arrested [s]; empty: the time of a
  /// longitudinal bar wave along the body's longest extent ("auto").
  std::optional<double> arrest;
  double after_separation =
      0;  ///< a dynamic phase ends this long after separation of the body [s]; 0: it does not
};

/// Coefficients of bulk viscosity, see dynamics::ViscousForce.
struct BulkViscosity {
  double linear = 0;
  double quadratic = 0;

  bool acts() const { return linear > 0 || quadratic > 0; }
};

struct Damping {
  double mass = 0;  ///< damping force / (mass * velocity) [1/s]
  BulkViscosity bulk = {};
};

/// A point of the body at which its state is recorded over time.
struct Probe {
  std::string name;
  Vector at{};  ///< [m]
};

struct Output {
  int frames = 11;
  /// Interval of history rows in dynamic phases [s]; empty: 1/200 of the duration ("auto").
  std::optional<double> history = {};
  std::vector<Probe> probes = {};
  double branch_length = 0;  ///< from which branches are long [m]; 0: see analysis::branch_length
};

/// The physics of a sample.
struct Model {
  std::uint64_t seed = 0;  ///< of all random numbers, with the number of the sample
  plane::Specimen specimen;
  Mesh mesh;
  std::vector<Material> materials = {{}};  ///< the first one fills the body outside the regions
  std::vector<Interface> interfaces = {};
  std::optional<MaterialMap> map = {};
  Fracture fracture;
  std::vector<Flaws> flaws = {};
  std::vector<Boundary> boundaries;
  std::vector<InitialStress> initial_stresses = {};
  std::vector<BodyLoad> loads = {};
  std::vector<Tool> tools = {};
  Time time;
  std::optional<Damping> damping = {};
  std::optional<SurfaceContact> contact = {};
  /// Number or name of the boundary condition for the load curve; unset: the driving condition.
  std::variant<std::monostate, int, std::string> governing = {};

  /// The material of a uniform body; in others the one outside the regions.
  const Material& material() const { return materials.front(); }
  /// Contact as given in either way; empty: none.
  std::optional<SurfaceContact> surface_contact() const {
    return fracture.contact == Contact::none || contact ? contact : SurfaceContact{};
  }
  /// That of surfaces, or with tools alone; empty: none.
  std::optional<SurfaceContact> any_contact() const {
    const auto of_surfaces = surface_contact();
    return of_surfaces || tools.empty() ? of_surfaces : SurfaceContact{};
  }
  /// [fracture] as it applies to a material.
  Fracture fracture_of(std::size_t material) const;

  /// Numbers of the materials of each interface.
  std::vector<std::array<int, 2>> interface_pairs() const;

  bool maps_stiffness() const {
    return map && (map->of == MapOf::stiffness || map->of == MapOf::stiffness_and_strength);
  }
  bool maps_strength() const {
    return map && (map->of == MapOf::strength || map->of == MapOf::stiffness_and_strength);
  }
  /// True if Young's modulus or Poisson's ratio may differ between tetrahedra.
  bool stiffness_varies() const {
    return materials.size() > 1 || maps_stiffness() ||
           (materials.front().variation && materials.front().variation->of != StiffnessVaries::density);
  }
  /// True if the stress of one displacement may differ between tetrahedra.
  bool stress_varies() const { return stiffness_varies() || !initial_stresses.empty(); }
  double damping_rate() const { return damping ? damping->mass : 0; }  ///< [1/s]
  BulkViscosity bulk_viscosity() const { return damping ? damping->bulk : BulkViscosity{}; }
  /// The loads that are forces. Their conditions are numbered after those of the boundaries.
  std::vector<BodyLoad> body_forces() const;
  std::vector<BodyLoad> initial_velocities() const;
};

}  // namespace crackle::input
