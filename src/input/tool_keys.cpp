// SPDX-License-Identifier: GPL-3.0-or-later
// [[tool]]: rigid bodies that touch the specimen.
#include "consistency.h"
#include "kinds.h"

#include <array>
#include <cmath>
#include <set>

namespace crackle::input {

namespace {

constexpr Range any_motion{-1e6, 1e6};
constexpr Range any_force{-1e15, 1e15};
constexpr const char* distinct_freedoms =
    "an array of distinct words from \"x\", \"y\", \"z\", \"turn x\", \"turn y\", \"turn z\"";
const std::string size_form =
    "three lengths along x, y and z of a box, or the length of a cylinder with ends, such as [\"10 mm\"]";

Tool& tool(Parameters& parameters, std::size_t i) {
  return parameters.tools.at(i);
}

template <class T>
Access<T> in_tool(T Tool::*member) {
  return [=](Parameters& parameters, std::size_t i) -> T& { return tool(parameters, i).*member; };
}

std::string tool_key(std::size_t i) {
  return fmt::format("tool[{}]", i);
}

bool has(ToolShape shape, const char* key) {
  const std::string name(key);
  switch (shape) {
    case ToolShape::plane:
      return name == "axis";
    case ToolShape::cylinder:
      return name == "axis" || name == "radius" || name == "size" || name == "rounding";
    case ToolShape::sphere:
      return name == "radius";
    case ToolShape::box:
      return name == "size" || name == "rounding";
  }
  return false;
}

Key motion_key(BoundaryKind kind, std::optional<Vector> Tool::*member, const char* unset, std::string help) {
  const Dimension& dimension = value_dimension(kind);
  const Range range = kind == BoundaryKind::force ? any_force : any_motion;
  return {name_of(kind),
          name_without_article(dimension),
          optional(unset),
          components_form(dimension),
          std::move(help),
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read_components(source, dimension, range))
              tool(parameters, i).*member = value->value;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const auto& value = tool(parameters, i).*member;
            if (!value) return {};
            return show_components(*value, dimension);
          }};
}

/// What a tool's rate and history change with time.
BoundaryKind prescribed(const Tool& tool) {
  if (tool.displacement) return BoundaryKind::displacement;
  return tool.force ? BoundaryKind::force : BoundaryKind::velocity;
}

Key tool_rate_key() {
  return {"rate",
          "as prescribed, per time",
          optional("constant in time"),
          "three components, such as [\"0 mm/s\", \"0 mm/s\", \"-1 mm/s\"]",
          "increase with time",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            const Tool& one = tool(parameters, i);
            if (!one.velocity && one.gives_velocity()) {
              source.report("nothing is prescribed that could change with time; leave it out");
              return;
            }
            const Dimension& dimension = rate_dimension(prescribed(one));
            if (const auto rate = read_components(source, dimension, {-1e18, 1e18}))
              tool(parameters, i).rate = rate->value;
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            const Tool& one = tool(parameters, i);
            if (one.rate == Vector{}) return {};
            return show_components(one.rate, rate_dimension(prescribed(one)));
          }};
}

Key free_key() {
  return {"free",
          "words",
          optional("x, y and z"),
          distinct_freedoms,
          "axes along which a tool with a mass can move; \"turn x\": it turns about x, with the inertia of a "
          "homogeneous body, in dynamic phases only",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            const auto ways = read_words(source, tool_freedoms, distinct_freedoms);
            if (source.value.kind == ValueKind::array && source.value.elements.empty())
              source.report("leaves the tool no way to move; give {}", distinct_freedoms);
            tool(parameters, i).free = ways;
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (!tool(parameters, i).free) return {};
            return show_words(*tool(parameters, i).free, tool_freedoms);
          }};
}

Key tool_angular_velocity_key() {
  const Dimension& dimension = angular_velocity_dimension;
  return {"angular_velocity",
          name_without_article(dimension),
          optional("none"),
          components_form(dimension),
          "angular velocity of a mass at the start, about axes about which it turns",
          [=](const Source& source, Parameters& parameters, std::size_t i) {
            const auto elements = read_elements(source, 3, components_form(dimension));
            Vector spin{};
            for (std::size_t axis = 0; elements && axis < 3; ++axis)
              spin[axis] = read_angular_velocity((*elements)[axis]).value_or(0);
            tool(parameters, i).angular_velocity = spin;
          },
          [=](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (!tool(parameters, i).angular_velocity) return {};
            return show_components(*tool(parameters, i).angular_velocity, dimension);
          }};
}

Key friction_key() {
  return {"friction",
          "number",
          optional("0"),
          accepted_number({0, 10}),
          "coefficient of Coulomb friction",
          [](const Source& source, Parameters& parameters, std::size_t i) {
            if (const auto value = read_number(source, {0, 10})) tool(parameters, i).friction = *value;
          },
          [](Parameters& parameters, std::size_t i) -> std::optional<std::string> {
            if (!tool(parameters, i).friction) return {};
            return format_number(*tool(parameters, i).friction);
          }};
}

