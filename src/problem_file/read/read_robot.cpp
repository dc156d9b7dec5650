#include <algorithm>
#include <string>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// A payload, and the parameters of its robot that its mass may name.
struct PayloadOfRobot {
  PayloadSpec& payload;
  const NamedNumbers& parameters;
};

/// Reads a number, or the name of one of the robot's parameters.
void read_mass(const YamlReader& reader, const NamedNumbers& parameters, PayloadSpec& payload) {
  const std::string& text = reader.node().text;
  const bool is_parameter =
      reader.is_scalar() && std::ranges::any_of(parameters, [&](const auto& parameter) {
        return parameter.first.value == text;
      });
  if (is_parameter)
    payload.mass_parameter = Name{text, reader.place()};
  else
    payload.mass = reader.number(kPositive).value_or(0);
}

OrderedJson expand_mass(const PayloadSpec& payload) {
  return payload.mass_parameter ? OrderedJson(payload.mass_parameter->value)
                                : OrderedJson(payload.mass);
}

/// True if a state has more than the position of base and joints.
bool says_more_than_a_posture(const StateSpec& state) {
  return state.configuration || !state.robots.empty() || state.state || !state.values.empty() ||
         state.displaced || state.base_velocity || !state.joint_velocities.empty();
}

/// A named state that has base and joints only.
struct Configuration {
  StateSpec state;
};

}  // namespace

/// kg m²; the six entries as in URDF, off-diagonal entries zero by default.
static void describe(Keys& keys, Symmetric3<double>& inertia) {
  keys.about({.title = "Inertia", .examples = R"([{"ixx": 0.01, "iyy": 0.01, "izz": 0.02}])"});
  for (const auto& [name, value] :
       {std::pair{"ixx", &inertia.xx}, {"iyy", &inertia.yy}, {"izz", &inertia.zz}})
    keys({.name = name, .says = "Moment of inertia, kg m²", .required = true}, *value,
         NumberForm{kNotNegative});
  for (const auto& [name, value] :
       {std::pair{"ixy", &inertia.xy}, {"ixz", &inertia.xz}, {"iyz", &inertia.yz}})
    keys({name, "Product of inertia, kg m²"}, *value, NumberForm{});
}

static void describe(Keys& keys, PayloadOfRobot& own) {
  PayloadSpec& payload = own.payload;
  keys.about({.definition = "payload",
              .title = "Payload carried rigidly by a link",
              .says = "A body that a link carries",
              .examples = R"([{"mass": 10, "com": [0, 0, 0.1]}])"});
  keys({.name = "mass",
        .says = "Mass, kg; =load, a free parameter, lets the solver choose it",
        .required = true},
       CustomValue{[&](const YamlReader& reader) { read_mass(reader, own.parameters, payload); },
                   [&] { return expand_mass(payload); },
                   R"({"type": ["number", "string"], "exclusiveMinimum": 0,
                       "pattern": "^=|^[A-Za-z_][A-Za-z0-9_]*$"})"});
  keys({"com", "Center of mass in the link's frame, m"}, payload.com, VectorForm{"[x, y, z] in m"});
  keys({"inertia", "About the center of mass in the link's axes; a point mass by default"},
       payload.inertia, MapForm{});
}

static void describe(Keys& keys, PassiveSpec& passive) {
  keys.about(
      {.title = "Passive joint forces", .examples = R"([{"damping": "urdf", "friction": "urdf",
                               "friction_velocity": 0.05}])"});
  keys({"damping", "Joint damping as the URDF states it"}, passive.damping,
       WordForm{kPassiveWords, "source of damping"});
  keys({"friction",
        "Joint friction as the URDF states it, smoothed: -friction·tanh(v / friction_velocity)"},
       passive.friction, WordForm{kPassiveWords, "source of friction"});
  keys({"friction_velocity", "Width of the smoothing, rad/s or m/s"}, passive.friction_velocity,
       NumberForm{kPositive});
}

