#include <array>

#include "problem_file/model/expression_source.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

constexpr std::array<std::string_view, 5> kShapes = {"sphere", "capsule", "box", "cylinder",
                                                     "hull"};

/// Corners of a line: a list of expressions.
struct CornersForm {
  bool read(const YamlReader& reader, std::vector<ExpressionText>& corners) const {
    const auto items = reader.items(kHint);
    if (!items) return false;
    for (const YamlReader& item : *items)
      if (auto text = read_expression(item)) corners.push_back(*std::move(text));
    if (items->size() < 2) reader.error("a line has two corners or more", std::string(kHint));
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<ExpressionText>& corners) const {
    if (corners.empty()) return std::nullopt;
    OrderedJson json = OrderedJson::array();
    for (const ExpressionText& corner : corners) json.push_back(corner.text);
    return json;
  }
  OrderedJson schema(const std::vector<ExpressionText>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {
        {"type", "array"}, {"minItems", 2}, {"items", ExpressionForm().schema({}, definitions)}};
  }

 private:
  static constexpr std::string_view kHint = "write 'line: [[0, 0], [x, y]]'";
};

/// Reports keys that exclude each other or need another one, and a drawing of nothing.
void check_drawing(YamlMap& map) {
  bool any = map.find("line") || map.find("at");
  for (const std::string_view& shape : kShapes) {
    any |= map.find(shape).has_value();
    map.exclusive({"line", shape});
    for (const std::string_view* other = &shape + 1; other != kShapes.end(); ++other)
      map.exclusive({shape, *other});
  }
  map.exclusive({"line", "at"});
  map.exclusive({"line", "angle"});
  if (!any && map.valid())
    map.reader().error("nothing is drawn",
                       "give a shape ('box', ...), a place 'at: [x, y]' or a 'line'");
  if (const auto angle = map.find("angle"); angle && !map.find("at") && !map.find("line"))
    angle->error("'angle' needs 'at', the point about which the shape turns", "write 'at: [0, 0]'");
}

}  // namespace

void describe(Keys& keys, DrawingSpec& drawing) {
  keys.about({.definition = "drawing",
              .title = "Drawing",
              .says = "A shape that moves with 'at' or is fixed in the world, a dot, or a line",
              .examples = R"json([{"box": {"size": [4, 2, 1]}, "at": ["x", "y"], "angle": "theta"},
                              {"line": [[0, 0], ["sin(theta)", "-cos(theta)"]]}])json",
              .rules = R"("dependencies": {"angle": ["at"]},
                          "oneOf": [{"required": ["sphere"]}, {"required": ["capsule"]},
                                    {"required": ["box"]}, {"required": ["cylinder"]},
                                    {"required": ["hull"]},
                                    {"required": ["line"], "not": {"required": ["at"]}},
                                    {"required": ["at"], "not": {"anyOf": [
                                      {"required": ["sphere"]}, {"required": ["capsule"]},
                                      {"required": ["box"]}, {"required": ["cylinder"]},
                                      {"required": ["hull"]}, {"required": ["line"]}]}}])"});
  describe_bodies(keys, drawing.shape);
  keys({.name = "at",
        .says = "Where the shape's axes are, or without a shape a dot: an expression of states, "
                "controls and time with 2 numbers (x, y, seen from above), 3 (x, y, z), or 7 (with "
                "a quaternion x y z w), m",
        .examples = R"([["x", "y"], "[position, rotation]"])"},
       drawing.at, ExpressionForm{});
  keys({.name = "angle",
        .says = "By which the shape turns about its z axis, counterclockwise seen from above, rad",
        .examples = R"(["theta"])"},
       drawing.angle, ExpressionForm{});
  keys({.name = "line",
        .says = "Instead of a shape, a line through points: expressions as 'at', of 2 or 3 numbers",
        .examples = R"([[[0, 0], ["x", "y"]]])"},
       drawing.line, CornersForm{});
  describe_phases(keys, "Phases in which it moves, names may have a *; all by default",
                  drawing.phases);
  if (YamlMap* map = keys.reading()) check_drawing(*map);
}

}  // namespace conddp
