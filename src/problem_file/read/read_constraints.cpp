#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

/// Reads whether bounds are the URDF's limits, and their scale.
template <class Spec>
void read_limits_of_urdf(YamlMap& map, Spec& spec) {
  const auto from = map.find("from");
  if (from) {
    static constexpr Choice<bool> kSources[] = {{"urdf", true}};
    spec.from_urdf = from->choice(kSources, "source of bounds").value_or(false);
    spec.from_place = from->place();
  }
  const auto scale = map.find("scale");
  if (!scale) return;
  spec.scale = scale->number(kPositive).value_or(1);
  if (!from)
    scale->error("only limits of the URDF are scaled", "write 'from: urdf' too, or other bounds");
}

/// Reads the keys that bounds on the control and on the state share.
template <class Spec>
void read_bounds(YamlMap& map, const Name& name, Spec& spec) {
  read_limits_of_urdf(map, spec);
  if (const auto r = map.find("lower")) spec.lower = read_component_bounds(*r);
  if (const auto r = map.find("upper")) spec.upper = read_component_bounds(*r);
  if (!map.find("from") && !map.find("lower") && !map.find("upper"))
    map.reader().error(
        fmt::format("the bounds '{}' need 'lower', 'upper' or 'from: urdf'", name.value));
}

/// Reads whether and how a constraint is soft.
void read_softness(YamlMap& map, ConstraintSpec& constraint) {
  const auto weight = map.find("weight");
  const auto soft = map.find("soft");
  if (!soft) {
    if (weight)
      weight->error("only soft constraints have a weight", "write 'soft: l1' or 'soft: l2' too");
    return;
  }
  constraint.softness = soft->choice(kSoftWords, "soft version").value_or(Softness::l2);
  if (weight)
    constraint.weight = weight->number(kNotNegative).value_or(1);
  else
    soft->error("a soft constraint needs a 'weight'",
                "the cost is weight times distance (l1), or half the weight times the squared "
                "distance (l2)");
}

/// Reads bounds on the control that solvers satisfy at every iterate.
void read_hard_control_bounds(YamlMap& map, const Name& name, ProblemSpec& spec) {
  ControlBoundsSpec bounds{.name = name};
  read_bounds(map, name, bounds);
  if (const auto p = map.find("phases")) bounds.phases = read_phase_names(*p);
  CostSpec control;
  read_nodes(map, control);
  if (control.ends.value)
    map.find("nodes")->error("the controls of a phase do not last until the node at its end",
                             "leave 'nodes' out");
  spec.control_bounds.push_back(std::move(bounds));
}

void read_bounded(YamlMap& map, const Name& name, ProblemSpec& spec) {
  const auto r = map.find("bounds");
  const auto bounded = r->choice(kBoundedWords, "quantity that can have bounds");
  if (!bounded) {
    map.ignore_others();
    return;
  }
  const auto softness = map.find("soft"), weight = map.find("weight");
  const bool soft = softness || weight;
  if (*bounded == BoundedQuantity::kControl && !soft)
    return read_hard_control_bounds(map, name, spec);
  ConstraintSpec constraint;
  constraint.function.name = name;
  const char* residual = *bounded == BoundedQuantity::kControl ? "control" : "state";
  constraint.function.residual = {residual, r->place()};
  constraint.function.definition = find_residual(residual);
  constraint.bounded = {*bounded, r->place()};
  read_softness(map, constraint);
  read_bounds(map, name, constraint);
  if (const auto p = map.find("phases")) constraint.function.phases = read_phase_names(*p);
  read_nodes(map, constraint.function);
  spec.constraints.push_back(std::move(constraint));
}

/// Keys of a residual's set that exclude each other.
constexpr std::pair<std::string_view, std::string_view> kExclusive[] = {
    {"equals", "lower"},   {"equals", "upper"},   {"equals", "at_least"}, {"equals", "at_most"},
    {"equals", "cone"},    {"lower", "at_least"}, {"lower", "at_most"},   {"lower", "cone"},
    {"upper", "at_least"}, {"upper", "at_most"},  {"upper", "cone"},      {"at_least", "cone"},
    {"at_most", "cone"}};

/// The value of a key that defines a residual's set. Cone residuals accept only `cone`.
std::optional<YamlReader> find_in_set(YamlMap& map, std::string_view key,
                                      const ResidualDefinition& definition) {
  const auto r = map.find(key);
  if (r && definition.is_cone && key != "cone")
    r->error(fmt::format("the residual '{}' brings its bounds along", definition.name),
             "leave the key out");
  return r;
}

