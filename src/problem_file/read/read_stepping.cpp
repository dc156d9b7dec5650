#include <cmath>
#include <string>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// [lower, upper]; null means unlimited.
std::optional<std::array<double, 2>> read_ends(const YamlReader& reader) {
  const auto items = reader.items();
  if (!items) return std::nullopt;
  std::array<double, 2> ends = {-kUnlimited, kUnlimited};
  if (items->size() != 2) return reader.error("limits are [lower, upper]"), std::nullopt;
  for (int i = 0; i < 2; ++i) {
    if ((*items)[i].is_null()) continue;
    const auto number = (*items)[i].number();
    if (!number) return std::nullopt;
    ends[i] = *number;
  }
  return ends;
}

/// The same, with at least one limited end.
std::optional<std::array<double, 2>> read_limits(const YamlReader& reader) {
  const auto limits = read_ends(reader);
  if (!limits) return std::nullopt;
  const auto& [lower, upper] = *limits;
  if (std::isinf(lower) && std::isinf(upper))
    return reader.error("neither end is limited"), std::nullopt;
  if (!(lower < upper))
    return reader.error("the lower limit is not below the upper one"), std::nullopt;
  return limits;
}

void read_joint_limits(const YamlReader& reader, SteppingSpec& stepping) {
  if (reader.is_scalar()) {
    stepping.all_limits = reader.choice(kJointLimitWords, "source of joint limits").value_or(false);
    return;
  }
  const auto entries = reader.named_entries();
  if (!entries) return;
  for (const auto& [name, value] : *entries)
    if (const auto limits = read_limits(value)) stepping.joint_limits.emplace_back(name, *limits);
}

OrderedJson expand_joint_limits(const SteppingSpec& stepping) {
  if (stepping.all_limits) return word_of(kJointLimitWords, true);
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, limits] : stepping.joint_limits)
    json[name.value] = {finite_or_null(limits[0]), finite_or_null(limits[1])};
  return json;
}

/// Reports a shape without a form, or with several.
void check_form(YamlMap& map) {
  map.exclusive({"half_space", "sphere"});
  map.exclusive({"half_space", "box"});
  map.exclusive({"sphere", "box"});
  if (!map.find("half_space") && !map.find("sphere") && !map.find("box"))
    map.reader().error("the shape has no form", "give 'half_space', 'sphere' or 'box'");
}

}  // namespace

static void describe(Keys& keys, TouchedSpec& touched) {
  keys.about({.title = "Shape that a candidate may touch",
              .examples = R"([{"frame": "spinner", "sphere": {"radius": 0.25}}])"});
  keys({"frame", "The robot's frame that carries it; without it the shape stands in the world"},
       touched.frame, NameForm{});
  keys({"half_space"}, touched.form, AlternativeForm<HalfSpaceSpec>{});
  keys({"sphere"}, touched.form, AlternativeForm<SphereSpec>{});
  keys({"box"}, touched.form, AlternativeForm<BoxSpec>{});
  if (YamlMap* map = keys.reading()) check_form(*map);
}

bool TouchedForm::read(const YamlReader& reader, TouchedSpec& touched) const {
  touched.place = reader.place();
  if (!reader.is_scalar()) return read_map(reader, touched);
  if (reader.node().text == "ground") return true;
  reader.error("what a candidate may touch is 'ground' or a mapping",
               "write '{half_space: ...}', '{sphere: ...}' or '{box: ...}', with a 'frame' "
               "where one carries it");
  return false;
}

std::optional<OrderedJson> TouchedForm::expand(const TouchedSpec& touched) const {
  return expand_map(touched);
}

OrderedJson TouchedForm::schema(const TouchedSpec& /*names the type*/,
                                SchemaDefinitions& definitions) const {
  if (!definitions.contains("touched"))
    definitions["touched"] = {
        {"title", "What a candidate may touch"},
        {"anyOf", {{{"const", "ground"}}, map_schema<TouchedSpec>(definitions)}}};
  return {{"$ref", "#/definitions/touched"}};
}

void describe(Keys& keys, CandidateSpec& candidate) {
  keys.about({.definition = "contact_candidate",
              .title = "A candidate for contact-implicit steps",
              .examples = R"([{"frame": "foot", "point": [0.1, 0, 0], "friction": 0.6}])"});
  keys({.name = "frame", .says = "The robot's frame that carries it", .required = true},
       candidate.frame, NameForm{});
  keys({"point", "The point, or the sphere's center, in the frame, m"}, candidate.point,
       VectorForm{"[x, y, z] in m"});
  keys({"radius", "Of the sphere, m; 0: a point"}, candidate.radius, NumberForm{kNotNegative});
  keys({"against",
        "What it may touch: 'ground', the half-space under z = 0, which it is without this key, or "
        "a shape"},
       candidate.against, TouchedForm{});
  keys({"friction", "Coefficient of friction, without unit; 0: none"}, candidate.friction,
       NumberForm{kNotNegative});
  keys({"stiffness",
        "Of a soft contact, whose force is this times the overlap, in the unit N/m; without it the "
        "contact is rigid"},
       candidate.stiffness, NumberForm{kPositive});
  YamlMap* map = keys.reading();
  if (map != nullptr && candidate.name.value.find_first_of("/,") != std::string::npos)
    map->reader().diagnostics().error(candidate.name.place,
                                      "a candidate's name has no '/' and no ','");
}

void describe(Keys& keys, SteppingSpec& stepping) {
  keys.about({.definition = "stepping",
              .title = "Contact-implicit steps",
              .says = "How steps in time are taken that find out themselves which contacts are "
                      "closed; of ipopt",
              .examples = R"([{"plane": [0, 1, 0], "joint_limits": {"elbow": [-1.57, 1.57]}}])"});
  keys({"scheme",
        "backward_euler: all forces act at the end of the step, which damps motions; "
        "variational_midpoint: the midpoint rule of variational mechanics, which does not: "
        "velocities are those between knots, and forces of contacts act at the end of the step"},
       stepping.scheme, WordForm{kSchemeWords, "stepping scheme"});
  keys({"friction",
        "How friction along two tangents is bounded: polyhedron: by both signs of each tangent, "
        "which is weaker between them; cone: by the cone itself, the same in every direction. In a "
        "plane both are the same"},
       stepping.friction, WordForm{kFrictionWords, "friction model"});
  keys({"plane",
        "The unit normal of the plane in which a planar robot moves: its contacts slip along one "
        "tangent, those of others along two"},
       stepping.plane, DirectionForm{});
  keys({.name = "joint_limits",
        .says = "Stops: [lower, upper] by joint, rad or m, null for none; 'urdf': all limits of "
                "the URDF",
        .fallback = "{}"},
       CustomValue{[&](const YamlReader& reader) { read_joint_limits(reader, stepping); },
                   [&] { return expand_joint_limits(stepping); },
                   R"({"anyOf": [{"enum": ["none", "urdf"]},
                                 {"type": "object", "additionalProperties": {
                                    "type": "array", "items": {"type": ["number", "null"]},
                                    "minItems": 2, "maxItems": 2}}]})"});
  keys({"joint_friction", "Dry friction by joint, Nm or N"}, stepping.joint_friction,
       NamedNumbersForm{kPositive});
  keys({"regularization",
        "Weight of half the squares of contact forces, slip speeds and shares of friction in their "
        "units, as a running cost: makes forces unique that share a load"},
       stepping.regularization, NumberForm{kNotNegative});
}

}  // namespace conddp
