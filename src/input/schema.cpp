// SPDX-License-Identifier: GPL-3.0-or-later
#include "schema.h"

#include "common/checksum.h"

#include <cstdint>
#include <fstream>
#include <system_error>

namespace crackle::input {

namespace {

/// Accessor of a member of one of the groups of the parameters, such as `parameters.mesh.spacing`.
template <class Owner, class Group, class T>
Access<T> in(Group Owner::*group, T Group::*member) {
  return [=](Parameters& parameters, std::size_t) -> T& { return parameters.*group.*member; };
}

template <class T>
Access<T> stop(T EnsembleStop::*member) {
  return [=](Parameters& parameters, std::size_t) -> T& { return parameters.ensemble.stop.value().*member; };
}

Key points_key() {
  return {"points",
          "file name",
          optional("generated"),
          "name of a readable file, relative to the input file",
          "base mother points; base is then \"shared\"",
          [](const Source& source, Parameters& parameters, std::size_t) {
            const auto name = read_text(source, "the name of a file with points");
            if (!name) return;
            const GivenFiles& given = source.context.files;
            const std::filesystem::path file =
                given.points.empty() ? source.context.folder / *name : given.points;
            parameters.mesh.points = file;
            const Value* const root = source.context.root;
            if (root == nullptr || !find_path(*root, "mesh.base")) parameters.mesh.base = Base::shared;
            parameters.mesh.points_digest = given.points_digest;
            if (!given.points_digest.empty()) return;
            std::error_code error;
            if (!std::filesystem::is_regular_file(file, error)) {
              source.report(
                  "there is no file \"{}\"; give the name of a file with points, "
                  "relative to the input file",
                  shortened(file.string(), 200));
              return;
            }
            const auto digest = file_digest(file);
            if (!digest)
              source.report("the file \"{}\" cannot be read; give the name of a readable file",
                            shortened(file.string(), 200));
            parameters.mesh.points_digest = digest.value_or("");
          },
          [](Parameters& parameters, std::size_t) -> std::optional<std::string> {
            if (!parameters.mesh.points) return {};
            return parameters.mesh.points->string();
          }};
}

Key sections_key(const std::string& name, std::vector<double> Sections::*positions) {
  return lengths_key<std::vector<double>>(
      name, in(&Parameters::sections, positions),
      "an array of lengths, such as [\"7 mm\", \"12.25 mm\"], ascending, where a crack from a notch can "
      "arrive",
      coordinate, optional("y, z or a line is required"),
      "y = const for cracks from notches in y-faces, z = const in z-faces");
}

Table line_table() {
  const auto end_key = [](const char* name, std::array<double, 2> SectionLine::*end, const char* example,
                          const char* help) {
    const Access<std::array<double, 2>> access = [=](Parameters & parameters, std::size_t i) -> auto& {
      return parameters.sections.lines.at(i).*end;
    };
    return lengths_key(name, access, fmt::format("two lengths, y and z, such as {}", example), coordinate,
                       required(), help);
  };
  return {"sections.line",
          Occurrence::many,
          "a straight line across the cracks; positions are distances from its start",
          {end_key("from", &SectionLine::from, R"(["10 mm", "60 mm"])", "where the line starts"),
           end_key("to", &SectionLine::to, R"(["14 mm", "80 mm"])", "where it ends")},
          [](const Parameters& parameters) { return parameters.sections.lines.size(); },
          [](Parameters& parameters) { parameters.sections.lines.emplace_back(); }};
}

Table plane_table() {
  return {"sections.plane",
          Occurrence::many,
          "a plane in space, in which the traces of cracks are measured",
          {lengths_key<Vector>(
               "point", [](Parameters & parameters, std::size_t i) -> auto& {
                 return parameters.sections.planes.at(i).point;
               },
               "three lengths, x, y and z, such as [\"0 mm\", \"5 mm\", \"8 mm\"]", coordinate, required(),
               "in the plane"),
           direction_key(
               "normal", [](Parameters & parameters, std::size_t i) -> auto& {
                 return parameters.sections.planes.at(i).normal;
               },
               required(), "across the plane")},
          [](const Parameters& parameters) { return parameters.sections.planes.size(); },
          [](Parameters& parameters) { parameters.sections.planes.emplace_back(); }};
}

std::vector<std::pair<std::string, Release>> release_choices() {
  std::vector<std::pair<std::string, Release>> choices;
  for (const ReleaseTraits& one : release_kinds) choices.emplace_back(one.name, one.kind);
  return choices;
}

/// The key, hidden without softening, to which it belongs.
Key of_softening(Key key) {
  return shown_if(std::move(key),
                  [](const Parameters& parameters, std::size_t) { return parameters.fracture.softens(); });
}

/// The key, hidden where stresses are not those of the nucleation of cracks.
Key of_nucleation(Key key) {
  return shown_if(std::move(key), [](const Parameters& parameters, std::size_t) {
    Fracture fracture = parameters.fracture_of(0);
    fracture.nucleation = Nucleation::nodal_mean;
    return fracture.nucleates_by_means();
  });
}

/// The key, hidden without random inputs, to which it belongs.
Key with_random_inputs(Key key) {
  return shown_if(std::move(key),
                  [](const Parameters& parameters, std::size_t) { return !parameters.random.empty(); });
}

Table ensemble_table() {
  return {
      "ensemble",
      Occurrence::once,
      "the samples",
      {integer_key("samples", in(&Parameters::ensemble, &Ensemble::samples), 1, 1'000'000, required(),
                   "number of samples")
           .also_called({"n_samples", "N", "realizations"})
           .that_affects(Affects::layers),
       integer_key<std::uint64_t>(
           "seed", [](Parameters & parameters, std::size_t) -> auto& { return parameters.seed; }, 0,
           std::numeric_limits<std::int64_t>::max(), by_default("0"),
           "sample i, with its random fields and inputs, depends on (seed, i) only")
           .that_affects(Affects::points),
       integer_key("ranks_per_sample", in(&Parameters::ensemble, &Ensemble::ranks_per_sample), 1, 100'000,
                   by_default("1"), "ranks that share one sample")
           .that_affects(Affects::run),
       choice_key<MeshMakers>(
           "meshes", in(&Parameters::ensemble, &Ensemble::meshes),
           {{"auto", MeshMakers::automatic}, {"master", MeshMakers::master}, {"groups", MeshMakers::groups}},
           by_default("\"auto\""),
           "who makes them; \"auto\": the master in advance, or a group if none is ready")
           .that_affects(Affects::run),
       with_random_inputs(
           choice_key<SamplingPlan>("plan", in(&Parameters::ensemble, &Ensemble::plan),
                                    {{plan_names[0], SamplingPlan::independent},
                                     {plan_names[1], SamplingPlan::latin_hypercube},
                                     {plan_names[2], SamplingPlan::sobol}},
                                    by_default("\"independent\""),
                                    "of [[random]]; with \"latin-hypercube\" no samples can be added later"))
           .that_affects(Affects::draws),
       with_random_inputs(integer_key("replicates", in(&Parameters::ensemble, &Ensemble::replicates), 1,
                                      1'000'000, by_default("1"),
                                      "consecutive samples (meshes) per draw of [[random]]"))
           .that_affects(Affects::draws)}};
}

Table stop_table() {
  return {
      "ensemble.stop",
      Occurrence::optional,
      "stop when the mean path of the leading cracks is precise enough",
      {quantity_key("half_width", stop(&EnsembleStop::half_width), with_example(length_dimension, "0.25 mm"),
                    positive_length, required(), "of the mean path's confidence interval, at every section"),
       number_key("confidence", stop(&EnsembleStop::confidence), {0, 1, true, true}, by_default("0.95"),
                  "level of that interval"),
       integer_key("min_samples", stop(&EnsembleStop::min_samples), 2, 1'000'000, by_default("30"),
                   "samples before the first test")},
      [](const Parameters& parameters) { return parameters.ensemble.stop ? std::size_t{1} : 0; },
      [](Parameters& parameters) { parameters.ensemble.stop.emplace(); }};
}

Table mesh_table() {
  return {"mesh",
          Occurrence::once,
          "the mother points and their tessellation",
          {quantity_key("spacing", in(&Parameters::mesh, &Mesh::spacing), length_dimension, positive_length,
                        required(), "point spacing away from notches and regions")
               .also_called({"h", "dx", "element_size", "mesh_size"}),
           quantity_key("notch_spacing", in(&Parameters::mesh, &Mesh::notch_spacing),
                        with_example(length_dimension, "0.3 mm"), positive_length, optional("as spacing"),
                        "at the notch tips"),
           number_key("growth", in(&Parameters::mesh, &Mesh::growth), {0, 1}, by_default("0.03"),
                      "increase of the spacing per distance from a notch tip or region"),
           number_key("perturbation", in(&Parameters::mesh, &Mesh::perturbation), {0, 0.4}, by_default("0.2"),
                      "amplitude of the disturbance, in local spacings")
               .that_affects(Affects::mesh),
           number_key("min_quality", in(&Parameters::mesh, &Mesh::min_quality), {0, 0.5}, by_default("0.2"),
                      "mean-ratio quality that every tetrahedron keeps"),
           choice_key<MeshSymmetry>(
               "symmetry", in(&Parameters::mesh, &Mesh::symmetry),
               {{"random", MeshSymmetry::random}, {"none", MeshSymmetry::none}}, by_default("\"random\""),
               "\"random\": each sample takes one of the body's reflections and half-turns")
               .that_affects(Affects::mesh),
           choice_key<Base>("base", in(&Parameters::mesh, &Mesh::base),
                            {{"own", Base::own}, {"shared", Base::shared}}, by_default("\"own\""),
                            "base mother points: a set for each sample, or one for all"),
           // Its name has no effect; the contents are compared on their own.
           points_key().that_affects(Affects::run)}};
}

Table region_table() {
  const auto range = [](std::size_t axis, const char* name) {
    return range_key(
        name,
        [=](Parameters & parameters, std::size_t i) -> auto& {
          return parameters.mesh.regions.at(i).box[axis];
        },
        {"0 mm", "2 mm"}, "whole body", "extent of the box");
  };
  return {"mesh.region",
          Occurrence::many,
          "a box in which the mesh is fine; at least one of x, y, z",
          {range(0, "x"), range(1, "y"), range(2, "z"),
           quantity_key(
               "spacing",
               [](Parameters& parameters, std::size_t i) -> double& {
                 return parameters.mesh.regions.at(i).spacing;
               },
               with_example(length_dimension, "0.3 mm"), positive_length, required(), "largest in the box")},
          [](const Parameters& parameters) { return parameters.mesh.regions.size(); },
          [](Parameters& parameters) { parameters.mesh.regions.emplace_back(); }};
}

Table fracture_table() {
  return {
      "fracture",
      Occurrence::once,
      "when tetrahedra break, and how they lose their stiffness",
      {optional_quantity_key(
           "strength", in(&Parameters::fracture, &Fracture::strength), stress_dimension, positive_stress,
           optional("from toughness"),
           "sigma_0, the largest principal stress without damage; with toughness, away from cracks")
           .also_called({"sigma_0", "sigma_c", "sigma_t", "f_t", "tensile_strength"}),
       toughness_key(in(&Parameters::fracture, &Fracture::toughness), optional("from strength"),
                     "energy per area of a slow crack; strengths follow by the local spacing (Poisson's "
                     "ratio from 0 to 0.45), only at cracks if strength is given")
           .also_called({"G_c", "G_Ic", "G_f", "G", "fracture_energy", "energy_release_rate"}),
       optional_quantity_key("fracture_toughness", in(&Parameters::fracture, &Fracture::fracture_toughness),
                             stress_intensity_dimension, {0, 1e12, true}, optional("from toughness"),
                             "K_Ic: toughness is K_Ic^2 (1 - nu^2) / E")
           .also_called({"K_Ic", "K_c", "K_1c", "KI", "K"}),
       optional_quantity_key("length", in(&Parameters::fracture, &Fracture::length),
                             with_example(length_dimension, "0.6 mm"), positive_length,
                             optional("own stress"),
                             "radius over which the stress is averaged, at least 1.5 spacings")
           .also_called({"l", "averaging_length"}),
       number_key("exponent", in(&Parameters::fracture, &Fracture::exponent), {0, 20, true}, by_default("2"),
                  "beta")
           .also_called({"beta"}),
       hidden_at_zero(
           impulse_key(in(&Parameters::fracture, &Fracture::impulse),
                       optional("small enough not to slow cracks down"),
                       "K_f; by default (0.002 sigma_0)^exponent h / v, with the local spacing h and v "
                       "the release_speed, or else 0.7 c_R"),
           in(&Parameters::fracture, &Fracture::impulse))
           .also_called({"K_f"}),
       choice_key<Accumulation>("accumulation", in(&Parameters::fracture, &Fracture::accumulation),
                                {{"cumulative", Accumulation::cumulative}, {"step", Accumulation::step}},
                                by_default("\"cumulative\""),
                                "of damage over all steps, or in one only: a strength of sigma_0 + (impulse "
                                "/ step)^(1 / exponent), without a toughness"),
       choice_key<Release>("release", in(&Parameters::fracture, &Fracture::release), release_choices(),
                           by_default("\"element\""),
                           "a tetrahedron loses all its stiffness, that across one cut, or all in steps "
                           "(requires strength and toughness)"),
       release_time_key(in(&Parameters::fracture, &Fracture::release_time), optional("by release_speed"),
                        "time in which a breaking tetrahedron loses its stiffness in dynamic phases, on any "
                        "spacing; \"0 s\": at once")
           .also_called({"tau"}),
       release_speed_key(
           in(&Parameters::fracture, &Fracture::release_speed),
           optional("0.7 c_R of its material with a toughness; at once with a strength alone, or "
                    "softening"),
           "that time is the local spacing over this speed, so that crack speeds do not depend "
           "on the spacing")
           .also_called({"v_r"}),
       of_nucleation(choice_key<Nucleation>(
           "nucleation", in(&Parameters::fracture, &Fracture::nucleation),
           {{"nodal-mean", Nucleation::nodal_mean}, {"own-stress", Nucleation::own_stress}},
           by_default("\"nodal-mean\""),
           "away from cracks a tetrahedron breaks when its own stress and the mean around a corner have "
           "reached the strength, or by its own alone")),
       of_softening(choice_key<SofteningCurve>(
           "softening", in(&Parameters::fracture, &Fracture::softening),
           {{"linear", SofteningCurve::linear}, {"exponential", SofteningCurve::exponential}},
           by_default("\"linear\""), "how the stress falls with the opening")),
       of_softening(integer_key("teeth", in(&Parameters::fracture, &Fracture::teeth), 2, 100,
                                by_default("10"), "steps of softening")),
       choice_key<Contact>("contact", in(&Parameters::fracture, &Fracture::contact),
                           {{"none", Contact::none}, {"frictionless", Contact::frictionless}},
                           by_default("\"none\""),
                           "of cracks that close and, in dynamic phases only, of surfaces that meet; with "
                           "friction see [contact]")}};
}

Table variation_table() {
  const auto variation = [](auto Variation::*member) {
    return [=](Parameters & parameters, std::size_t) -> auto& {
      return parameters.fracture.variation.value().*member;
    };
  };
  return {
      "fracture.variation",
      Occurrence::optional,
      "random strength or toughness in space",
      {choice_key<Varies>(
           "of", variation(&Variation::of),
           {{"strength", Varies::strength}, {"toughness", Varies::toughness}, {"both", Varies::both}},
           by_default("\"strength\""), "multiplied by the factor; toughness goes with strength squared"),
       choice_key<Distribution>("distribution", variation(&Variation::distribution),
                                {{"weibull", Distribution::weibull}, {"lognormal", Distribution::lognormal}},
                                required(), "of the factor: Weibull with scale 1, lognormal with mean 1"),
       optional_number_key("modulus", variation(&Variation::modulus), {1, 1000}, "required for \"weibull\"",
                           "Weibull modulus (shape)")
           .also_called({"m", "weibull_modulus", "shape"}),
       optional_quantity_key("reference_volume", variation(&Variation::reference_volume), volume_dimension,
                             {1e-27, 1e9}, optional("required for \"weibull\" without correlation_length"),
                             "63 % of such volumes have factors below 1")
           .also_called({"V_0"}),
       optional_number_key("coefficient_of_variation", variation(&Variation::coefficient_of_variation),
                           {0, 2, true}, "required for \"lognormal\"", "of the lognormal distribution")
           .also_called({"cov", "cv"}),
       optional_quantity_key("correlation_length", variation(&Variation::correlation_length),
                             with_example(length_dimension, "2 mm"), positive_length,
                             optional("each tetrahedron has the factor of its weakest point"),
                             "of the underlying Gaussian field: distance at which its correlation is 0.48")
           .also_called({"xi"})},
      [](const Parameters& parameters) { return parameters.fracture.variation ? std::size_t{1} : 0; },
      [](Parameters& parameters) { parameters.fracture.variation.emplace(); }};
}

Key engine_key() {
  const auto word = [](Engine engine) { return std::pair{std::string(to_string(engine)), engine}; };
  return choice_key<Engine>("engine", in(&Parameters::time, &Time::engine),
                            {word(Engine::fixed_point), word(Engine::petsc)}, by_default("\"fixed-point\""),
                            "arithmetic of the dynamic phase: integer sums, or PETSc in double precision, "
                            "slower and with bits that depend on the number of ranks");
}

Table time_table() {
  return {
      "time",
      Occurrence::once,
      "loading and the dynamic phase",
      {choice_key<Start>("start", in(&Parameters::time, &Time::start),
                         {{"quasi-static", Start::quasi_static},
                          {"equilibrium", Start::equilibrium},
                          {"rest", Start::rest}},
                         by_default("\"quasi-static\""),
                         "equilibria up to instability; or dynamics from the equilibrium at t = 0, even "
                         "above the strength; or from rest"),
       automatic_time_key("step", in(&Parameters::time, &Time::step), "5 ns",
                          "\"auto\" is a fraction of the stable step")
           .also_called({"dt", "delta_t", "time_step"}),
       optional_quantity_key("mass_scaling", in(&Parameters::time, &Time::mass_scaling), share_dimension,
                             {0, 0.1, true}, optional("none"),
                             "mass added to the few nodes that decide the stable step, at most this share of "
                             "the whole and of what is meshed finely, for a longer step; waves are slower by "
                             "half the share added"),
       quantity_key("duration", in(&Parameters::time, &Time::duration),
                    with_example(time_dimension, "100 us"), positive_time, required(), "of a dynamic phase")
           .also_called({"T", "t_end", "end_time", "final_time", "total_time"}),
       choice_key<Integrator>("integrator", in(&Parameters::time, &Time::integrator),
                              {{"bilateral4", Integrator::bilateral4}, {"verlet", Integrator::verlet}},
                              by_default("\"bilateral4\""),
                              "order 4 with 3.5 force evaluations per step, or order 2 with one"),
       engine_key(),
       choice_key<Precision>(
           "precision", in(&Parameters::time, &Time::precision),
           {{"mixed", Precision::mixed}, {"double", Precision::double_}}, by_default("\"mixed\""),
           "fixed-point numbers of 32 or 64 bits; samples that overflow 32 are repeated in 64"),
       automatic_time_key(
           "arrest", in(&Parameters::time, &Time::arrest), "20 us",
           "time without a break that counts as arrest, with start = \"equilibrium\" once something has "
           "broken; \"auto\": a bar wave's way along the body"),
       optional_quantity_key("after_separation", in(&Parameters::time, &Time::after_separation),
                             with_example(time_dimension, "20 us"), positive_time, optional("off"),
                             "time from separation to the end of a dynamic phase")}};
}

Key bulk_viscosity_key() {
  const std::string form = "two numbers from 0 to 10, the linear and the quadratic one, such as [0.06, 1.2]";
  return {
      "bulk",
      "number",
      optional("none"),
      form,
      "coefficients of bulk viscosity, which takes the overshoot off sudden loads and impacts",
      [=](const Source& source, Parameters& parameters, std::size_t) {
        const auto both = read_elements(source, 2, form);
        if (!both) return;
        const auto linear = read_number((*both)[0], {0, 10}), quadratic = read_number((*both)[1], {0, 10});
        if (linear && quadratic) parameters.damping->bulk = {*linear, *quadratic};
      },
      [](Parameters& parameters, std::size_t) -> std::optional<std::string> {
        const BulkViscosity& bulk = parameters.damping->bulk;
        if (!bulk.acts()) return {};
        return bracketed({format_number(bulk.linear), format_number(bulk.quadratic)});
      }};
}

Table damping_table() {
  return {
      "damping",
      Occurrence::optional,
      "damping in the dynamic phase",
      {optional_quantity_key(
           "mass", [](Parameters& parameters, std::size_t) -> double& { return parameters.damping->mass; },
           rate_of_decay_dimension, {0, 1e12}, optional("none; mass or bulk is required"),
           "damping force per mass and velocity; requires time.integrator = \"verlet\"")
           .also_called({"alpha", "rayleigh_alpha"}),
       bulk_viscosity_key()},
      [](const Parameters& parameters) { return parameters.damping ? std::size_t{1} : 0; },
      [](Parameters& parameters) { parameters.damping.emplace(); }};
}

Table sections_table() {
  return {"sections",
          Occurrence::once,
          "where crack paths are measured",
          {sections_key("y", &Sections::y), sections_key("z", &Sections::z)}};
}

}  // namespace

const std::vector<Table>& schema() {
  static const std::vector<Table> tables = [] {
    std::vector<Table> all;
    // The effect of those of their keys that state none.
    const auto add = [&](Affects affects, std::vector<Table> some) {
      for (Table& table : some) {
        for (Key& key : table.keys)
          if (key.affects == Affects::sample) key.affects = affects;
        all.push_back(std::move(table));
      }
    };
    add(Affects::sample, {ensemble_table()});
    add(Affects::run, {stop_table()});
    add(Affects::body, specimen_tables());
    add(Affects::points, {mesh_table(), region_table()});
    add(Affects::sample, material_tables());
    add(Affects::sample, {fracture_table(), variation_table()});
    add(Affects::conditions, {boundary_table(), load_table(), tool_table(), initial_stress_table()});
    add(Affects::sample, {time_table(), damping_table(), contact_table()});
    add(Affects::reading, {sections_table(), line_table(), plane_table()});
    add(Affects::records, {output_table(), probe_table()});
    add(Affects::draws, {random_table()});
    add(Affects::materials, {flaws_table()});
    add(Affects::draws, {correlation_table()});
    add(Affects::sample, {sweep_table()});
    return all;
  }();
  return tables;
}

}  // namespace crackle::input
