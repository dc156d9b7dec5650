#include <algorithm>
#include <string>

#include <fmt/format.h>

#include "problem_file/data/mesh_hull.hpp"
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

/// Keys of a body about a line.
template <class Spec>
static void describe_line(Keys& keys, Spec& spec, const char* defect, const char* hint) {
  const int errors = keys.errors();
  keys({.name = "radius", .says = "Radius, m", .required = true}, spec.radius,
       NumberForm{kPositive});
  keys({"from", "Where the line begins, m"}, spec.from, VectorForm{"[x, y, z] in m"});
  keys({.name = "to", .says = "Where the line ends, m", .required = true}, spec.to,
       VectorForm{"[x, y, z] in m"});
  const bool no_line = squared_norm(spec.to - spec.from) == 0;
  if (const auto to = keys.found("to"); to && keys.errors() == errors && no_line)
    to->error(defect, hint);
}

void describe(Keys& keys, CapsuleSpec& capsule) {
  keys.about({.definition = "capsule",
              .title = "Capsule",
              .says = "What is nearer than the radius to a straight line, in the axes of its frame "
                      "or in the world",
              .examples = R"([{"radius": 0.06, "to": [0, 0, 0.3]}])"});
  describe_line(keys, capsule, "the capsule has length 0",
                "write 'sphere: {radius: ..., center: [...]}'");
}

void describe(Keys& keys, CylinderSpec& cylinder) {
  keys.about({.definition = "cylinder",
              .title = "Cylinder",
              .says =
                  "A cylinder about a line, in the axes of its frame or in the world; distances "
                  "see a prism of 32 faces around it, whose edges are 0.5 % further out",
              .examples = R"([{"radius": 0.06, "to": [0, 0, 0.3]}])"});
  describe_line(keys, cylinder, "the cylinder has length 0", "write 'to: [0, 0, 0.1]'");
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

/// Positive lengths of the edges of a box.
struct EdgesForm : VectorForm {
  EdgesForm() : VectorForm{"[x, y, z] in m"} {}
  bool read(const YamlReader& reader, Vector3<double>& value) const {
    Vector3<double> edges;
    if (!VectorForm::read(reader, edges)) return false;
    if (!(edges.x > 0 && edges.y > 0 && edges.z > 0))
      return reader.error("the edges of a box have positive lengths"), false;
    value = edges;
    return true;
  }
  OrderedJson schema() const {
    OrderedJson schema = VectorForm::schema();
    schema["items"]["exclusiveMinimum"] = 0;
    return schema;
  }
};

/// Points of a convex hull.
struct PointsForm {
  bool read(const YamlReader& reader, std::vector<Vector3<double>>& points) const {
    const auto items = reader.items();
    if (!items) return false;
    if (items->empty()) reader.error("there is no point", "write '[[0, 0, 0], [0.1, 0, 0]]'");
    for (const YamlReader& item : *items)
      kPoint.read(item, points.emplace_back(Vector3<double>::zero()));
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<Vector3<double>>& points) const {
    OrderedJson json = OrderedJson::array();
    for (const Vector3<double>& point : points) json.push_back(*kPoint.expand(point));
    return json;
  }
  OrderedJson schema() const {
    return {{"type", "array"}, {"minItems", 1}, {"items", kPoint.schema()}};
  }

 private:
  static constexpr VectorForm kPoint{"[x, y, z] in m"};
};

}  // namespace

void describe(Keys& keys, BoxSpec& box) {
  keys.about({.definition = "box",
              .title = "Box",
              .says = "A box about the middle of its placement",
              .examples = R"([{"size": [1, 1, 0.5]}])"});
  keys({.name = "size", .says = "Lengths of its edges along x, y and z, m", .required = true},
       box.size, EdgesForm{});
  keys({"placement", "Of its middle and axes, in the frame or in the world"}, box.placement,
       MapForm{});
}

void describe(Keys& keys, HullSpec& hull) {
  keys.about({.definition = "hull",
              .title = "Convex hull",
              .says = "The smallest convex body around points",
              .examples = R"([{"points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]},
                              {"mesh": "chair.stl", "scale": 0.001}])",
              .rules = R"("oneOf": [{"required": ["points"]}, {"required": ["mesh"]}])"});
  Name file;
  double scale = 1;
  keys({.name = "points", .says = "Points, m", .fallback = "none"}, hull.points, PointsForm{});
  keys({.name = "mesh",
        .says = "Instead of points, an STL, OBJ, Collada or glTF file, relative to the problem "
                "file; its "
                "body is "
                "contained, and exceeded by at most half a percent of its size",
        .fallback = "none",
        .omitted = true},
       file, NameForm{});
  keys({.name = "scale",
        .says = "Meters in the unit of the mesh; 1 by default",
        .fallback = "none",
        .omitted = true},
       scale, NumberForm{kPositive});
  keys({"radius", "By which it is expanded, m"}, hull.radius, NumberForm{kNotNegative});
  keys({"placement", "Of the points' axes, in the frame or in the world"}, hull.placement,
       MapForm{});
  YamlMap* map = keys.reading();
  if (map == nullptr) return;
  map->exclusive({"points", "mesh"});
  const auto mesh = map->find("mesh");
  if (!mesh && !map->find("points"))
    map->reader().error("the hull has no points", "give 'points' or 'mesh'");
  if (!mesh || file.value.empty()) return;
  std::string defect;
  const HullSpec around = mesh_hull(map->reader().folder() / file.value, {scale, scale, scale},
                                    defect, map->reader().diagnostics());
  if (!defect.empty()) mesh->error(defect);
  hull.points = around.points;
  hull.radius += around.radius;
}