/// Reports `from` in a constraint on a residual: only bounds come from a URDF. The key is queried
/// only if present, so that messages do not list it as accepted.
void check_source(YamlMap& map) {
  if (!map.valid() || map.reader().node().find("from") == nullptr) return;
  map.find("from")->error(
      "a URDF has bounds of controls, configurations and velocities alone",
      "write 'bounds: control', 'bounds: configuration' or 'bounds: velocity' instead of "
      "'residual', or 'lower' and 'upper' instead of 'from'");
}

/// Reads numbers for the rows of the residual.
void read_interval(YamlMap& map, ConstraintSpec& constraint) {
  const ResidualDefinition& definition = *constraint.function.definition;
  if (const auto r = find_in_set(map, "equals", definition))
    constraint.equals = read_components(*r);
  if (const auto r = find_in_set(map, "lower", definition))
    constraint.lower = read_component_bounds(*r);
  if (const auto r = find_in_set(map, "upper", definition))
    constraint.upper = read_component_bounds(*r);
}

/// Reads bounds on the norm of the residual.
void read_length(YamlMap& map, ConstraintSpec& constraint) {
  const ResidualDefinition& definition = *constraint.function.definition;
  auto &shortest = constraint.at_least, &longest = constraint.at_most;
  if (const auto r = find_in_set(map, "at_least", definition)) shortest = r->number(kNotNegative);
  const auto r = find_in_set(map, "at_most", definition);
  if (!r) return;
  longest = r->number(kNotNegative);
  if (shortest && longest && *shortest > *longest)
    r->error(fmt::format("no length is at least {} and at most {}", *shortest, *longest));
}

/// True if a residual has its own cone or accepts a second-order cone.
bool has_cone(const ResidualDefinition& definition, bool second_order) {
  return definition.has(key::cone.name) || (second_order && !definition.is_cone);
}

void read_cone(YamlMap& map, ConstraintSpec& constraint) {
  const ResidualDefinition& definition = *constraint.function.definition;
  const auto cone = find_in_set(map, "cone", definition);
  if (!cone) return;
  const bool second_order = cone->choice(kConeWords, "cone").value_or(false);
  constraint.function.keys.set(key::cone, second_order);
  if (!has_cone(definition, second_order))
    cone->error(fmt::format("the residual '{}' has no such cone", definition.name),
                second_order ? "leave the key out" : "'cone: second_order' serves all others");
  if (second_order && (map.find("faces") || map.find("inner")))
    cone->error("a second-order cone has no faces and is exact");
}

bool has_bounds(const ConstraintSpec& constraint) {
  return constraint.equals || constraint.lower || constraint.upper || constraint.at_least ||
         constraint.at_most;
}

/// By default, distances of shapes are at least a margin.
void apply_margin(YamlMap& map, ConstraintSpec& constraint) {
  const KeyValues& keys = constraint.function.keys;
  if (!constraint.function.definition->needs.shapes) return;
  if (!has_bounds(constraint) && !map.find("cone"))
    constraint.lower =
        ComponentsSpec{.place = map.reader().place(), .scalar = keys.value(key::margin)};
  else if (keys.find(key::margin) != nullptr)
    map.reader().error("'margin' and other bounds on the distance exclude each other",
                       "leave one of them out: a margin is a lower bound");
}

void read_slope(YamlMap& map, ConstraintSpec& constraint) {
  const auto r = map.find("slope");
  if (!r) return;
  constraint.slope = r->number(kPositive).value_or(constraint.slope);
  if (!map.find("cone") || constraint.function.definition->of_contacts())
    r->error("'slope' needs 'cone'; cones of contacts use their friction instead");
}

/// Reads the set of the residual: equal, between, of a length, in a cone.
void read_set(YamlMap& map, ConstraintSpec& constraint) {
  for (const auto& [a, b] : kExclusive) map.exclusive({a, b});
  check_source(map);
  read_interval(map, constraint);
  read_length(map, constraint);
  read_cone(map, constraint);
  apply_margin(map, constraint);
  read_slope(map, constraint);
}

/// Sets the origin as reference of positions that are compared with numbers in the world.
void measure_from_origin(const YamlReader& reader, ConstraintSpec& constraint) {
  CostSpec& function = constraint.function;
  const ReferenceForm* form = function.definition->reference;
  const bool said = constraint.equals || constraint.lower || constraint.upper;
  if (form == nullptr || !form->is_point || !said || function.reference) return;
  function.reference = {.place = reader.place(), .values = {*form->zero(function, reader.place())}};
}

