#include "problem_file/values/key_forms.hpp"

namespace conddp {
namespace {

void read_displacement(const YamlReader& reader, StateSpec& state) {
  DisplacementSpec& displacement = state.displaced.emplace();
  displacement.place = reader.place();
  if (reader.is_scalar() && reader.node().text == "gait")
    displacement.with_gait = true;
  else
    MotionForm().read(reader, displacement.motion);
}

/// Alternative notations of a state exclude each other.
void check_exclusive(YamlMap& map) {
  map.exclusive({"state", "values", "robots"});
  for (const std::string_view part : {"configuration", "base", "joints", "frames", "velocity"}) {
    map.exclusive({"state", part});
    map.exclusive({"values", part});
  }
}

/// The states of several robots, by their names.
struct RobotStatesForm : EntriesForm<NamedState> {
  RobotStatesForm() : EntriesForm{.name = &NamedState::name, .may_be_missing = true} {}
  bool read(const YamlReader& reader, std::vector<NamedState>& states) const {
    const auto entries = reader.named_entries();
    if (!entries) return false;
    for (const auto& [robot, value] : *entries)
      if (auto state = read_state(value)) states.push_back({robot, *std::move(state)});
    return true;
  }
};

}  // namespace

void describe_posture(Keys& keys, StateSpec& state) {
  keys({"joints", "Joint positions by name, rad or m"}, state.joints,
       NamedNumbersForm{.may_be_missing = true});
  keys({"frames",
        "Frames by name and where they are in the world. The joints that these need move within "
        "their limits, as little as possible from where the keys above put them; bases stay, loops "
        "close, and shapes of 'distance' keep apart"},
       state.frames,
       EntriesForm<PlacedFrame>{.name = &PlacedFrame::name,
                                .hint = "write '{hand: {position: [0.4, 0, 0.5]}}'",
                                .may_be_missing = true,
                                .entry_hint = "write '{position: [x, y, z], rpy: [r, p, y]}'"});
}

void describe(Keys& keys, StateSpec& state) {
  keys.about({.definition = "state",
              .title = "State",
              .says = "What is not mentioned is neutral: zero, no rotation, at rest.",
              .examples = R"([{"configuration": "standing"},
                              {"joints": {"knee": -1.5}, "velocity": {"joints": {"knee": 0.1}}},
                              {"configuration": "home", "frames": {"hand": {"position": [0.4, 0, 0.5]}}},
                              {"values": {"theta": 3.14}}])"});
  if (YamlMap* map = keys.reading()) check_exclusive(*map);
  keys(
      {"configuration", "Name of one of the robot's configurations, changed by the keys beside it"},
      state.configuration, NameForm{});
  keys({"base"}, state.base, MapForm{});
  keys({"displaced",
        "Displaces the base that the other keys have placed by [x, y, yaw], forward and to the "
        "left as it points (m) and turned (rad); gait, as the whole reference of a cost on the "
        "state: as the file's gait moves it"},
       CustomValue{[&state](const YamlReader& reader) { read_displacement(reader, state); },
                   [&state] {
                     return state.displaced ? MotionForm().expand(state.displaced->motion)
                                            : std::nullopt;
                   },
                   R"({"anyOf": [{"$ref": "#/definitions/planar_motion"}, {"const": "gait"}]})"});
  describe_posture(keys, state);
  keys({"velocity", "Zero where nothing is said"}, GroupValue([&state](Keys& velocity) {
         velocity.about({.title = "Velocity of a state", .examples = R"([{"joints": {"knee": 0.1}},
                                         {"base": {"linear": [1, 0, 0]}}])"});
         velocity({"base",
                   "Of a floating base in its own frame, of a planar one along x, y and about z"},
                  state.base_velocity, TwistForm{});
         velocity({"joints", "Joint velocities by name, rad/s or m/s"}, state.joint_velocities,
                  NamedNumbersForm{.may_be_missing = true});
       }));
  keys({"robots",
        "Several robots: the state of each by its name, with configuration, base, joints and "
        "velocity"},
       state.robots, RobotStatesForm{});
  keys({"state", "All numbers of the state in the order of its columns"}, state.state,
       NumbersForm{});
  keys({"values", "Numbers by column of the state, for example {x: 0, theta: 3.14}"}, state.values,
       NamedNumbersForm{.may_be_missing = true});
  keys({"previous_control",
        "The control before the first knot, of problems that use the control rate; zero by "
        "default"},
       state.previous_control, ComponentsForm{});
}

void describe(Keys& keys, NamedState& state) { describe(keys, state.state); }

void describe(Keys& keys, PlacedFrame& frame) {
  const int errors = keys.errors();
  describe(keys, frame.pose);
  if (keys.reading() != nullptr && keys.errors() == errors && !frame.pose.position &&
      !frame.pose.orientation)
    keys.error("a placed frame has a position, a rotation, or both");
}

std::optional<StateSpec> read_state(const YamlReader& reader) {
  StateSpec state;
  return read_map(reader, state, kStateHint) ? std::optional(std::move(state)) : std::nullopt;
}

}  // namespace conddp