void check_shape(const Tool& tool, const std::string& table, Findings& findings) {
  const auto must_give = [&](const char* key, const char* example) {
    if (!findings.given(table + "." + key))
      findings.report(table + "." + key, "the key is missing, but a {} needs it; give {}",
                      tool_shape_names[index(tool.shape)], example);
  };
  for (const char* const key : {"axis", "radius", "size", "rounding"})
    if (!has(tool.shape, key) && findings.given(table + "." + key))
      findings.report(table + "." + key, "a {} has none; leave it out", tool_shape_names[index(tool.shape)]);
  if (has(tool.shape, "axis")) must_give("axis", "a direction such as [0, 0, 1]");
  if (has(tool.shape, "radius")) must_give("radius", "a length such as \"5 mm\"");
  if (tool.shape == ToolShape::box)
    must_give("size", "three lengths such as [\"20 mm\", \"10 mm\", \"5 mm\"]");
  if (tool.turns() && tool.shape == ToolShape::plane)
    findings.report(table + ".free", "a plane cannot turn; leave out \"turn ...\"");
  if (tool.turns() && tool.shape == ToolShape::cylinder && !findings.given(table + ".size"))
    findings.report(
        table + ".free",
        "a cylinder without size has no ends and cannot turn; give its size, or leave out \"turn ...\"");
  if (findings.faulty(table + ".size") || findings.faulty(table + ".radius")) return;
  const std::size_t n_sizes = tool.shape == ToolShape::box ? 3 : 1;
  if (!tool.size.empty() && tool.size.size() != n_sizes)
    findings.report(table + ".size", "has {} lengths; a {} needs {}", tool.size.size(),
                    tool_shape_names[index(tool.shape)], n_sizes == 3 ? "three" : "one");
  else if (tool.rounding > 0 && tool.shape == ToolShape::cylinder && tool.size.empty())
    findings.report(table + ".rounding",
                    "a cylinder without size has no ends; give its size, or leave it out");
  else if (tool.rounding > 0 && has(tool.shape, "rounding")) {
    double most = 0.5 * std::ranges::min(tool.size);
    if (tool.radius > 0) most = std::min(most, tool.radius);
    if (tool.rounding > most)
      findings.report(table + ".rounding", "{} does not fit the tool; give at most {}", show(tool.rounding),
                      show(most));
  }
}

void check_motion(const Tool& tool, const std::string& table, const Time& time, Findings& findings) {
  const auto path = [&](const char* key) { return table + "." + key; };
  const bool may_rest = findings.faulty("time.start");
  const bool starts_at_rest = time.start == Start::rest;
  if (tool.has_mass()) {
    if (tool.displacement)
      findings.report(path("displacement"),
                      "a tool with a mass moves by the forces on it; leave one of the two out");
    for (const char* const key : {"velocity", "angular_velocity"})
      if (findings.given(path(key)) && !starts_at_rest && !may_rest)
        findings.report(path(key),
                        "the {} of a tool with a mass is that at the start, which requires time.start = "
                        "\"rest\"; leave it out, or leave out its mass",
                        key);
    if (tool.angular_velocity && !findings.faulty(path("free")) && !findings.faulty(path("angular_velocity")))
      for (std::size_t axis = 0; axis < 3; ++axis)
        if ((*tool.angular_velocity)[axis] != 0 && !tool.turning()[axis])
          findings.report(path("angular_velocity"), "the tool cannot turn about {}; {}\"turn {}\"{}",
                          axis_names[axis], tool.free ? "add " : "give free = [\"x\", \"y\", \"z\", ",
                          axis_names[axis], tool.free ? " to free" : "]");
  } else {
    int n = 0;
    for (const auto* value : {&tool.displacement, &tool.velocity, &tool.force}) n += value->has_value();
    if (n > 1)
      findings.report(table, "prescribes more than one of displacement, velocity and force; give one");
    if (tool.force && starts_at_rest && !may_rest)
      findings.report(path("force"), "moves a tool only if that has a mass; give its mass, such as \"5 g\"");
    for (const char* const key : {"free", "angular_velocity"})
      if (findings.given(path(key)))
        findings.report(path(key), "belongs to a tool with a mass; leave it out");
  }
  for (const char* const key : {"rate", "history"}) {
    if (!findings.given(path(key))) continue;
    const bool is_of_velocity = tool.velocity && tool.gives_velocity();
    if (tool.gives_velocity() && (!tool.velocity || tool.has_mass()))
      findings.report(path(key), "nothing is prescribed that could change with time; leave it out");
    else if (is_of_velocity && !starts_at_rest && !may_rest)
      findings.report(
          path(key), "a velocity that changes with time requires time.start = \"rest\"; give a displacement");
  }
  if (findings.given(path("rate")) && findings.given(path("history")))
    findings.report(path("history"), "is given together with rate; give only one of the two");
  if (!tool.free || findings.faulty(path("free"))) return;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool is_pushed = tool.force && ((*tool.force)[axis] != 0 || tool.rate[axis] != 0);
    const bool is_thrown = tool.velocity && tool.has_mass() && (*tool.velocity)[axis] != 0;
    if ((is_pushed || is_thrown) && !(*tool.free)[axis])
      findings.report(path("free"), "the {} has a component along {}, along which the tool cannot move",
                      is_pushed ? "force" : "velocity", axis_names[axis]);
  }
}

}  // namespace

