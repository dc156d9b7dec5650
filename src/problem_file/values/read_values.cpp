#include "problem_file/values/read_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

namespace conddp {
namespace {

double norm(const Quaternion<double>& q) {
  return std::sqrt(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w);
}

}  // namespace

double unit_scale(double length) {
  constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
  return std::abs(length - 1) <= kRounding ? 1.0 : 1 / length;
}

std::optional<Vector3<double>> read_vector3(const YamlReader& reader, std::string_view what) {
  const auto n = reader.numbers(3, what);
  if (!n) return std::nullopt;
  return Vector3<double>{(*n)[0], (*n)[1], (*n)[2]};
}

void read_vector3(YamlMap& map, std::string_view key, std::string_view what,
                  Vector3<double>& vector) {
  if (const auto reader = map.find(key)) vector = read_vector3(*reader, what).value_or(vector);
}

NamedNumbers read_named_numbers(const YamlReader& reader, const NumberRange& range) {
  NamedNumbers values;
  if (const auto entries = reader.named_entries())
    for (const auto& [name, value] : *entries)
      if (const auto number = value.number(range)) values.emplace_back(name, *number);
  return values;
}

namespace {

/// Reads a number or null; returns false with an error otherwise.
bool read_component(const YamlReader& reader, const NumberRange& range,
                    std::optional<double>& value) {
  if (reader.is_null()) return true;
  value = reader.number(range);
  return value.has_value();
}

}  // namespace

std::optional<ComponentsSpec> read_components(const YamlReader& reader, const NumberRange& range) {
  ComponentsSpec spec{.place = reader.place()};
  if (reader.is_sequence()) {
    spec.form = ComponentsSpec::Form::kList;
    const auto items = reader.items();
    for (const YamlReader& item : *items)
      if (!read_component(item, range, spec.list.emplace_back())) return std::nullopt;
    return spec;
  }
  if (reader.is_map()) {
    spec.form = ComponentsSpec::Form::kMap;
    const auto entries = reader.named_entries();
    for (const auto& [name, value] : *entries)
      if (!read_component(value, range, spec.map.emplace_back(name, std::nullopt).second))
        return std::nullopt;
    return spec;
  }
  spec.scalar = reader.number(range);
  if (!spec.scalar) return std::nullopt;
  return spec;
}

std::optional<ComponentsSpec> read_component_bounds(const YamlReader& reader) {
  if (reader.is_null()) return ComponentsSpec{.place = reader.place()};
  return read_components(reader);
}

std::optional<MatrixSpec> read_symmetric_matrix(const YamlReader& reader) {
  constexpr std::string_view kHint = "write '[[2, 1], [1, 3]]' or '{x: {x: 2, v: 1}, v: {v: 3}}'";
  MatrixSpec matrix{.place = reader.place()};
  if (reader.is_map()) {
    const auto entries = reader.named_entries(kHint);
    for (const auto& [name, row] : *entries)
      matrix.entries.emplace_back(name, read_named_numbers(row));
    return matrix;
  }
  const auto rows = reader.items(kHint);
  if (!rows) return std::nullopt;
  for (const YamlReader& row : *rows) {
    const auto numbers = row.numbers();
    if (!numbers) return std::nullopt;
    matrix.rows.push_back({*numbers, row.place()});
  }
  return matrix;
}

std::optional<PlanarMotion> read_planar_motion(const YamlReader& reader) {
  const auto n = reader.numbers(3, "[x, y, yaw] in m and rad");
  if (!n) return std::nullopt;
  return PlanarMotion{(*n)[0], (*n)[1], (*n)[2]};
}

namespace {

std::optional<Quaternion<double>> read_quaternion(const YamlReader& reader) {
  constexpr double kTolerance = 1e-3;
  const auto n = reader.numbers(4, "a quaternion [x, y, z, w]");
  if (!n) return std::nullopt;
  const Quaternion<double> q{(*n)[0], (*n)[1], (*n)[2], (*n)[3]};
  const double length = norm(q);
  if (!(std::abs(length - 1) > kTolerance)) return q;
  reader.error(fmt::format("the quaternion has length {:.6g}, not 1", length),
               "the order is [x, y, z, w]; no rotation is [0, 0, 0, 1]");
  return std::nullopt;
}

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

}  // namespace

std::optional<Quaternion<double>> read_orientation(YamlMap& map) {
  map.exclusive({"orientation", "rpy"});
  std::optional<Quaternion<double>> result;
  if (const auto reader = map.find("orientation")) result = read_quaternion(*reader);
  if (const auto reader = map.find("rpy"))
    if (const auto n = reader->numbers(3, "[roll, pitch, yaw] in rad")) {
      warn_of_degrees(*n, *reader);
      result = quaternion(rotation_rpy((*n)[0], (*n)[1], (*n)[2]));
    }
  if (!result) return std::nullopt;
  const double scale = unit_scale(norm(*result));
  return Quaternion<double>{scale * result->x, scale * result->y, scale * result->z,
                            scale * result->w};
}

std::optional<PoseSpec> read_pose(const YamlReader& reader) {
  YamlMap map(reader);
  if (!map.valid()) return std::nullopt;
  PoseSpec pose{.place = reader.place()};
  if (const auto position = map.find("position"))
    pose.position = read_vector3(*position, "[x, y, z] in m");
  pose.orientation = read_orientation(map);
  return pose;
}

std::optional<TwistSpec> read_twist(const YamlReader& reader) {
  TwistSpec twist{.place = reader.place()};
  if (reader.is_sequence()) {
    const auto n = reader.numbers(6, "[vx, vy, vz, wx, wy, wz] in m/s and rad/s");
    if (!n) return std::nullopt;
    for (int i = 0; i < 3; ++i) twist.linear[i] = (*n)[i], twist.angular[i] = (*n)[i + 3];
    return twist;
  }
  YamlMap map(reader);
  if (!map.valid()) return std::nullopt;
  read_vector3(map, "linear", "[x, y, z] in m/s", twist.linear);
  read_vector3(map, "angular", "[x, y, z] in rad/s", twist.angular);
  return twist;
}

ContactNames read_contact_names(const YamlReader& reader) {
  ContactNames contacts;
  if (reader.is_scalar() && reader.node().text == "all") {
    contacts.all = true;
    return contacts;
  }
  if (const auto names = reader.name_or_names()) contacts.names = *names;
  return contacts;
}

}  // namespace conddp