void describe(Keys& keys, WrenchSpec& wrench) {
  keys.about(
      {.title = "External wrench", .examples = R"([{"frame": "tool", "force": [0, 0, -20]}])"});
  keys({.name = "frame", .says = "At whose origin it acts", .required = true}, wrench.frame,
       NameForm{});
  keys({"force", "Force in world axes, N"}, wrench.wrench.linear, VectorForm{"[x, y, z] in N"});
  keys({"torque", "Torque in world axes, Nm"}, wrench.wrench.angular,
       VectorForm{"[x, y, z] in Nm"});
}

static void describe(Keys& keys, Configuration& configuration) {
  keys.about({.definition = "configuration",
              .title = "Configuration",
              .says = "What is not mentioned is zero.",
              .examples = R"([{"base": {"position": [0, 0, 0.57]}, "joints": {"knee": -1.5}}])"});
  keys({"base"}, configuration.state.base, MapForm{});
  describe_posture(keys, configuration.state);
}

namespace {

/// Named configurations. Other keys of states are read for their messages.
struct ConfigurationsForm {
  using Configurations = std::vector<std::pair<Name, StateSpec>>;
  bool read(const YamlReader& reader, Configurations& configurations) const {
    const auto entries = reader.named_entries();
    if (!entries) return false;
    for (const auto& [name, value] : *entries) {
      auto state = read_state(value);
      if (!state) continue;
      if (name.value == "initial")
        value.diagnostics().error(name.place, "'initial' means the initial state",
                                  "choose another name for the configuration");
      if (says_more_than_a_posture(*state))
        value.error("a configuration has 'base', 'joints' and 'frames' only");
      configurations.emplace_back(name, std::move(*state));
    }
    return true;
  }
  std::optional<OrderedJson> expand(const Configurations& configurations) const {
    OrderedJson json = OrderedJson::object();
    for (const auto& [name, state] : configurations) json[name.value] = expand_map(state);
    return json;
  }
  OrderedJson schema(const Configurations& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {{"type", "object"}, {"additionalProperties", map_schema<Configuration>(definitions)}};
  }
};

struct PayloadsForm {
  const NamedNumbers& parameters;
  bool read(const YamlReader& reader, std::vector<PayloadSpec>& payloads) const {
    const auto entries = reader.named_entries();
    if (!entries) return false;
    for (const auto& [name, value] : *entries) {
      PayloadOfRobot own{payloads.emplace_back(), parameters};
      own.payload.link = name;
      read_map(value, own);
    }
    return true;
  }
  std::optional<OrderedJson> expand(std::vector<PayloadSpec> payloads) const {
    OrderedJson json = OrderedJson::object();
    for (PayloadSpec& payload : payloads)
      json[payload.link.value] = expand_map(PayloadOfRobot{payload, parameters});
    return json;
  }
  OrderedJson schema(std::vector<PayloadSpec> /*names the type*/,
                     SchemaDefinitions& definitions) const {
    PayloadSpec payload;
    PayloadOfRobot own{payload, parameters};
    KeySchema keys(definitions);
    describe(keys, own);
    return {{"type", "object"}, {"additionalProperties", keys.schema()}};
  }
};

/// The placement of a base that does not float, complete in expanded files.
std::optional<OrderedJson> expand_placement(const RobotSpec& robot) {
  if (robot.base == UrdfOptions::Base::floating) return std::nullopt;
  PoseSpec placement = robot.placement.value_or(PoseSpec{});
  if (!placement.position) placement.position = Vector3<double>::zero();
  if (!placement.orientation) placement.orientation = Quaternion<double>::identity();
  return expand_map(placement);
}

void read_placement(const YamlReader& reader, RobotSpec& robot) {
  if (!read_map(reader, robot.placement.emplace())) robot.placement.reset();
  if (robot.base == UrdfOptions::Base::floating)
    reader.error("a floating base has no placement", "its position is part of the initial state");
}

}  // namespace

void describe(Keys& keys, FrameSpec& frame) {
  keys.about({.definition = "frame",
              .title = "Frame",
              .says = "A frame besides those of the URDF file",
              .examples = R"([{"parent": "hand", "placement": {"position": [0, 0, 0.1]}}])"});
  keys({.name = "parent", .says = "Link that it is fixed to, or another frame", .required = true},
       frame.parent, NameForm{});
  keys({"placement", "Where it is in that link's or frame's axes"}, frame.placement, MapForm{});
}

