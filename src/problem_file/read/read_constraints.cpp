#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

/// The keys that bounds on the control and on the state share.
template <class Spec>
void read_bounds(YamlMap& map, const Name& name, Spec& spec) {
  if (const auto r = map.find("from")) {
    static constexpr Choice<bool> kSources[] = {{"urdf", true}};
    spec.from_urdf = r->choice(kSources, "source of bounds").value_or(false);
    spec.from_place = r->place();
  }
  if (const auto r = map.find("scale")) {
    spec.scale = r->number(kPositive).value_or(1);
    if (!spec.from_urdf && !map.find("from"))
      r->error("only limits of the URDF are scaled", "write 'from: urdf' too, or other bounds");
  }
  if (const auto r = map.find("lower")) spec.lower = read_components(*r);
  if (const auto r = map.find("upper")) spec.upper = read_components(*r);
  if (!map.find("from") && !map.find("lower") && !map.find("upper"))
    map.reader().error(
        fmt::format("the bounds '{}' need 'lower', 'upper' or 'from: urdf'", name.value));
}

/// Whether and how a constraint is soft.
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
                "what a unit of distance costs (l1), or half of it a unit squared (l2)");
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
  if (*bounded == BoundedQuantity::kControl && !soft) {
    ControlBoundsSpec bounds{.name = name};
    read_bounds(map, name, bounds);
    if (const auto p = map.find("phases")) bounds.phases = p->name_or_names();
    spec.control_bounds.push_back(std::move(bounds));
    return;
  }
  ConstraintSpec constraint;
  constraint.function.name = name;
  const char* residual = *bounded == BoundedQuantity::kControl ? "control" : "state";
  constraint.function.residual = {residual, r->place()};
  constraint.function.definition = find_residual(residual);
  constraint.bounded = {*bounded, r->place()};
  read_softness(map, constraint);
  read_bounds(map, name, constraint);
  if (const auto p = map.find("phases")) constraint.function.phases = p->name_or_names();
  spec.constraints.push_back(std::move(constraint));
}

/// Ways to say what a residual has to be that exclude each other.
constexpr std::pair<std::string_view, std::string_view> kExclusive[] = {
    {"equals", "lower"},   {"equals", "upper"},   {"equals", "at_least"}, {"equals", "at_most"},
    {"equals", "cone"},    {"lower", "at_least"}, {"lower", "at_most"},   {"lower", "cone"},
    {"upper", "at_least"}, {"upper", "at_most"},  {"upper", "cone"},      {"at_least", "cone"},
    {"at_most", "cone"}};

/// What the residual has to be: equal, between, of a length, in a cone.
void read_set(YamlMap& map, ConstraintSpec& constraint) {
  const ResidualDefinition& definition = *constraint.function.definition;
  for (const auto& [a, b] : kExclusive) map.exclusive({a, b});
  const auto given = [&](std::string_view key) {
    const auto r = map.find(key);
    if (r && definition.is_cone && key != "cone")
      r->error(fmt::format("the residual '{}' brings its bounds along", definition.name),
               "leave the key out");
    return r;
  };
  // Asked for only where it stands, so that it is not listed among the accepted keys.
  if (map.valid() && map.reader().node().find("from") != nullptr)
    map.find("from")->error(
        "a URDF has bounds of controls, configurations and velocities alone",
        "write 'bounds: control', 'bounds: configuration' or 'bounds: velocity' instead of "
        "'residual', or 'lower' and 'upper' instead of 'from'");
  if (const auto r = given("equals")) constraint.equals = read_components(*r);
  if (const auto r = given("lower")) constraint.lower = read_components(*r);
  if (const auto r = given("upper")) constraint.upper = read_components(*r);
  if (const auto r = given("at_least")) constraint.at_least = r->number(kNotNegative);
  if (const auto r = given("at_most")) {
    constraint.at_most = r->number(kNotNegative);
    if (constraint.at_least && constraint.at_most && *constraint.at_least > *constraint.at_most)
      r->error(fmt::format("no length is at least {} and at most {}", *constraint.at_least,
                           *constraint.at_most));
  }
  const auto cone = given("cone");
  if (cone) {
    const bool second_order = cone->choice(kConeWords, "cone").value_or(false);
    constraint.function.keys.set(key::cone, second_order);
    if (!definition.has(key::cone.name) && (!second_order || definition.is_cone))
      cone->error(fmt::format("the residual '{}' has no such cone", definition.name),
                  second_order ? "leave the key out" : "'cone: second_order' serves all others");
    if (second_order && (map.find("faces") || map.find("inner")))
      cone->error("a second-order cone has no faces and is exact");
  }
  if (definition.needs.shapes) {
    const bool said = constraint.equals || constraint.lower || constraint.upper ||
                      constraint.at_least || constraint.at_most || cone;
    if (!said)
      constraint.lower = ComponentsSpec{.place = map.reader().place(),
                                        .scalar = constraint.function.keys.value(key::margin)};
    else if (constraint.function.keys.find(key::margin) != nullptr)
      map.reader().error("'margin' and what the distance has to be exclude each other",
                         "leave one of them out: a margin is a lower bound");
  }
  if (const auto r = map.find("slope")) {
    constraint.slope = r->number(kPositive).value_or(constraint.slope);
    if (!cone || definition.of_contacts())
      r->error("a slope belongs to cones that are not of contacts, which have their friction");
  }
}

