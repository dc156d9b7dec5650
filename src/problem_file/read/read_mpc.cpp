#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

constexpr int kMostIterations = 1'000'000;
const NumberRange kShare{0, 1, false, false, "a number from 0 to 1"};

/// A positive number and its place.
std::optional<Located<double>> read_positive(const YamlReader& reader) {
  const auto number = reader.number(kPositive);
  return number ? std::optional(Located<double>{*number, reader.place()}) : std::nullopt;
}

/// Reads a required duration.
void require_duration(YamlMap& map, std::string_view key, Located<double>& value) {
  if (const auto r = map.require(key)) value = {r->number(kPositive).value_or(1), r->place()};
}

/// A number of iterations; empty for the word that removes the limit.
std::optional<int> read_iterations(const YamlReader& reader) {
  static constexpr Choice<bool> kWords[] = {{"tolerances", true}};
  if (reader.is_number()) return static_cast<int>(reader.integer(1, kMostIterations).value_or(1));
  if (reader.choice(kWords, "number of iterations")) return std::nullopt;
  return 1;
}

std::optional<Located<double>> read_feedback(const YamlReader& reader) {
  YamlMap map(reader, "write '{rate: 1000}'");
  const auto rate = map.require("rate");
  return rate ? read_positive(*rate) : std::nullopt;
}

/// Parts of a file that a plant may change.
constexpr std::string_view kPlantParts[] = {"system",  "systems",     "robot",
                                            "robots",  "parameters",  "tables",
                                            "gravity", "constraints", "contacts"};

/// True for keys that define the plant and not the objective. Control bounds among the constraints
/// are identified when the plant is built.
bool is_of_plant(const std::string& key, bool friction) {
  const std::string_view part = first_step(key);
  if (part == "constraints" && key == part) return false;
  if (part == "contacts" && (key == part || (!friction && key.ends_with(".friction"))))
    return false;
  return std::find(std::begin(kPlantParts), std::end(kPlantParts), part) != std::end(kPlantParts);
}

void read_plant_setting(const Name& key, const YamlReader& value, MpcPlantSpec& plant) {
  if (!is_of_plant(key.value, plant.simulated_contacts.has_value()))
    value.diagnostics().error(
        key.place, "the plant may differ from the model only in its dynamics and actuators",
        "accepted: keys below system, systems, robot, robots, parameters, tables, gravity and "
        "contacts; friction of contacts only where they are simulated; bounds on the control below "
        "constraints");
  else
    plant.settings.push_back(make_setting(key, value.node()));
}

/// Reads the numbers and words below a part of the plant: `robot: {urdf: heavy.urdf}` sets
/// `robot.urdf`.
void read_plant_part(const Name& part, const YamlReader& value, MpcPlantSpec& plant) {
  if (!value.is_map()) return read_plant_setting(part, value, plant);
  if (const auto entries = value.named_entries())
    for (const auto& [key, below] : *entries)
      read_plant_part({part.value + '.' + key.value, key.place}, below, plant);
}

/// `known`: the kind of contacts is known.
void read_ground(YamlMap& map, bool known, MpcPlantSpec& plant) {
  const auto r = map.find("ground");
  if (!r) return;
  if (known && !plant.simulated_contacts)
    r->error("contacts of the phases have no ground", "write 'contacts: simulated' beside it");
  plant.ground.clear();
  const auto items = r->items();
  if (!items) return;
  for (const YamlReader& item : *items) {
    plant.ground.push_back(read_touched(item));
    if (plant.ground.back().frame)
      item.error("the ground stands in the world: it is not carried by a frame",
                 "leave 'frame' out");
  }
  if (items->empty()) r->error("there is no ground", "write 'ground: [ground]'");
}

void read_plant_contacts(YamlMap& map, MpcPlantSpec& plant) {
  static constexpr Choice<bool> kWords[] = {{"scheduled", false}, {"simulated", true}};
  const auto r = map.find("contacts");
  const auto simulated = r ? r->choice(kWords, "kind of contacts") : std::optional(false);
  if (simulated.value_or(false)) plant.simulated_contacts = r->place();
  read_ground(map, simulated.has_value(), plant);
}

/// Reads parts of the file that stand directly in the plant, not below `set`. Other parts are
/// queried only if present, so that messages do not list them as accepted.
void read_plant_parts(YamlMap& map, MpcPlantSpec& plant) {
  for (const char* part : {"system", "robot"})
    if (const auto r = map.find(part)) {
      if (r->is_map())
        read_plant_part({part, r->place()}, *r, plant);
      else
        r->expected("a mapping of what differs in the plant");
    }
  for (const std::string_view part : kPlantParts)
    if (part != "system" && part != "robot" && part != "contacts" && map.valid() &&
        map.reader().node().find(part) != nullptr)
      map.find(part)->error("what differs in the plant stands below 'set', by its path",
                            fmt::format("write 'set: {{{}.KEY: VALUE}}'", part));
}