void describe(Keys& keys, RobotSpec& robot) {
  keys.about({.definition = "robot",
              .title = "Robot from a URDF file",
              .says = "What moves: a robot as its URDF file describes it, and what is said about "
                      "it besides",
              .examples = R"([{"urdf": "robots/arm7.urdf",
                               "configurations": {"ready": {"joints": {"joint_2": 0.4}}}},
                              {"urdf": "robots/quadruped.urdf", "base": "floating"}])"});
  keys({.name = "urdf", .says = "URDF file, relative to the problem file", .required = true},
       robot.urdf, NameForm{});
  keys(
      {"srdf",
       "SRDF file, relative to the problem file: its group states become configurations, and pairs "
       "of links that it disables do not count as self-collisions"},
      robot.srdf, NameForm{});
  keys({"base", "Joint between the root link and the world"}, robot.base,
       WordForm{kBaseWords, "kind of base"});
  keys({.name = "placement",
        .says = "Where the root link of a fixed base (or the plane of a planar one) stands in the "
                "world",
        .fallback = R"({"position": [0, 0, 0], "orientation": [0, 0, 0, 1]})"},
       CustomValue{[&](const YamlReader& reader) { read_placement(reader, robot); },
                   [&] { return expand_placement(robot); }, R"({"$ref": "#/definitions/pose"})"});
  keys({.name = "configurations",
        .says = "Named configurations for initial states, references and keyframes",
        .fallback = "{}"},
       robot.configurations, ConfigurationsForm{});
  keys({"locked_joints",
        "Joints fixed at these positions, rad or m; names may have * for any letters"},
       robot.locked_joints, NamedNumbersForm{});
  keys({"parameters",
        "States that rest, by name, and where they start: masses of payloads may be their names. "
        "The reader writes free parameters here"},
       robot.parameters, NamedNumbersForm{});
  keys({.name = "payloads",
        .says = "Payloads by the name of the link that carries them",
        .fallback = "{}"},
       robot.payloads, PayloadsForm{robot.parameters});
  keys({.name = "frames",
        .says = "Frames besides those of the URDF file, by name",
        .examples = R"([{"grip": {"parent": "hand", "placement": {"position": [0, 0, 0.1]}}}])",
        .fallback = "{}"},
       robot.frames,
       EntriesForm<FrameSpec>{.name = &FrameSpec::name,
                              .hint = "write '{grip: {parent: hand, placement: {...}}}'"});
  keys({.name = "external_wrenches", .says = "Constant wrenches on the robot", .fallback = "[]"},
       robot.external_wrenches, MapsForm{});
  keys({"rotor_inertia",
        "Rotor inertia reflected to a joint, kg m² (kg for a prismatic joint); names may have * "
        "for any letters"},
       robot.rotor_inertia, NamedNumbersForm{kNotNegative});
  keys({"actuation"}, robot.actuation, ActuationForm{});
  keys({"passive", "Passive joint forces"}, robot.passive, MapForm{});
  keys({"mimic", "Whether mimic joints follow their leader; otherwise they are independent"},
       robot.enforce_mimic, WordForm{kMimicWords, "treatment of mimic joints"});
  keys({"inertias",
        "Links whose inertia is not physically valid (a principal moment that is negative or "
        "exceeds the sum of the others): as_given warns, and fails only where the robot's inertia "
        "matrix is not positive definite; strict fails"},
       robot.inertias, WordForm{kInertiasWords, "treatment of inertias"});
  YamlMap* map = keys.reading();
  if (map == nullptr) return;
  robot.path = map->reader().folder() / robot.urdf.value;
  if (robot.srdf) robot.srdf_path = map->reader().folder() / robot.srdf->value;
  if (robot.name.value.find_first_of("/,") != std::string::npos)
    map->reader().diagnostics().error(robot.name.place, "a robot's name has no '/' and no ','");
}

}  // namespace conddp
