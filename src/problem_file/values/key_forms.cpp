#include "problem_file/values/key_forms.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "problem_file/model/expression_source.hpp"

namespace conddp {
namespace {

/// Stores a value that was read.
template <class T>
bool take(std::optional<T> read, T& value) {
  if (read) value = *std::move(read);
  return read.has_value();
}

OrderedJson range_schema(const NumberRange& range) {
  OrderedJson schema = {{"type", "number"}};
  if (std::isfinite(range.lower))
    schema[range.lower_open ? "exclusiveMinimum" : "minimum"] = range.lower;
  if (std::isfinite(range.upper))
    schema[range.upper_open ? "exclusiveMaximum" : "maximum"] = range.upper;
  return schema;
}

/// Factor that scales a vector of this length to unit length; 1 within rounding, so that repeated
/// scaling changes nothing.
double unit_scale(double length) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(length - 1) <= kRounding ? 1.0 : 1 / length;
}

double norm(const Quaternion<double>& q) {
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
}

Quaternion<double> of_unit_length(const Quaternion<double>& q) {
  const double scale = unit_scale(norm(q));
  return {scale * q.x, scale * q.y, scale * q.z, scale * q.w};
}

}  // namespace

bool NumberForm::read(const YamlReader& reader, double& value) const {
  return take(reader.number(range), value);
}

std::optional<OrderedJson> NumberForm::expand(double value) const {
  return std::isfinite(value) ? std::optional<OrderedJson>(value) : std::nullopt;
}

OrderedJson NumberForm::schema() const { return range_schema(range); }

OrderedJson IntegerForm::schema() const {
  OrderedJson schema = {{"type", "integer"}, {"minimum", lower}};
  if (upper < std::numeric_limits<long long>::max()) schema["maximum"] = upper;
  return schema;
}

bool KnotForm::read(const YamlReader& reader, KnotSpec& knot) const {
  constexpr int kMostKnots = 1'000'000;
  knot = {.place = reader.place()};
  if (!reader.is_scalar() || reader.is_number()) {
    const auto number = reader.integer(0, kMostKnots);
    if (number) knot.value = static_cast<int>(*number);
    return number.has_value();
  }
  const auto text = reader.text();
  if (!text) return false;
  const std::size_t sign = text->find_last_of("+-");
  if (sign == std::string::npos || sign < 2 || (*text)[sign - 1] != ' ') {
    knot.phase = *text;
    return true;
  }
  knot.phase = text->substr(0, text->find_last_not_of(' ', sign - 1) + 1);
  const char* end = text->data() + text->size();
  const char* begin = std::find_if(text->data() + sign + 1, end, [](char c) { return c != ' '; });
  const auto [stop, failure] = std::from_chars(begin, end, knot.value);
  if (failure != std::errc() || stop != end || knot.value < 0 || knot.value > kMostKnots) {
    reader.error("a knot is a number, a phase, or 'phase + 3'");
    return false;
  }
  if ((*text)[sign] == '-') knot.value = -knot.value;
  return true;
}

std::optional<OrderedJson> KnotForm::expand(const KnotSpec& knot) const {
  if (knot.phase.empty()) return OrderedJson(knot.value);
  if (knot.value == 0) return OrderedJson(knot.phase);
  return OrderedJson(
      fmt::format("{} {} {}", knot.phase, knot.value < 0 ? '-' : '+', std::abs(knot.value)));
}

OrderedJson KnotForm::schema() const {
  return {{"anyOf",
           {{{"type", "integer"}, {"minimum", 0}, {"maximum", 1'000'000}},
            {{"type", "string"}, {"minLength", 1}}}}};
}

bool KnotsForm::read(const YamlReader& reader, std::vector<KnotSpec>& knots) const {
  const auto items = reader.items();
  if (!items) return false;
  if (items->empty())
    reader.error("an empty list names no knot", "leave the key out for all knots");
  for (const YamlReader& item : *items)
    if (KnotSpec knot; KnotForm().read(item, knot)) knots.push_back(std::move(knot));
  return true;
}