MpcPlantSpec read_mpc_plant(const YamlReader& reader) {
  MpcPlantSpec plant{.place = reader.place()};
  YamlMap map(reader, "write '{dt: 0.001}'");
  read_plant_parts(map, plant);
  read_plant_contacts(map, plant);
  for_each_entry(map, "set", [&](const Name& key, const YamlReader& value) {
    // Below a path with dots, a mapping replaces the file's value.
    if (first_step(key.value) == key.value)
      read_plant_part(key, value, plant);
    else
      read_plant_setting(key, value, plant);
  });
  if (const auto r = map.find("integrator"))
    if (const auto integrator = r->choice(kIntegratorWords, "integrator"))
      plant.integrator = {*integrator, r->place()};
  if (const auto r = map.find("dt")) plant.dt = read_positive(*r);
  return plant;
}

/// Reads random noise on the measurement.
NoiseSpec read_noise(YamlMap& map) {
  static constexpr Choice<bool> kWords[] = {{"state", true}};
  NoiseSpec noise;
  map.find("noise")->choice(kWords, "quantity with noise");
  if (const auto r = map.require("sigma"))
    noise.sigma = read_components(*r, kNotNegative).value_or(ComponentsSpec{});
  if (const auto r = map.find("seed"))
    noise.seed = static_cast<std::uint64_t>(r->integer(0, kLargestSeed).value_or(1));
  return noise;
}

/// Reads which ticks are late.
LateSpec read_late(YamlMap& map) {
  LateSpec late;
  if (const auto r = map.find("late")) late.share = r->number(kShare).value_or(1);
  if (const auto r = map.find("at")) late.at = {r->number(kNotNegative).value_or(0), r->place()};
  if (const auto r = map.find("duration")) late.duration = r->number(kPositive);
  if (const auto r = map.find("seed"))
    late.seed = static_cast<std::uint64_t>(r->integer(0, kLargestSeed).value_or(1));
  return late;
}

void read_push(YamlMap& map, DisturbanceSpec& disturbance) {
  disturbance.push.emplace();
  if (map.valid() && map.reader().node().find("force") == nullptr &&
      map.reader().node().find("torque") == nullptr)
    map.reader().error(
        "a disturbance is a jump, a push, noise or lateness: this one has no 'jump', 'force', "
        "'torque', 'noise' or 'late'",
        "write '{at: 1, jump: {omega: 0.5}}' or '{at: 1, frame: tool, force: [0, "
        "10, 0], duration: 0.1}'");
  if (const auto r = map.require("frame")) disturbance.push->frame = r->name().value_or(Name{});
  read_vector3(map, "force", "[x, y, z] in N", disturbance.push->wrench.linear);
  read_vector3(map, "torque", "[x, y, z] in Nm", disturbance.push->wrench.angular);
  if (const auto r = map.require("duration"))
    disturbance.duration = r->number(kPositive).value_or(1);
}

/// Reads the jump of the state.
std::optional<ComponentsSpec> read_displacement(const YamlReader& reader) {
  auto jump = read_components(reader);
  if (jump && jump->form == ComponentsSpec::Form::kMap && jump->map.empty())
    reader.error("this jump changes nothing", "write '{omega: 0.5}'");
  return jump;
}

void read_disturbance(const YamlReader& reader, MpcSpec& mpc) {
  YamlMap map(reader, "write '{at: 1, jump: {omega: 0.5}}'");
  if (!map.valid()) return;
  if (const auto noise =
          reader.node().find("noise") != nullptr ? map.find("noise") : std::nullopt) {
    if (mpc.noise) noise->error("there is noise already: a loop has one");
    mpc.noise = read_noise(map);
    return;
  }
  if (reader.node().find("late") != nullptr) {
    mpc.late.push_back(read_late(map));
    return;
  }
  DisturbanceSpec disturbance{.place = reader.place()};
  if (const auto r = map.require("at"))
    disturbance.at = {r->number(kNotNegative).value_or(0), r->place()};
  if (const auto jump = map.find("jump"))
    disturbance.jump = read_displacement(*jump);
  else
    read_push(map, disturbance);
  mpc.disturbances.push_back(std::move(disturbance));
}

void read_window_end(const YamlReader& reader, MpcSpec& mpc) {
  mpc.window_end.place = reader.place();
  if (!reader.is_map()) {
    mpc.window_end.value =
        reader.choice(kWindowEndWords, "end of windows").value_or(mpc.window_end.value);
    return;
  }
  YamlMap map(reader);
  if (const auto lqr = map.require("lqr")) mpc.terminal_lqr = read_terminal_lqr(*lqr);
  mpc.window_end.value = WindowEnd::kRegulator;
}