/// Equally spaced points from `begin` to `end`, both included, of equal dimension.
std::vector<std::vector<double>> points_between(const std::vector<double>& begin,
                                                const std::vector<double>& end, long long count) {
  std::vector<std::vector<double>> points;
  for (long long i = 0; i < count; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(count - 1);
    std::vector<double>& point = points.emplace_back(begin);
    for (std::size_t c = 0; c < point.size(); ++c)
      point[c] = (1 - share) * begin[c] + share * end[c];
  }
  return points;
}

/// The points of a line: {from, to, count} with both ends.
std::vector<std::vector<double>> read_line(const YamlReader& reader) {
  constexpr int kMostPoints = 10'000;
  YamlMap line(reader);
  const auto from = line.require("from"), to = line.require("to"), count = line.require("count");
  if (!from || !to || !count) return {};
  const auto begin = from->numbers();
  if (!begin) return {};
  const auto end = to->numbers(begin->size(), "as many as 'from' has");
  const auto points = count->integer(2, kMostPoints);
  if (!end || !points) return {};
  return points_between(*begin, *end, *points);
}

/// Reads points, and lines of points.
void add_centers(const YamlReader& reader, std::vector<Located<std::vector<double>>>& centers) {
  if (reader.is_map()) {
    for (std::vector<double>& point : read_line(reader))
      centers.push_back({std::move(point), reader.place()});
  } else if (auto point = reader.numbers()) {
    centers.push_back({std::move(*point), reader.place()});
  }
}

/// True if the residual of a term is the difference of a point from its reference.
bool is_point(const CostSpec& function) {
  const auto is_point_with = function.definition->is_point;
  return is_point_with != nullptr && is_point_with(function);
}

/// "control, ..., or state with 'columns'", for hints.
std::string list_of_points() {
  std::string always, with_columns;
  CostSpec whole;
  for (const ResidualDefinition* definition : residual_table()) {
    if (definition->is_point == nullptr) continue;
    if (definition->is_point(whole))
      always += std::string(definition->name) + ", ";
    else
      with_columns += fmt::format("or {} with 'columns'", definition->name);
  }
  return always + with_columns;
}

void read_centers(YamlMap& map, ConstraintSpec& constraint) {
  const auto reader = map.find("centers");
  if (!reader) return;
  map.exclusive({"centers", "reference"});
  const auto items = reader->items();
  if (!items) return;
  for (const YamlReader& item : *items) add_centers(item, constraint.centers);
  if (items->empty()) reader->error("there is no center");
  if (!is_point(constraint.function))
    reader->error("a constraint from centers needs a residual that is a point", list_of_points());
  else if (!constraint.at_least && !constraint.at_most)
    reader->error("a constraint from centers needs 'at_least' or 'at_most'");
}

/// Reports an invalid entry and ignores its other keys.
void reject(YamlMap& map, const YamlReader& where, std::string message, std::string hint) {
  where.error(std::move(message), std::move(hint));
  map.ignore_others();
}

void read_constraint(const Name& name, const YamlReader& reader,
                     const std::filesystem::path& folder, bool terminal, ProblemSpec& spec) {
  YamlMap map(reader,
              "write '{residual: expression, rows: x - 1}' for an equation, beside 'lower' or "
              "'upper' for an inequality");
  if (!map.valid()) return;
  const bool bounds = reader.node().find("bounds") != nullptr;
  if (bounds && terminal)
    return reject(map, *map.find("bounds"),
                  "bounds stand among the constraints beside 'phases'; those on the state hold at "
                  "the last node too",
                  "or bound a residual here: 'residual: state' with 'lower' and 'upper'");
  if (bounds) return read_bounded(map, name, spec);
  if (reader.node().find("residual") == nullptr)
    return reject(
        map, reader,
        fmt::format("the constraint '{}' lacks the key 'residual' or 'bounds'", name.value),
        "write 'residual: ...' with its bounds, or 'bounds: control', 'bounds: state' and so on");
  ConstraintSpec constraint;
  constraint.function.name = name;
  if (!read_residual(map, folder, {.constraint = true, .last_node = terminal}, constraint.function))
    return;
  read_set(map, constraint);
  measure_from_origin(reader, constraint);
  read_centers(map, constraint);
  read_softness(map, constraint);
  (terminal ? spec.terminal_constraints : spec.constraints).push_back(std::move(constraint));
}

}  // namespace

void read_constraints(const YamlReader& reader, const std::filesystem::path& folder, bool terminal,
                      ProblemSpec& spec) {
  if (const auto entries = reader.named_entries("write '{torque: {bounds: control, from: urdf}}'"))
    for (const auto& [name, value] : *entries) read_constraint(name, value, folder, terminal, spec);
}

}  // namespace conddp