std::optional<OrderedJson> KnotsForm::expand(const std::vector<KnotSpec>& knots) const {
  OrderedJson json = OrderedJson::array();
  for (const KnotSpec& knot : knots) json.push_back(*KnotForm().expand(knot));
  return json;
}

OrderedJson KnotsForm::schema() const {
  return {{"type", "array"}, {"items", KnotForm().schema()}};
}

bool FlagForm::read(const YamlReader& reader, bool& value) const {
  static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
  return take(reader.choice(kWords, what), value);
}

bool NameForm::read(const YamlReader& reader, std::string& value) const {
  auto name = reader.name();
  if (name) value = std::move(name->value);
  return name.has_value();
}

bool NamesForm::read(const YamlReader& reader, std::vector<Name>& value) const {
  return take(reader.names(), value);
}

std::optional<OrderedJson> NamesForm::expand(const std::vector<Name>& value) const {
  OrderedJson list = OrderedJson::array();
  for (const Name& name : value) list.push_back(name.value);
  return list;
}

OrderedJson NamesForm::schema() const {
  return {{"type", "array"}, {"items", NameForm().schema()}, {"uniqueItems", true}};
}

bool NameOrNamesForm::read(const YamlReader& reader, std::vector<Name>& value) const {
  if (!take(reader.name_or_names(), value)) return false;
  if (value.empty() && !empty.empty())
    reader.error(fmt::format("an empty list names no {}", empty),
                 fmt::format("leave the key out for all {}s", empty));
  return true;
}

OrderedJson NameOrNamesForm::schema() const {
  return {{"anyOf", {NameForm().schema(), NamesForm::schema()}}};
}

bool ContactNamesForm::read(const YamlReader& reader, ContactNames& value) const {
  value.all = reader.is_scalar() && reader.node().text == "all";
  return value.all || take(reader.name_or_names(), value.names);
}

std::optional<OrderedJson> ContactNamesForm::expand(const ContactNames& value) const {
  return value.all ? OrderedJson("all") : NamesForm().expand(value.names);
}

OrderedJson ContactNamesForm::schema(const ContactNames& /*names the type*/,
                                     SchemaDefinitions& definitions) const {
  return defined(definitions, "contact_names", [] {
    OrderedJson schema = {{"title", "Contacts"},
                          {"description", "all, a contact's name, or a list of names"}};
    schema.update(NameOrNamesForm().schema());
    schema["examples"] = OrderedJson::parse(R"(["all", ["LF", "RH"]])");
    return schema;
  });
}

bool ExpressionForm::read(const YamlReader& reader, ExpressionText& value) const {
  return take(read_expression(reader), value);
}

OrderedJson ExpressionForm::schema(const ExpressionText& /*names the type*/,
                                   SchemaDefinitions& definitions) const {
  return defined(definitions, "expression", [] {
    return OrderedJson::parse(R"({
      "type": ["string", "number", "array"], "title": "Expression",
      "description": "Numbers, names, + - * / ^, parentheses and functions; a list is a vector",
      "examples": ["x^2 + (y - 1)^2", "u[knee]*v[knee]"]})");
  });
}

bool NumbersForm::read(const YamlReader& reader, std::vector<double>& value) const {
  return take(reader.numbers(), value);
}

bool VectorForm::read(const YamlReader& reader, Vector3<double>& value) const {
  const auto n = reader.numbers(3, what);
  if (n) value = {(*n)[0], (*n)[1], (*n)[2]};
  return n.has_value();
}

std::optional<OrderedJson> VectorForm::expand(const Vector3<double>& value) const {
  return OrderedJson(std::vector{value.x, value.y, value.z});
}

OrderedJson VectorForm::schema() const {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 3}, {"maxItems", 3}};
}

bool DirectionForm::read(const YamlReader& reader, Vector3<double>& value) const {
  Vector3<double> given;
  if (!VectorForm::read(reader, given)) return false;
  const double length = std::sqrt(squared_norm(given));
  if (!(length > 1e-6)) return reader.error("a direction of length 0"), false;
  value = unit_scale(length) * given;
  return true;
}

