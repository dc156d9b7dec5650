#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

constexpr std::string_view kNodesSay =
    "Of a constraint on the state: begins: it holds where the knots of its phases begin; ends: at "
    "the nodes at which its phases end, too";

void check_softness(YamlMap& map) {
  const auto soft = map.find("soft"), weight = map.find("weight");
  if (weight && !soft)
    weight->error("only soft constraints have a weight", "write 'soft: l1' or 'soft: l2' too");
  if (soft && !weight)
    soft->error("a soft constraint needs a 'weight'",
                "the cost is weight times distance (l1), or half the weight times the squared "
                "distance (l2)");
}

/// Whether and how a constraint is soft.
void describe_softness(Keys& keys, ConstraintSpec& constraint) {
  keys({"soft",
        "May be violated at a cost, with 'weight': l1: weight times the distance, which is exact "
        "while multipliers stay below the weight; l2: half the weight times the squared distance"},
       constraint.softness, WordForm(kSoftWords, "soft version"));
  keys({.name = "weight",
        .says = "Of a soft constraint: what a unit of its distance costs (l1), or half of it a "
                "unit squared (l2); a rate on running knots as all costs are",
        .fallback = "none",
        .omitted = constraint.softness == Softness::hard},
       constraint.weight, NumberForm{kNotNegative});
  if (YamlMap* map = keys.reading()) check_softness(*map);
}

void check_bounds(YamlMap& map, const ConstraintSpec& constraint) {
  const auto from = map.find("from"), scale = map.find("scale"), nodes = map.find("nodes");
  if (scale && !from)
    scale->error("only limits of the URDF are scaled", "write 'from: urdf' too, or other bounds");
  if (!from && !map.find("lower") && !map.find("upper"))
    map.reader().error(fmt::format("the bounds '{}' need 'lower', 'upper' or 'from: urdf'",
                                   constraint.function.name.value));
  if (nodes && constraint.bounds_controls() && constraint.function.ends.value)
    nodes->error("the controls of a phase do not last until the node at its end",
                 "leave 'nodes' out");
}

/// Bounds on the control or on coordinates of the state.
void describe_bounds(Keys& keys, ConstraintSpec& constraint) {
  static constexpr Choice<bool> kSources[] = {{"urdf", true}};
  keys.about({.definition = "constraint",
              .title = "Constraint",
              .says = "Bounds on a quantity",
              .examples = R"([{"bounds": "control", "from": "urdf"},
                              {"bounds": "velocity", "from": "urdf", "scale": 0.5},
                              {"bounds": "control", "lower": -3, "upper": [3]},
                              {"bounds": "velocity", "lower": -0.6, "upper": 0.6}])",
              .rules = R"("dependencies": {"soft": ["weight"], "weight": ["soft"],
                                           "scale": ["from"]},
                          "anyOf": [{"required": ["from"]}, {"required": ["lower"]},
                                    {"required": ["upper"]}])"});
  CostSpec& function = constraint.function;
  keys({.name = "bounds",
        .says = "The quantity that has bounds: the control, coordinates of the state, or of its "
                "positions or velocities",
        .required = true},
       constraint.bounded, WordForm(kBoundedWords, "quantity that can have bounds"));
  YamlMap* map = keys.reading();
  if (!constraint.bounded) return map->ignore_others();
  keys({"from", "Take the robot's limits: efforts and thrusters, positions, velocities"},
       PlacedWord(kSources, "source of bounds", constraint.from_urdf));
  keys({.name = "scale",
        .says = "Factor on the limits of the URDF, without unit; ranges of positions are widened "
                "about their middle",
        .omitted = !constraint.from_urdf},
       constraint.scale, NumberForm{kPositive});
  keys({"lower", "Lower bounds, in the quantity's units; null: none"}, constraint.lower,
       BoundsForm{});
  keys({"upper", "Upper bounds, in the quantity's units; null: none"}, constraint.upper,
       BoundsForm{});
  describe_softness(keys, constraint);
  describe_phases(keys,
                  "Phases in which it holds, names may have a *; all by default, and of bounds on "
                  "the state the last node too",
                  function.phases);
  keys({.name = "nodes", .says = kNodesSay, .omitted = constraint.bounds_controls()}, function.ends,
       WordForm(kNodesWords, "kind of nodes"));
  if (map == nullptr) return;
  const char* residual =
      constraint.bounded->value == BoundedQuantity::kControl ? "control" : "state";
  function.residual = {residual, constraint.bounded->place};
  function.definition = find_residual(residual);
  check_bounds(*map, constraint);
}