std::string name_of(const Tool& tool, std::size_t number) {
  return tool.name.empty() ? fmt::format("tool-{}", number) : tool.name;
}

Table tool_table() {
  std::vector<std::pair<std::string, ToolShape>> shapes;
  for (std::size_t i = 0; i < tool_shape_names.size(); ++i)
    shapes.emplace_back(tool_shape_names[i], static_cast<ToolShape>(i));
  return {
      "tool",
      Occurrence::many,
      "rigid bodies that touch the specimen: projectiles, rollers, platens; without mass, displacement, "
      "velocity or force they stay where they are",
      {name_key(in_tool(&Tool::name), optional("tool-i"), "ball",
                "as which its position, velocity and reaction are recorded"),
       choice_key<ToolShape>("shape", in_tool(&Tool::shape), shapes, required(),
                             "a plane has the body on the side of its normal")
           .that_affects(Affects::points),
       lengths_key<Vector>("at", in_tool(&Tool::at),
                           "three lengths, x, y and z, such as [\"5 mm\", \"12 mm\", \"40 mm\"]", coordinate,
                           required(), "a point of a plane, the middle of another shape")
           .that_affects(Affects::points),
       shown_if(direction_key("axis", in_tool(&Tool::axis), optional("required for a plane or cylinder"),
                              "normal of a plane, towards the body; axis of a cylinder"),
                [](const Parameters& parameters, std::size_t i) {
                  return has(parameters.tools.at(i).shape, "axis");
                })
           .that_affects(Affects::points),
       optional_quantity_key("radius", in_tool(&Tool::radius), with_example(length_dimension, "5 mm"),
                             positive_length, optional("required for a cylinder or sphere"),
                             "of a cylinder or sphere")
           .also_called({"R", "r"})
           .that_affects(Affects::points),
       lengths_key<std::vector<double>>("size", in_tool(&Tool::size), size_form, positive_length,
                                        optional("required for a box; a cylinder without it has no ends"),
                                        "edges of a box along x, y and z, or length of a cylinder"),
       optional_quantity_key("rounding", in_tool(&Tool::rounding), with_example(length_dimension, "1 mm"),
                             positive_length, optional("sharp edges"),
                             "radius of the edges of a box or of a cylinder's ends"),
       optional_quantity_key("mass", in_tool(&Tool::mass), mass_dimension, {0, 1e12, true},
                             optional("moves as prescribed"), "moves by the forces on it")
           .also_called({"m"}),
       motion_key(BoundaryKind::displacement, &Tool::displacement, "none", "prescribed").also_called({"u"}),
       motion_key(BoundaryKind::velocity, &Tool::velocity, "none", "prescribed; of a mass that at the start")
           .also_called({"v", "speed"}),
       tool_angular_velocity_key(),
       motion_key(BoundaryKind::force, &Tool::force, "none",
                  "on the tool; without a mass it keeps its place in dynamic phases")
           .also_called({"F", "load"}),
       tool_rate_key(), history_key(in_tool(&Tool::history), "factors, linear between these times"),
       free_key(), friction_key().also_called({"mu"})},
      [](const Parameters& parameters) { return parameters.tools.size(); },
      [](Parameters& parameters) { parameters.tools.emplace_back(); }};
}

void check_tools(const Parameters& parameters, Findings& findings) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < parameters.tools.size(); ++i) {
    const Tool& tool = parameters.tools[i];
    const std::string table = tool_key(i);
    if (findings.faulty(table)) continue;
    if (!names.insert(name_of(tool, i)).second)
      findings.report(table + ".name", "\"{}\" is the name of another tool; give each its own",
                      name_of(tool, i));
    // Their loads would be added as those of one machine.
    if (const std::string name = name_of(tool, i);
        std::ranges::find(parameters.boundaries, name, &Boundary::name) != parameters.boundaries.end())
      findings.report(table, "\"{}\" is the name of a [[boundary]], too; give another", name);
    check_shape(tool, table, findings);
    check_motion(tool, table, parameters.time, findings);
  }
}

}  // namespace crackle::input