bool NamedNumbersForm::read(const YamlReader& reader, NamedNumbers& value) const {
  const auto entries = reader.named_entries();
  if (!entries) return false;
  value.clear();
  for (const auto& [name, own] : *entries)
    if (const auto number = own.number(range)) value.emplace_back(name, *number);
  return true;
}

std::optional<OrderedJson> NamedNumbersForm::expand(const NamedNumbers& value) const {
  if (value.empty() && may_be_missing) return std::nullopt;
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, number] : value) json[name.value] = number;
  return json;
}

OrderedJson NamedNumbersForm::schema() const {
  if (std::isinf(range.lower)) return {{"$ref", "#/definitions/numbers_by_name"}};
  return {{"type", "object"}, {"additionalProperties", range_schema(range)}};
}

bool ComponentsForm::read(const YamlReader& reader, ComponentsSpec& value) const {
  using Form = ComponentsSpec::Form;
  ComponentsSpec spec{.place = reader.place(),
                      .form = reader.is_sequence() ? Form::kList
                              : reader.is_map()    ? Form::kMap
                                                   : Form::kScalar};
  const auto read_one = [&](const YamlReader& one, std::optional<double>& number) {
    if (!one.is_null()) number = one.number(range);
    return one.is_null() || number.has_value();
  };
  if (spec.form == Form::kScalar && !(spec.scalar = reader.number(range))) return false;
  if (spec.form == Form::kList) {
    const auto items = reader.items();
    for (const YamlReader& item : *items)
      if (!read_one(item, spec.list.emplace_back())) return false;
  }
  if (spec.form == Form::kMap) {
    const auto entries = reader.named_entries();
    for (const auto& [name, one] : *entries)
      if (!read_one(one, spec.map.emplace_back(name, std::nullopt).second)) return false;
  }
  value = std::move(spec);
  return true;
}

std::optional<OrderedJson> ComponentsForm::expand(const ComponentsSpec& value) const {
  const auto shown = [](const std::optional<double>& number) {
    return number ? OrderedJson(*number) : OrderedJson(nullptr);
  };
  if (value.form == ComponentsSpec::Form::kScalar) return shown(value.scalar);
  const bool is_list = value.form == ComponentsSpec::Form::kList;
  OrderedJson json = is_list ? OrderedJson::array() : OrderedJson::object();
  for (const auto& number : value.list) json.push_back(shown(number));
  for (const auto& [name, number] : value.map) json[name.value] = shown(number);
  return json;
}

OrderedJson ComponentsForm::schema() const { return {{"$ref", "#/definitions/components"}}; }

bool BoundsForm::read(const YamlReader& reader, ComponentsSpec& value) const {
  if (!reader.is_null()) return ComponentsForm::read(reader, value);
  value = {.place = reader.place()};
  return true;
}

OrderedJson BoundsForm::schema() const { return {{"$ref", "#/definitions/limits"}}; }

bool QuaternionForm::read(const YamlReader& reader, Quaternion<double>& value) const {
  constexpr double kTolerance = 1e-3;
  const auto n = reader.numbers(4, "a quaternion [x, y, z, w]");
  if (!n) return false;
  const Quaternion<double> q{(*n)[0], (*n)[1], (*n)[2], (*n)[3]};
  const double length = norm(q);
  if (std::abs(length - 1) > kTolerance) {
    reader.error(fmt::format("the quaternion has length {:.6g}, not 1", length),
                 "the order is [x, y, z, w]; no rotation is [0, 0, 0, 1]");
    return false;
  }
  value = of_unit_length(q);
  return true;
}

std::optional<OrderedJson> QuaternionForm::expand(const Quaternion<double>& value) const {
  return OrderedJson(std::vector{value.x, value.y, value.z, value.w});
}

OrderedJson QuaternionForm::schema() const {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", 4}, {"maxItems", 4}};
}

bool TwistForm::read(const YamlReader& reader, TwistSpec& value) const {
  if (!reader.is_sequence()) return read_map(reader, value);
  const auto n = reader.numbers(6, "[vx, vy, vz, wx, wy, wz] in m/s and rad/s");
  if (!n) return false;
  value.place = reader.place();
  for (int i = 0; i < 3; ++i) value.linear[i] = (*n)[i], value.angular[i] = (*n)[i + 3];
  return true;
}