/// Reports keys of a residual's set that exclude each other, or that a cone residual does not have.
void check_keys_of_set(YamlMap& map, const ResidualDefinition& definition) {
  constexpr std::pair<std::string_view, std::string_view> kExclusive[] = {
      {"equals", "lower"},   {"equals", "upper"},   {"equals", "at_least"}, {"equals", "at_most"},
      {"equals", "cone"},    {"lower", "at_least"}, {"lower", "at_most"},   {"lower", "cone"},
      {"upper", "at_least"}, {"upper", "at_most"},  {"upper", "cone"},      {"at_least", "cone"},
      {"at_most", "cone"}};
  for (const auto& [a, b] : kExclusive) map.exclusive({a, b});
  for (const std::string_view key : {"equals", "lower", "upper", "at_least", "at_most"})
    if (const auto r = map.find(key); r && definition.is_cone)
      r->error(fmt::format("the residual '{}' brings its bounds along", definition.name),
               "leave the key out");
  // Queried only if present, so that messages do not list it as accepted.
  if (map.reader().has("from"))
    map.find("from")->error(
        "a URDF has bounds of controls, configurations and velocities alone",
        "write 'bounds: control', 'bounds: configuration' or 'bounds: velocity' instead of "
        "'residual', or 'lower' and 'upper' instead of 'from'");
}

void check_cone(YamlMap& map, const ConstraintSpec& constraint) {
  const ResidualDefinition& definition = *constraint.function.definition;
  const auto cone = map.find("cone"), slope = map.find("slope");
  const bool second_order = constraint.function.keys.value(key::cone);
  const bool has_cone = definition.has(key::cone.name) || (second_order && !definition.is_cone);
  if (cone && !has_cone)
    cone->error(fmt::format("the residual '{}' has no such cone", definition.name),
                second_order ? "leave the key out" : "'cone: second_order' serves all others");
  if (cone && second_order && (map.find("faces") || map.find("inner")))
    cone->error("a second-order cone has no faces and is exact");
  if (slope && (!cone || definition.of_contacts()))
    slope->error("'slope' needs 'cone'; cones of contacts use their friction instead");
}

/// By default, distances of shapes are at least a margin.
void apply_margin(YamlMap& map, ConstraintSpec& constraint) {
  KeyValues& keys = constraint.function.keys;
  if (!constraint.function.definition->needs.shapes) return;
  const bool bounded = constraint.equals || constraint.lower || constraint.upper ||
                       constraint.at_least || constraint.at_most;
  if (!bounded && !map.find("cone")) {
    const double margin = keys.value(key::margin);
    keys.set(key::margin, margin);
    constraint.lower = ComponentsSpec{.place = map.reader().place(), .scalar = margin};
  } else if (keys.find(key::margin) != nullptr) {
    map.reader().error("'margin' and other bounds on the distance exclude each other",
                       "leave one of them out: a margin is a lower bound");
  }
}

/// Sets the origin as reference of positions that are compared with numbers in the world.
void measure_from_origin(const YamlReader& reader, ConstraintSpec& constraint) {
  CostSpec& function = constraint.function;
  const ReferenceForm* form = function.definition->reference;
  const bool said = constraint.equals || constraint.lower || constraint.upper;
  if (form == nullptr || !form->is_point || !said || function.reference) return;
  function.reference = {.place = reader.place(), .values = {*form->zero(function, reader.place())}};
}

/// Equally spaced points with both ends.
struct LineOfPoints {
  std::vector<double> from, to;
  int count = 0;

  std::vector<double> point(int i) const {
    const double share = static_cast<double>(i) / (count - 1);
    std::vector<double> point = from;
    for (std::size_t c = 0; c < point.size(); ++c) point[c] = (1 - share) * from[c] + share * to[c];
    return point;
  }
};

}  // namespace

