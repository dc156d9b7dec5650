#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

void read_radius(YamlMap& map, double& radius) {
  if (const auto r = map.require("radius")) radius = r->number(kPositive).value_or(radius);
}

void read_point(YamlMap& map, std::string_view key, Vector3<double>& point) {
  read_vector3(map, key, "[x, y, z] in m", point);
}

}  // namespace

SphereSpec read_sphere(const YamlReader& reader) {
  SphereSpec sphere;
  YamlMap map(reader);
  if (!map.valid()) return sphere;
  read_radius(map, sphere.radius);
  read_point(map, "center", sphere.center);
  return sphere;
}

HalfSpaceSpec read_half_space(const YamlReader& reader) {
  HalfSpaceSpec half_space;
  YamlMap map(reader);
  if (!map.valid()) return half_space;
  if (const auto r = map.find("normal"))
    half_space.normal = read_direction(*r).value_or(half_space.normal);
  read_point(map, "point", half_space.point);
  return half_space;
}

namespace {

CapsuleSpec read_capsule(const YamlReader& reader) {
  CapsuleSpec capsule;
  YamlMap map(reader);
  if (!map.valid()) return capsule;
  read_radius(map, capsule.radius);
  read_point(map, "from", capsule.from);
  if (const auto to = map.require("to")) {
    const auto point = read_vector3(*to, "[x, y, z] in m");
    capsule.to = point.value_or(capsule.to);
    if (point && squared_norm(capsule.to - capsule.from) == 0)
      to->error("the capsule has length 0", "write 'sphere: {radius: ..., center: [...]}'");
  }
  return capsule;
}

/// Reads the form of a shape; exactly one key must define it.
template <class Form>
std::optional<Form> read_form(YamlMap& map, bool in_world) {
  if (!map.valid()) return std::nullopt;
  std::optional<Form> form;
  int count = 0;
  const auto take = [&](std::string_view key, auto read) {
    const auto r = map.find(key);
    if (!r) return;
    form = read(*r);
    if (++count == 2) r->error("a shape is one thing: give one of its keys");
  };
  take("sphere", read_sphere);
  take("capsule", read_capsule);
  if constexpr (std::is_same_v<Form, decltype(ObstacleSpec::form)>)
    take("half_space", read_half_space);
  if (count == 0)
    map.reader().error("the shape has no form", in_world
                                                    ? "give 'sphere', 'capsule' or 'half_space'"
                                                    : "give 'sphere' or 'capsule'");
  return form;
}

/// Calls read(name, value) for every shape; duplicate names are reported.
template <class F>
void read_shapes(const YamlReader& reader, std::vector<std::string>& taken, F read) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  for (const auto& [name, value] : *entries) {
    if (name.value.find('*') != std::string::npos)
      reader.diagnostics().error(name.place, "the name of a shape has no '*'");
    if (std::find(taken.begin(), taken.end(), name.value) != taken.end())
      reader.diagnostics().error(
          name.place, fmt::format("a shape and an obstacle have the name '{}'", name.value));
    taken.push_back(name.value);
    read(name, value);
  }
}

}  // namespace

CollisionSpec read_collision(const YamlReader& reader) {
  CollisionSpec collision;
  YamlMap map(reader);
  if (!map.valid()) return collision;
  std::vector<std::string> taken;
  if (const auto r = map.find("shapes"))
    read_shapes(*r, taken, [&](const Name& name, const YamlReader& value) {
      ShapeSpec shape{.name = name};
      YamlMap keys(value);
      if (const auto frame = keys.require("frame")) shape.frame = frame->name().value_or(Name{});
      if (const auto form = read_form<decltype(shape.form)>(keys, false)) shape.form = *form;
      collision.shapes.push_back(std::move(shape));
    });
  if (const auto r = map.find("obstacles"))
    read_shapes(*r, taken, [&](const Name& name, const YamlReader& value) {
      ObstacleSpec obstacle{.name = name};
      YamlMap keys(value);
      if (const auto form = read_form<decltype(obstacle.form)>(keys, true)) obstacle.form = *form;
      collision.obstacles.push_back(std::move(obstacle));
    });
  return collision;
}

}  // namespace conddp
