#include <cmath>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

void read_direction(const YamlReader& reader, Vector3<double>& direction) {
  const auto vector = read_vector3(reader, "a direction [x, y, z]");
  if (!vector) return;
  const double length = std::sqrt(squared_norm(*vector));
  if (length > 0)
    direction = unit_scale(length) * *vector;
  else
    reader.error("the direction has no length");
}

/// A number; null means `none`.
std::optional<double> read_limit(const YamlReader& reader, double none) {
  return reader.is_null() ? none : reader.number();
}

ThrusterSpec read_thruster(const YamlReader& reader) {
  ThrusterSpec thruster;
  YamlMap map(reader);
  if (const auto r = map.require("name")) thruster.name = r->name().value_or(Name{});
  if (const auto r = map.require("frame")) thruster.frame = r->name().value_or(Name{});
  if (const auto r = map.find("direction")) read_direction(*r, thruster.direction);
  map.number("torque_ratio", thruster.torque_ratio);
  if (const auto r = map.find("lower"))
    thruster.lower = read_limit(*r, -kUnlimited).value_or(thruster.lower);
  if (const auto r = map.find("upper"))
    thruster.upper = read_limit(*r, kUnlimited).value_or(thruster.upper);
  if (thruster.lower > thruster.upper)
    reader.error(fmt::format("the lower limit {} is above the upper limit {}", thruster.lower,
                             thruster.upper));
  return thruster;
}

}  // namespace

ActuationSpec read_actuation(const YamlReader& reader) {
  ActuationSpec actuation;
  if (reader.is_scalar()) {
    actuation.full = reader.choice(kActuationWords, "actuation (nor a mapping)").value_or(true);
    return actuation;
  }
  YamlMap map(reader);
  if (!map.valid()) return actuation;
  actuation.full = false;
  const auto thrusters = map.find("thrusters");
  const auto joints = map.find("joints");
  if (!thrusters && !joints)
    reader.error("'joints' or 'thrusters' is expected here", "or write 'actuation: none'");
  for_each_item(map, "thrusters", [&](const YamlReader& item) {
    actuation.thrusters.push_back(read_thruster(item));
  });
  if (joints) actuation.joints = joints->names().value_or(std::vector<Name>{});
  return actuation;
}

}  // namespace conddp
