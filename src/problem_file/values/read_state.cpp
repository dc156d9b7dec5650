#include "problem_file/values/read_state.hpp"

#include <fmt/format.h>

#include "problem_file/values/read_values.hpp"

namespace conddp {
namespace {

std::optional<std::vector<double>> read_position(const YamlReader& reader) {
  const auto position = reader.numbers();
  if (position && position->size() != 2 && position->size() != 3)
    reader.error(
        fmt::format("[x, y, z] in m is expected here, or [x, y] for a planar base; this one has {} "
                    "numbers",
                    position->size()));
  return position;
}

std::optional<BaseSpec> read_base(const YamlReader& reader) {
  YamlMap map(reader);
  if (!map.valid()) return std::nullopt;
  BaseSpec base{.place = reader.place()};
  if (const auto position = map.find("position")) base.position = read_position(*position);
  base.orientation = read_orientation(map);
  double yaw = 0;
  if (map.number("yaw", yaw)) base.yaw = yaw;
  return base;
}

DisplacementSpec read_displacement(const YamlReader& reader) {
  DisplacementSpec displacement{.place = reader.place()};
  if (reader.is_scalar() && reader.node().text == "gait")
    displacement.with_gait = true;
  else
    displacement.motion = read_planar_motion(reader).value_or(PlanarMotion{});
  return displacement;
}

/// Alternative notations of a state exclude each other.
void check_exclusive(YamlMap& map) {
  map.exclusive({"state", "values", "robots"});
  for (const std::string_view part : {"configuration", "base", "joints", "velocity"}) {
    map.exclusive({"state", part});
    map.exclusive({"values", part});
  }
}

void read_velocities(const YamlReader& reader, StateSpec& state) {
  YamlMap velocity(reader);
  if (const auto base = velocity.find("base")) state.base_velocity = read_twist(*base);
  if (const auto joints = velocity.find("joints"))
    state.joint_velocities = read_named_numbers(*joints);
}

/// Position and velocity of base and joints.
void read_posture(YamlMap& map, StateSpec& state) {
  if (const auto r = map.find("configuration")) state.configuration = r->name();
  map.read("base", state.base, read_base);
  map.read("displaced", state.displaced, read_displacement);
  if (const auto r = map.find("joints")) state.joints = read_named_numbers(*r);
  if (const auto r = map.find("velocity")) read_velocities(*r, state);
}

}  // namespace

StateSpec read_state_keys(YamlMap& map) {
  StateSpec state{.place = map.reader().place()};
  check_exclusive(map);
  read_posture(map, state);
  for_each_entry(map, "robots", [&](const Name& name, const YamlReader& value) {
    if (auto part = read_state(value)) state.robots.push_back({name, std::move(*part)});
  });
  if (const auto r = map.find("state")) state.state = r->numbers();
  if (const auto r = map.find("values")) state.values = read_named_numbers(*r);
  if (const auto r = map.find("previous_control")) state.previous_control = read_components(*r);
  return state;
}

std::optional<StateSpec> read_state(const YamlReader& reader) {
  YamlMap map(reader,
              "write '{values: {x: 0.5}}', '{state: [0.5, 0]}', or of a robot '{joints: {knee: "
              "0.5}}' or '{configuration: NAME}'");
  if (!map.valid()) return std::nullopt;
  return read_state_keys(map);
}

}  // namespace conddp