static void describe(Keys& keys, LineOfPoints& line) {
  keys.about({.definition = "line_of_centers",
              .title = "Points at equal distances on a line",
              .examples = R"([{"from": [0, 0], "to": [0, 5], "count": 30}])"});
  keys({.name = "from", .says = "The first point, in the residual's unit", .required = true},
       line.from, NumbersForm{});
  keys({.name = "to", .says = "The last point, in the residual's unit", .required = true}, line.to,
       NumbersForm{});
  keys({.name = "count", .says = "Of points, with both ends", .required = true}, line.count,
       IntegerForm{2, 10'000});
  if (const auto to = keys.found("to"); to && !line.from.empty())
    to->numbers(line.from.size(), "as many as 'from' has");
}

namespace {

/// Points, and lines of points.
struct CentersForm {
  using Centers = std::vector<Located<std::vector<double>>>;
  bool read(const YamlReader& reader, Centers& centers) const {
    const auto items = reader.items();
    if (!items) return false;
    if (items->empty()) reader.error("there is no center");
    for (const YamlReader& item : *items) add(item, centers);
    return true;
  }
  std::optional<OrderedJson> expand(const Centers& centers) const {
    OrderedJson json = OrderedJson::array();
    for (const Located<std::vector<double>>& center : centers) json.push_back(center.value);
    return json.empty() ? std::nullopt : std::optional(std::move(json));
  }
  OrderedJson schema(const Centers& /*names the type*/, SchemaDefinitions& definitions) const {
    return defined(definitions, "centers", [&] {
      OrderedJson point = NumbersForm().schema();
      point["minItems"] = 1;
      return OrderedJson{
          {"type", "array"},
          {"minItems", 1},
          {"description",
           "Points from each of which the residual keeps the lengths 'at_least' and 'at_most', "
           "instead of one reference; of frame_position, com_position, joint_position, control, "
           "and state with columns"},
          {"items", {{"anyOf", {std::move(point), map_schema<LineOfPoints>(definitions)}}}},
          {"examples",
           OrderedJson::parse(R"([[[1, 2], {"from": [0, 0], "to": [0, 5], "count": 30}]])")}};
    });
  }

 private:
  static void add(const YamlReader& reader, Centers& centers) {
    if (!reader.is_map()) {
      if (auto point = reader.numbers()) centers.push_back({std::move(*point), reader.place()});
      return;
    }
    const int errors = reader.diagnostics().error_count();
    LineOfPoints line;
    read_map(reader, line);
    if (reader.diagnostics().error_count() > errors) return;
    for (int i = 0; i < line.count; ++i) centers.push_back({line.point(i), reader.place()});
  }
};

/// "control, ..., or state with 'columns'", for hints.
std::string list_of_points() {
  std::string always, with_columns;
  for (const ResidualDefinition* definition : residual_table()) {
    if (definition->is_point == nullptr) continue;
    if (definition->is_point(CostSpec()))
      always += std::string(definition->name) + ", ";
    else
      with_columns += fmt::format("or {} with 'columns'", definition->name);
  }
  return always + with_columns;
}

void check_centers(YamlMap& map, const ConstraintSpec& constraint) {
  const auto centers = map.find("centers");
  if (!centers) return;
  map.exclusive({"centers", "reference"});
  const auto is_point = constraint.function.definition->is_point;
  if (is_point == nullptr || !is_point(constraint.function))
    centers->error("a constraint from centers needs a residual that is a point", list_of_points());
  else if (!constraint.at_least && !constraint.at_most)
    centers->error("a constraint from centers needs 'at_least' or 'at_most'");
}

/// Checks and completes the set of the residual: equal, between, of a length, in a cone.
void settle_set(YamlMap& map, ConstraintSpec& constraint) {
  check_keys_of_set(map, *constraint.function.definition);
  if (constraint.at_least && constraint.at_most && *constraint.at_least > *constraint.at_most)
    map.find("at_most")->error(fmt::format("no length is at least {} and at most {}",
                                           *constraint.at_least, *constraint.at_most));
  check_cone(map, constraint);
  apply_margin(map, constraint);
  measure_from_origin(map.reader(), constraint);
  check_centers(map, constraint);
}

/// The cone of a constraint, which costs have as a key of their residual.
void describe_cone(Keys& keys, ConstraintSpec& constraint) {
  KeyValues& own = constraint.function.keys;
  const ResidualDefinition* definition = constraint.function.definition;
  const bool is_written = definition != nullptr && definition->has(key::cone.name);
  bool second_order = own.value(key::cone);
  keys({.name = "cone",
        .says = "second_order: all rows but the last are no longer than the last times the slope, "
                "or, of contacts, the force lies in the exact friction cone; pyramid (the default) "
                "is of friction_cone",
        .fallback = "none",
        .omitted = !second_order || is_written},
       second_order, WordForm(kConeWords, "cone"));
  if (second_order) own.set(key::cone, true);
  keys({.name = "slope",
        .says = "Of a cone that is not of contacts, without unit; 1 by default",
        .fallback = "none",
        .omitted = !second_order || (definition != nullptr && definition->of_contacts())},
       constraint.slope, NumberForm{kPositive});
}

/// A residual in a set.
void describe_set(Keys& keys, ConstraintSpec& constraint) {
  CostSpec& function = constraint.function;
  const bool last_node = function.where.last_node;
  if (last_node)
    keys.about({.definition = "terminal_constraint",
                .title = "Constraint on the last node",
                .says = "A residual that lies in a set at the last node",
                .examples = R"([{"residual": "state", "reference": {"values": {"x": 1}},
                                 "equals": 0}])",
                .rules = R"("dependencies": {"soft": ["weight"], "weight": ["soft"]})"});
  else
    keys.about({.definition = "residual_constraint",
                .title = "Constraint on a residual",
                .says = "A residual that lies in a set at running knots",
                .examples = R"([{"residual": "state", "columns": ["x", "y"],
                                 "reference": [0.75, 0.75], "at_least": 0.425},
                                {"residual": "friction_cone", "contacts": "all",
                                 "cone": "second_order"}])",
                .rules = R"("dependencies": {"soft": ["weight"], "weight": ["soft"]})"});
  if (!describe_function(keys,
                         "What is to lie in a set; without equals, lower, upper, at_least, at_most "
                         "and cone it is to be zero, and cones of contacts bring their bounds "
                         "along",
                         function))
    return;
  keys({.name = "reference",
        .says = "What the residual is measured from",
        .omitted = !constraint.centers.empty()},
       function, OriginForm{});
  keys({"centers"}, constraint.centers, CentersForm{});
  keys({"at_least", "Smallest length of the residual, in its unit"}, constraint.at_least,
       NumberForm{kNotNegative});
  keys({"at_most", "Largest length of the residual, in its unit"}, constraint.at_most,
       NumberForm{kNotNegative});
  keys({.name = "lower",
        .says = "Lower bounds, in the residual's units; null: none",
        .omitted = function.keys.find(key::margin) != nullptr},
       constraint.lower, BoundsForm{});
  keys({"upper", "Upper bounds, in the residual's units; null: none"}, constraint.upper,
       BoundsForm{});
  describe_cone(keys, constraint);
  keys({"equals",
        "What it has to be, in the residual's units; components that are not named are free"},
       constraint.equals, ComponentsForm{});
  describe_softness(keys, constraint);
  if (YamlMap* map = keys.reading()) settle_set(*map, constraint);
  if (last_node) return;
  describe_phases(keys, "Phases in which it holds, names may have a *; all by default",
                  function.phases);
  describe_knots(
      keys,
      "Knots at which it holds: numbers from 0 over all phases, or a phase, its first knot, "
      "and 'phase + 3'; all by default",
      function);
  keys({.name = "nodes", .says = kNodesSay, .omitted = function.knots.has_value()}, function.ends,
       WordForm(kNodesWords, "kind of nodes"));
  if (YamlMap* map = keys.reading()) map->exclusive({"knots", "nodes"});
}

}  // namespace