void check_form(YamlMap* map, std::initializer_list<const char*> forms, const char* hint) {
  if (map == nullptr) return;
  int count = 0;
  for (const char* form : forms) {
    const auto r = map->find(form);
    if (r && ++count == 2) r->error("a shape is one thing: give one of its keys");
  }
  if (count == 0) map->reader().error("the shape has no form", hint);
}

static void describe(Keys& keys, ShapeSpec& shape) {
  keys.about({.definition = "shape",
              .title = "Shape that a link carries",
              .says = "A convex body fixed to a frame",
              .examples = R"([{"frame": "tool", "sphere": {"radius": 0.05}}])",
              .rules = R"("oneOf": [{"required": ["sphere"]}, {"required": ["capsule"]},
                                    {"required": ["box"]}, {"required": ["cylinder"]},
                                    {"required": ["hull"]}])"});
  keys({.name = "frame", .says = "In whose axes it is given", .required = true}, shape.frame,
       NameForm{});
  describe_bodies(keys, shape.form);
  check_form(keys.reading(), {"sphere", "capsule", "box", "cylinder", "hull"},
             "give 'sphere', 'capsule', 'box', 'cylinder' or 'hull'");
}

static void describe(Keys& keys, ObstacleSpec& obstacle) {
  keys.about({.definition = "obstacle",
              .title = "Shape that stands in the world",
              .says = "A convex body or a half-space",
              .examples = R"([{"box": {"size": [0.6, 0.3, 0.02],
                                       "placement": {"position": [0.5, 0, 0.4]}}}])",
              .rules = R"("oneOf": [{"required": ["sphere"]}, {"required": ["capsule"]},
                                    {"required": ["box"]}, {"required": ["cylinder"]},
                                    {"required": ["hull"]}, {"required": ["half_space"]}])"});
  describe_bodies(keys, obstacle.form);
  keys({"half_space"}, obstacle.form, AlternativeForm<HalfSpaceSpec>{});
  check_form(keys.reading(), {"sphere", "capsule", "box", "cylinder", "hull", "half_space"},
             "give 'sphere', 'capsule', 'box', 'cylinder', 'hull' or 'half_space'");
}

void check_shape_names(const ProblemSpec& spec, Diagnostics& out) {
  std::vector<std::string> taken;
  const auto check = [&](const auto& shapes) {
    for (const auto& shape : shapes) {
      const Name& name = shape.name;
      if (name.value.find('*') != std::string::npos)
        out.error(name.place, "the name of a shape has no '*'");
      if (std::find(taken.begin(), taken.end(), name.value) != taken.end())
        out.error(name.place, fmt::format("two shapes have the name '{}'", name.value));
      taken.push_back(name.value);
    }
  };
  check(spec.collision.shapes);
  check(spec.collision.obstacles);
  check(spec.terrain);
}

void describe(Keys& keys, CollisionSpec& collision) {
  keys.about({.title = "Shapes that must keep apart", .examples = R"([{
                "shapes": {"forearm": {"frame": "link_5",
                                       "capsule": {"radius": 0.06, "to": [0, 0, 0.2]}}},
                "obstacles": {"table": {"half_space": {"point": [0, 0, 0.3]}}}}])"});
  static constexpr Choice<bool> kSources[] = {{"urdf", true}};
  keys({"from",
        "Take the collision shapes of the robots' URDFs, too: each has the name of its link, and "
        "further ones of the link '/2', '/3' behind it"},
       PlacedWord(kSources, "source of shapes", collision.from_urdf));
  keys({.name = "shapes",
        .says = "Shapes that links carry, by name; they replace those of the URDF that have it",
        .fallback = "{}"},
       collision.shapes, EntriesForm{&ShapeSpec::name});
  keys({.name = "obstacles", .says = "Shapes that stand in the world, by name", .fallback = "{}"},
       collision.obstacles, EntriesForm{&ObstacleSpec::name});
}

}  // namespace conddp