std::optional<OrderedJson> TwistForm::expand(const TwistSpec& value) const {
  return expand_map(value);
}

OrderedJson TwistForm::schema(const TwistSpec& /*names the type*/,
                              SchemaDefinitions& definitions) const {
  if (!definitions.contains("twist")) {
    const OrderedJson numbers = {{"type", "array"},
                                 {"items", {{"type", "number"}}},
                                 {"minItems", 6},
                                 {"maxItems", 6},
                                 {"description", "[vx, vy, vz, wx, wy, wz], m/s and rad/s"}};
    definitions["twist"] = {
        {"title", "Velocity"},
        {"description", "Linear and angular velocity"},
        {"anyOf", {numbers, map_schema<TwistSpec>(definitions)}},
        {"examples", {{0, 0, 0.1, 0, 0, 0}, {{"linear", {0, 0, 0.1}}, {"angular", {0, 0, 0}}}}}};
  }
  return {{"$ref", "#/definitions/twist"}};
}

namespace {

/// Warns of angles beyond a full turn.
void warn_of_degrees(const Vector3<double>& angles, const YamlReader& reader) {
  const double largest = std::max({std::abs(angles.x), std::abs(angles.y), std::abs(angles.z)});
  if (largest > 2 * std::numbers::pi)
    reader.diagnostics().warning(reader.place(),
                                 fmt::format("an angle of {:.6g} rad is more than a turn", largest),
                                 fmt::format("angles are in rad: {0:.6g}° is {1:.4g} rad", largest,
                                             largest * std::numbers::pi / 180));
}

/// A rotation in one of its forms: quaternion, or angles.
void describe_rotation(Keys& keys, std::optional<Quaternion<double>>& rotation) {
  keys({"orientation", "Unit quaternion [x, y, z, w]"}, rotation, QuaternionForm{});
  std::optional<Vector3<double>> rpy;
  keys({"rpy", "Roll, pitch, yaw about fixed axes, rad"}, rpy,
       VectorForm{"[roll, pitch, yaw] in rad"});
  if (rpy) {
    warn_of_degrees(*rpy, *keys.found("rpy"));
    rotation = of_unit_length(quaternion(rotation_rpy(rpy->x, rpy->y, rpy->z)));
  }
  keys.exclusive({"orientation", "rpy"});
}

}  // namespace

void describe(Keys& keys, PoseSpec& pose) {
  keys.about({.definition = "pose",
              .title = "Placement in the world",
              .says = "Position and rotation; what is left out is zero where a whole placement is "
                      "asked for",
              .examples = R"([{"position": [0.35, 0.45, 0.4], "rpy": [3.1416, 0, -2.24]},
                              {"orientation": [0, 0, 0, 1]}])"});
  keys({"position", "[x, y, z] in the world, m"}, pose.position, VectorForm{"[x, y, z] in m"});
  describe_rotation(keys, pose.orientation);
}

void describe(Keys& keys, TwistSpec& twist) {
  keys.about({.title = "Velocity by its parts", .examples = R"([{"linear": [0, 0, 0.1]}])"});
  keys({"linear", "[vx, vy, vz], m/s"}, twist.linear, VectorForm{"[x, y, z] in m/s"});
  keys({"angular", "[wx, wy, wz], rad/s"}, twist.angular, VectorForm{"[x, y, z] in rad/s"});
}

namespace {

/// A position of a floating or a planar base.
void read_position(const YamlReader& reader, BaseSpec& base) {
  base.position = reader.numbers();
  if (base.position && base.position->size() != 2 && base.position->size() != 3)
    reader.error(
        fmt::format("[x, y, z] in m is expected here, or [x, y] for a planar base; this one has {} "
                    "numbers",
                    base.position->size()));
}

}  // namespace