static void describe(Keys& keys, ConstraintSpec& constraint) {
  YamlMap* map = keys.reading();
  if (map != nullptr ? map->reader().has("bounds") : constraint.bounded.has_value())
    describe_bounds(keys, constraint);
  else
    describe_set(keys, constraint);
}

namespace {

/// False with an error for an entry that is no constraint here.
bool check_kind(const Name& name, const YamlReader& reader, bool last_node) {
  if (!reader.is_map()) return true;
  const YamlNode* bounds = reader.node().find("bounds");
  if (bounds != nullptr && last_node)
    reader.at(*bounds, reader.place().path + ".bounds")
        .error(
            "bounds stand among the constraints beside 'phases'; those on the state hold at the "
            "last node too",
            "or bound a residual here: 'residual: state' with 'lower' and 'upper'");
  else if (bounds == nullptr && !reader.has("residual"))
    reader.error(
        fmt::format("the constraint '{}' lacks the key 'residual' or 'bounds'", name.value),
        "write 'residual: ...' with its bounds, or 'bounds: control', 'bounds: state' and "
        "so on");
  else
    return true;
  return false;
}

}  // namespace

bool ConstraintsForm::read(const YamlReader& reader, std::vector<ConstraintSpec>& all) const {
  const auto entries = reader.named_entries("write '{torque: {bounds: control, from: urdf}}'");
  if (!entries) return false;
  for (const auto& [name, value] : *entries) {
    if (!check_kind(name, value, last_node)) continue;
    ConstraintSpec& constraint = all.emplace_back();
    constraint.function.name = name;
    constraint.function.where = {TermPlace::Kind::kConstraint, last_node};
    read_map(value, constraint,
             "write '{residual: expression, rows: x - 1}' for an equation, beside 'lower' or "
             "'upper' for an inequality");
  }
  return true;
}

std::optional<OrderedJson> ConstraintsForm::expand(const std::vector<ConstraintSpec>& all) const {
  OrderedJson json = OrderedJson::object();
  for (const ConstraintSpec& constraint : all)
    json[constraint.function.name.value] = expand_map(constraint);
  return json;
}

OrderedJson ConstraintsForm::schema(const std::vector<ConstraintSpec>& /*names the type*/,
                                    SchemaDefinitions& definitions) const {
  ConstraintSpec of_residual, bounds;
  of_residual.function.where = {TermPlace::Kind::kConstraint, last_node};
  bounds.bounded.emplace();
  OrderedJson entry = map_schema(definitions, of_residual);
  if (!last_node) entry = {{"anyOf", {map_schema(definitions, bounds), std::move(entry)}}};
  return {{"type", "object"}, {"additionalProperties", std::move(entry)}};
}

}  // namespace conddp
