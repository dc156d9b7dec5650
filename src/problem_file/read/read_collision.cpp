#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"

namespace conddp {

void describe(Keys& keys, SphereSpec& sphere) {
  keys.about({.definition = "sphere",
              .title = "Sphere",
              .says = "In the axes of its frame, or in the world",
              .examples = R"([{"radius": 0.1, "center": [0.4, 0, 0.5]}])"});
  keys({.name = "radius", .says = "Radius, m", .required = true}, sphere.radius,
       NumberForm{kPositive});
  keys({"center", "[x, y, z], m"}, sphere.center, VectorForm{"[x, y, z] in m"});
}

static void describe(Keys& keys, CapsuleSpec& capsule) {
  const int errors = keys.errors();
  keys.about({.definition = "capsule",
              .title = "Capsule",
              .says = "What is nearer than the radius to a straight line, in the axes of its frame "
                      "or in the world",
              .examples = R"([{"radius": 0.06, "to": [0, 0, 0.3]}])"});
  keys({.name = "radius", .says = "Radius, m", .required = true}, capsule.radius,
       NumberForm{kPositive});
  keys({"from", "Where the line begins, m"}, capsule.from, VectorForm{"[x, y, z] in m"});
  keys({.name = "to", .says = "Where the line ends, m", .required = true}, capsule.to,
       VectorForm{"[x, y, z] in m"});
  const bool no_line = squared_norm(capsule.to - capsule.from) == 0;
  if (const auto to = keys.found("to"); to && keys.errors() == errors && no_line)
    to->error("the capsule has length 0", "write 'sphere: {radius: ..., center: [...]}'");
}

void describe(Keys& keys, HalfSpaceSpec& half_space) {
  keys.about({.definition = "half_space",
              .title = "Half-space",
              .says = "What lies behind a plane: the ground, a table, a wall",
              .examples = R"([{"point": [0, 0, 0.3]}])"});
  keys({"normal", "Direction that leads out of it, without unit; its length does not matter"},
       half_space.normal, DirectionForm{});
  keys({"point", "A point on its surface, m"}, half_space.point, VectorForm{"[x, y, z] in m"});
}

namespace {

/// Reports a shape without a form, or with several.
void check_form(YamlMap* map, std::initializer_list<const char*> forms, const char* hint) {
  if (map == nullptr) return;
  int count = 0;
  for (const char* form : forms) {
    const auto r = map->find(form);
    if (r && ++count == 2) r->error("a shape is one thing: give one of its keys");
  }
  if (count == 0) map->reader().error("the shape has no form", hint);
}

/// Reports names of shapes and obstacles that others have, or that are patterns.
template <class Shape>
void check_names(const std::vector<Shape>& shapes, std::vector<std::string>& taken,
                 Diagnostics& out) {
  for (const Shape& shape : shapes) {
    const Name& name = shape.name;
    if (name.value.find('*') != std::string::npos)
      out.error(name.place, "the name of a shape has no '*'");
    if (std::find(taken.begin(), taken.end(), name.value) != taken.end())
      out.error(name.place, fmt::format("a shape and an obstacle have the name '{}'", name.value));
    taken.push_back(name.value);
  }
}

}  // namespace

static void describe(Keys& keys, ShapeSpec& shape) {
  keys.about({.definition = "shape",
              .title = "Shape that a link carries",
              .says = "A sphere or a capsule fixed to a frame",
              .examples = R"([{"frame": "tool", "sphere": {"radius": 0.05}}])",
              .rules = R"("oneOf": [{"required": ["sphere"]}, {"required": ["capsule"]}])"});
  keys({.name = "frame", .says = "In whose axes it is given", .required = true}, shape.frame,
       NameForm{});
  keys({"sphere"}, shape.form, AlternativeForm<SphereSpec>{});
  keys({"capsule"}, shape.form, AlternativeForm<CapsuleSpec>{});
  check_form(keys.reading(), {"sphere", "capsule"}, "give 'sphere' or 'capsule'");
}

static void describe(Keys& keys, ObstacleSpec& obstacle) {
  keys.about({.definition = "obstacle",
              .title = "Shape that stands in the world",
              .says = "A sphere, a capsule or a half-space",
              .examples = R"([{"sphere": {"radius": 0.1, "center": [0.4, 0, 0.5]}}])",
              .rules = R"("oneOf": [{"required": ["sphere"]}, {"required": ["capsule"]},
                                    {"required": ["half_space"]}])"});
  keys({"sphere"}, obstacle.form, AlternativeForm<SphereSpec>{});
  keys({"capsule"}, obstacle.form, AlternativeForm<CapsuleSpec>{});
  keys({"half_space"}, obstacle.form, AlternativeForm<HalfSpaceSpec>{});
  check_form(keys.reading(), {"sphere", "capsule", "half_space"},
             "give 'sphere', 'capsule' or 'half_space'");
}

void describe(Keys& keys, CollisionSpec& collision) {
  keys.about({.title = "Shapes that must keep apart", .examples = R"([{
                "shapes": {"forearm": {"frame": "link_5",
                                       "capsule": {"radius": 0.06, "to": [0, 0, 0.2]}}},
                "obstacles": {"table": {"half_space": {"point": [0, 0, 0.3]}}}}])"});
  keys({.name = "shapes", .says = "Shapes that links carry, by name", .fallback = "{}"},
       collision.shapes, EntriesForm{&ShapeSpec::name});
  keys({.name = "obstacles", .says = "Shapes that stand in the world, by name", .fallback = "{}"},
       collision.obstacles, EntriesForm{&ObstacleSpec::name});
  if (YamlMap* map = keys.reading()) {
    std::vector<std::string> taken;
    check_names(collision.shapes, taken, map->reader().diagnostics());
    check_names(collision.obstacles, taken, map->reader().diagnostics());
  }
}

}  // namespace conddp
