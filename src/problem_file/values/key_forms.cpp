#include "problem_file/values/key_forms.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {
namespace {

/// Stores a value that was read.
template <class T>
bool take(std::optional<T> read, T& value) {
  if (read) value = *std::move(read);
  return read.has_value();
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
  return expand_names(value);
}

OrderedJson NamesForm::schema() const {
  return {{"type", "array"}, {"items", NameForm().schema()}, {"uniqueItems", true}};
}

bool NumbersForm::read(const YamlReader& reader, std::vector<double>& value) const {
  return take(reader.numbers(), value);
}

bool VectorForm::read(const YamlReader& reader, Vector3<double>& value) const {
  return take(read_vector3(reader, what), value);
}

std::optional<OrderedJson> VectorForm::expand(const Vector3<double>& value) const {
  return expand_vector(value);
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
  value = read_named_numbers(reader, range);
  return true;
}

std::optional<OrderedJson> NamedNumbersForm::expand(const NamedNumbers& value) const {
  if (value.empty() && may_be_missing) return std::nullopt;
  return expand_numbers(value);
}

OrderedJson NamedNumbersForm::schema() const {
  if (std::isinf(range.lower)) return {{"$ref", "#/definitions/numbers_by_name"}};
  return {{"type", "object"}, {"additionalProperties", range_schema(range)}};
}

bool ComponentsForm::read(const YamlReader& reader, ComponentsSpec& value) const {
  return take(read_components(reader, range), value);
}

std::optional<OrderedJson> ComponentsForm::expand(const ComponentsSpec& value) const {
  return expand_components(value);
}

OrderedJson ComponentsForm::schema() const { return {{"$ref", "#/definitions/components"}}; }

bool BoundsForm::read(const YamlReader& reader, ComponentsSpec& value) const {
  return take(read_component_bounds(reader), value);
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
  return expand_quaternion(value);
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
void warn_of_degrees(const std::vector<double>& angles, const YamlReader& reader) {
  const double largest = std::abs(*std::max_element(
      angles.begin(), angles.end(), [](double a, double b) { return std::abs(a) < std::abs(b); }));
  if (largest > 2 * std::numbers::pi)
    reader.diagnostics().warning(reader.place(),
                                 fmt::format("an angle of {:.6g} rad is more than a turn", largest),
                                 fmt::format("angles are in rad: {0:.6g}° is {1:.4g} rad", largest,
                                             largest * std::numbers::pi / 180));
}

/// A rotation in one of its forms: quaternion, or angles.
void describe_rotation(Keys& keys, std::optional<Quaternion<double>>& rotation) {
  keys({"orientation", "Unit quaternion [x, y, z, w]"}, rotation, QuaternionForm{});
  const auto read = [&rotation](const YamlReader& reader) {
    const auto n = reader.numbers(3, "[roll, pitch, yaw] in rad");
    if (!n) return;
    warn_of_degrees(*n, reader);
    rotation = of_unit_length(quaternion(rotation_rpy((*n)[0], (*n)[1], (*n)[2])));
  };
  keys({"rpy", "Roll, pitch, yaw about fixed axes, rad"},
       CustomValue{
           read, [] { return std::nullopt; },
           R"({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3})"});
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
              .examples = R"([{"position": [0, 0, 0.57]}, {"position": [1, 2], "yaw": 0.5}])"});
  keys({"position", "[x, y, z] in the world, m; [x, y] of a planar base"},
       CustomValue{
           [&base](const YamlReader& reader) { read_position(reader, base); },
           [&base] {
             return base.position ? std::optional<OrderedJson>(*base.position) : std::nullopt;
           },
           R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 3})"});
  describe_rotation(keys, base.orientation);
  keys({"yaw", "Of a planar base, rad"}, base.yaw, NumberForm{});
}

}  // namespace conddp