void describe(Keys& keys, BaseSpec& base) {
  keys.about({.definition = "base_state",
              .title = "Where the base is",
              .says = "Of a floating or planar base; what is left out is zero",
              .examples = R"([{"position": [0, 0, 0.57]}, {"position": [1, 2]}])"});
  keys({"position", "[x, y, z] in the world, m; [x, y] of a planar base"},
       CustomValue{
           [&base](const YamlReader& reader) { read_position(reader, base); },
           [&base] {
             return base.position ? std::optional<OrderedJson>(*base.position) : std::nullopt;
           },
           R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3})"});
  describe_rotation(keys, base.orientation);
  keys.removed("yaw", "write 'joints: {base_yaw: 0.5}' beside 'base'");
}

std::optional<OrderedJson> ParametersForm::expand(const ExpressionNamesSpec& names) const {
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, value] : names.parameters)
    json[name] = value.is_vector ? OrderedJson(value.numbers) : OrderedJson(value.numbers[0]);
  return json;
}

OrderedJson ParametersForm::schema(const ExpressionNamesSpec& /*names the type*/,
                                   SchemaDefinitions& definitions) const {
  const OrderedJson value = ExpressionForm().schema({}, definitions);
  const OrderedJson free = {{"$ref", "#/definitions/free_parameter"}};
  return {{"type", "object"}, {"additionalProperties", {{"anyOf", {value, free}}}}};
}

bool MotionForm::read(const YamlReader& reader, PlanarMotion& value) const {
  const bool rises = reader.is_sequence() && reader.node().items.size() == 4;
  const auto n = reader.numbers(rises ? 4 : 3, "[x, y, yaw] in m and rad");
  if (n) value = {(*n)[0], (*n)[1], (*n)[2], rises ? (*n)[3] : 0};
  return n.has_value();
}

std::optional<OrderedJson> MotionForm::expand(const PlanarMotion& value) const {
  OrderedJson json = {value.x, value.y, value.yaw};
  if (value.rise != 0) json.push_back(value.rise);
  return json;
}

SchemaDefinitions value_definitions() {
  return OrderedJson::parse(R"json({
    "components": {
      "title": "Values of the components of a vector",
      "description": "One number for all; a list with one entry a component (null: none); or a mapping from component names to numbers, where a name may have a * and exact names win.",
      "anyOf": [
        {"type": "number"},
        {"type": "array", "items": {"type": ["number", "null"]}},
        {"type": "object", "additionalProperties": {"type": ["number", "null"]}}
      ],
      "examples": [0.1, [1, 1, null], {"q/*": 1, "q/knee": 10}]
    },
    "limits": {
      "title": "Bounds of the components of a vector",
      "description": "Values of the components; null: none has a bound.",
      "anyOf": [{"$ref": "#/definitions/components"}, {"type": "null"}],
      "examples": [-1, null, [0, null], {"q/*": 1}]
    },
    "numbers_by_name": {
      "type": "object", "additionalProperties": {"type": "number"},
      "title": "Numbers by name", "description": "Names and their numbers",
      "examples": [{"hip": 0.2, "knee": -1.5}]
    },
    "matrix": {
      "title": "Symmetric matrix",
      "description": "Positive semidefinite: all rows, the rows of the triangle up to the diagonal, or entries by the names of row and column, each of which stands for its mirror image, too.",
      "anyOf": [
        {"type": "array", "minItems": 1, "items": {"type": "array", "items": {"type": "number"}}},
        {"type": "object", "additionalProperties": {"$ref": "#/definitions/numbers_by_name"}}
      ],
      "examples": [[[2, 1], [1, 3]], [[2], [1, 3]], {"theta": {"theta": 2, "omega": 1}, "omega": {"omega": 3}}]
    },
    "planar_motion": {
      "type": "array", "title": "Motion of a base in the plane",
      "description": "[x, y, yaw] or [x, y, yaw, rise]: forward and to the left as the base points before (m), a turn about its origin (rad), and upward (m)",
      "items": {"type": "number"}, "minItems": 3, "maxItems": 4, "examples": [[0.3, 0, 0.5], [0.3, 0, 0, 0.15]]
    }
  })json");
}

}  // namespace conddp