/// Positions that lie between or equal numbers of the world are measured from its origin.
void measure_from_origin(const YamlReader& reader, ConstraintSpec& constraint) {
  CostSpec& function = constraint.function;
  const ReferenceForm* form = function.definition->reference;
  const bool said = constraint.equals || constraint.lower || constraint.upper;
  if (form == nullptr || !form->is_point || !said || function.reference) return;
  function.reference = {.place = reader.place(), .values = {*form->zero(function, reader.place())}};
}

/// Points, and lines of points: {from, to, count} with both ends.
void add_centers(const YamlReader& reader, std::vector<Located<std::vector<double>>>& centers) {
  constexpr int kMostPoints = 10'000;
  if (!reader.is_map()) {
    if (auto point = reader.numbers()) centers.push_back({std::move(*point), reader.place()});
    return;
  }
  YamlMap line(reader);
  const auto from = line.require("from"), to = line.require("to"), count = line.require("count");
  if (!from || !to || !count) return;
  const auto begin = from->numbers();
  if (!begin) return;
  const auto end = to->numbers(begin->size(), "as many as 'from' has");
  const auto points = count->integer(2, kMostPoints);
  if (!end || !points) return;
  for (long long i = 0; i < *points; ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(*points - 1);
    std::vector<double> point(begin->size());
    for (std::size_t c = 0; c < point.size(); ++c)
      point[c] = (1 - share) * (*begin)[c] + share * (*end)[c];
    centers.push_back({std::move(point), reader.place()});
  }
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
  const auto is_point = constraint.function.definition->is_point;
  if (is_point == nullptr || !is_point(constraint.function))
    reader->error("a constraint from centers needs a residual that is a point", list_of_points());
  else if (!constraint.at_least && !constraint.at_most)
    reader->error("a constraint from centers needs 'at_least' or 'at_most'");
}

void read_constraint(const Name& name, const YamlReader& reader,
                     const std::filesystem::path& folder, bool terminal, ProblemSpec& spec) {
  YamlMap map(reader);
  if (!map.valid()) return;
  const bool bounds = reader.node().find("bounds") != nullptr;
  if (bounds && terminal) {
    map.find("bounds")->error(
        "bounds stand among the constraints beside 'phases'; those on the state hold at "
        "the last node too",
        "or bound a residual here: 'residual: state' with 'lower' and 'upper'");
    map.ignore_others();
    return;
  }
  if (bounds) return read_bounded(map, name, spec);
  if (reader.node().find("residual") == nullptr) {
    reader.error(
        fmt::format("the constraint '{}' lacks the key 'residual' or 'bounds'", name.value),
        "write 'residual: ...' with what it has to be, or 'bounds: control', 'bounds: "
        "state' and so on");
    map.ignore_others();
    return;
  }
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