/// Reads the name of a state, a state, or `{lqr: STATE}`.
void read_held_state(const YamlReader& reader, FallbackSpec& fallback) {
  if (reader.is_scalar()) {
    fallback.name = reader.name();
    return;
  }
  if (!reader.is_map() || reader.node().find("lqr") == nullptr) {
    if (auto state = read_state(reader)) fallback.to = std::move(*state);
    return;
  }
  YamlMap map(reader);
  fallback.by_lqr = read_terminal_lqr(*map.require("lqr"));
  if (fallback.by_lqr->set)
    reader.diagnostics().error(fallback.by_lqr->set_place, "a fallback has no terminal set",
                               "write 'to: {lqr: STATE}'");
}

FallbackSpec read_fallback(const YamlReader& reader) {
  FallbackSpec fallback{.place = reader.place()};
  YamlMap map(reader, "write '{after: 3, to: {configuration: standing}}'");
  map.integer("after", fallback.after, 1, kMostIterations);
  if (const auto r = map.require("to")) read_held_state(*r, fallback);
  return fallback;
}

/// Reads constraints by name, or a single unnamed constraint; its residual then becomes its name.
std::vector<ConstraintSpec> read_conditions(const YamlReader& reader,
                                            const std::filesystem::path& folder) {
  if (!reader.is_map()) {
    reader.expected("a mapping from names to conditions",
                    "write '{fallen: {residual: state, columns: theta, upper: 4}}'");
    return {};
  }
  const YamlNode* residual = reader.node().find("residual");
  if (residual != nullptr && residual->kind == YamlNode::Kind::kScalar) {
    YamlNode named{.kind = YamlNode::Kind::kMap, .mark = reader.node().mark};
    named.entries.push_back({residual->text, residual->mark, reader.node()});
    return read_conditions(YamlReader(named, reader.place().path, reader.diagnostics()), folder);
  }
  ProblemSpec of_states;
  read_constraints(reader, folder, true, of_states);
  for (const ConstraintSpec& condition : of_states.terminal_constraints)
    if (condition.softness != Softness::hard)
      reader.diagnostics().error(condition.function.name.place,
                                 "a condition that ends the loop is not soft",
                                 "leave out 'soft' and 'weight'");
  return std::move(of_states.terminal_constraints);
}

RetimeSpec read_retime(const YamlReader& reader) {
  constexpr const char* kExample = "write '{early: 0.06, late: 0.04}'";
  RetimeSpec retime{.place = reader.place()};
  YamlMap map(reader, kExample);
  if (!map.valid()) return retime;
  const auto read = [&](const char* key, Located<double>& limit) {
    if (const auto r = map.find(key)) limit = {r->number(kNotNegative).value_or(1), r->place()};
  };
  read("early", retime.early);
  read("late", retime.late);
  if (retime.early.value == 0 && retime.late.value == 0)
    reader.error("this moves no phase: 'early' and 'late' are 0", kExample);
  return retime;
}

}  // namespace

MpcSpec read_mpc(const YamlReader& reader, const std::filesystem::path& folder,
                 const Name& solver) {
  MpcSpec mpc{.place = reader.place()};
  if (solver.value == "ipopt") mpc.iterations.reset();
  YamlMap map(reader, "write '{horizon: 1, tick: 0.02, duration: 5}'");
  if (!map.valid()) return mpc;
  require_duration(map, "horizon", mpc.horizon);
  require_duration(map, "tick", mpc.tick);
  require_duration(map, "duration", mpc.duration);
  if (const auto r = map.find("iterations")) {
    mpc.iterations = read_iterations(*r);
    mpc.iterations_place = r->place();
  }
  if (const auto r = map.find("repeat"))
    mpc.repeat = {r->choice(kRepeatWords, "continuation of the phases").value_or(mpc.repeat.value),
                  r->place()};
  if (const auto r = map.find("terminal")) read_window_end(*r, mpc);
  if (const auto r = map.find("delay"))
    mpc.delay = {r->number(kNotNegative).value_or(0), r->place()};
  static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
  map.choice("predict", mpc.predict, kWords, "value of 'predict'");
  if (const auto r = map.find("feedback")) mpc.feedback_rate = read_feedback(*r);
  map.read("plant", mpc.plant, read_mpc_plant);
  for_each_item(map, "disturbances", [&](const YamlReader& item) { read_disturbance(item, mpc); });
  mpc.commands = read_commands(map);
  if (const auto r = map.find("swings"))
    if (r->choice(kSwingStartWords, "begin of swings").value_or(false))
      mpc.measured_swings = r->place();
  if (const auto r = map.find("retime")) mpc.retime = read_retime(*r);
  if (const auto r = map.find("fallback")) mpc.fallback = read_fallback(*r);
  if (const auto r = map.find("stop_when")) mpc.stop_when = read_conditions(*r, folder);
  return mpc;
}

}  // namespace conddp
