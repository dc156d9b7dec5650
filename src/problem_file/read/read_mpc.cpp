#include <algorithm>
#include <iterator>

#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

constexpr int kMostIterations = 1'000'000;

/// A number of iterations, or the word that removes the limit.
struct IterationsForm {
  static constexpr Choice<bool> kWords[] = {{"tolerances", true}};
  bool read(const YamlReader& reader, MpcSpec& mpc) const {
    mpc.iterations_place = reader.place();
    mpc.iterations = 1;
    if (reader.is_number()) return IntegerForm{1, kMostIterations}.read(reader, *mpc.iterations);
    if (!reader.choice(kWords, "number of iterations")) return false;
    mpc.iterations.reset();
    return true;
  }
  std::optional<OrderedJson> expand(const MpcSpec& mpc) const {
    return mpc.iterations ? OrderedJson(*mpc.iterations) : OrderedJson("tolerances");
  }
  OrderedJson schema() const {
    return {{"anyOf", {IntegerForm{1, kMostIterations}.schema(), WordForm(kWords, "").schema()}}};
  }
};

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

/// Reads the numbers and words below a part of the plant: `robot: {urdf: heavy.urdf}` sets
/// `robot.urdf`.
void read_plant_part(const Name& part, const YamlReader& value, MpcPlantSpec& plant) {
  if (!value.is_map()) return plant.settings.push_back(make_setting(part, value.node()));
  if (const auto entries = value.named_entries())
    for (const auto& [key, below] : *entries)
      read_plant_part({part.value + '.' + key.value, key.place}, below, plant);
}

void read_set(const YamlReader& reader, MpcPlantSpec& plant) {
  const auto entries = reader.named_entries();
  if (!entries) return;
  for (const auto& [key, value] : *entries)
    // Below a path with dots, a mapping replaces the file's value.
    if (first_step(key.value) == key.value)
      read_plant_part(key, value, plant);
    else
      plant.settings.push_back(make_setting(key, value.node()));
}

OrderedJson expand_set(const MpcPlantSpec& plant) {
  OrderedJson json = OrderedJson::object();
  for (const Setting& setting : plant.settings)
    json[setting.key.value] = OrderedJson::parse(canonical_value(setting.value));
  return json;
}

void read_ground(const YamlReader& reader, MpcPlantSpec& plant) {
  plant.ground.clear();
  const auto items = reader.items();
  if (!items) return;
  for (const YamlReader& item : *items) {
    TouchedForm().read(item, plant.ground.emplace_back());
    if (plant.ground.back().frame)
      item.error("the ground stands in the world: it is not carried by a frame",
                 "leave 'frame' out");
  }
  if (items->empty()) reader.error("there is no ground", "write 'ground: [ground]'");
}

std::optional<OrderedJson> expand_ground(const MpcPlantSpec& plant) {
  if (!plant.simulated_contacts) return std::nullopt;
  OrderedJson json = OrderedJson::array();
  for (const TouchedSpec& shape : plant.ground) json.push_back(*TouchedForm().expand(shape));
  return json;
}

constexpr Choice<bool> kContactsOfPlantWords[] = {{"scheduled", false}, {"simulated", true}};

/// Checks the plant's settings and parts. Keys that belong below `set` are queried only if present,
/// so that messages do not list them as accepted.
void check_plant(YamlMap& map, const MpcPlantSpec& plant) {
  const bool simulated = plant.simulated_contacts.has_value();
  const auto contacts = map.find("contacts"), ground = map.find("ground");
  const bool scheduled = !contacts || contacts->node().text == "scheduled";
  if (ground && scheduled)
    ground->error("contacts of the phases have no ground", "write 'contacts: simulated' beside it");
  for (const std::string_view part : kPlantParts)
    if (part != "contacts" && map.reader().has(part))
      map.find(part)->error("what differs in the plant stands below 'set', by its path",
                            fmt::format("write 'set: {{{}.KEY: VALUE}}'", part));
  for (const Setting& setting : plant.settings)
    if (!is_of_plant(setting.key.value, simulated))
      map.reader().diagnostics().error(
          setting.key.place,
          "the plant may differ from the model only in its dynamics and actuators",
          "accepted: keys below system, systems, robot, robots, parameters, tables, gravity and "
          "contacts; friction of contacts only where they are simulated; bounds on the control "
          "below constraints");
}

}  // namespace

static void describe(Keys& keys, MpcPlantSpec& plant) {
  keys.about(
      {.title = "Plant", .examples = R"([{"set": {"system.pole_mass": 0.3}, "integrator": "rk4",
                               "dt": 0.001}])"});
  keys({.name = "set",
        .says = "Values of the dynamics and actuators that are others in the plant, by their "
                "paths, as --set takes them: below system, systems, robot, robots, parameters, "
                "tables, gravity and contacts; friction of contacts only where they are simulated; "
                "bounds on the control below constraints, to which the plant clips what it is told",
        .examples = R"([{"system.pole_mass": 0.3}])",
        .fallback = "{}"},
       CustomValue{[&](const YamlReader& reader) { read_set(reader, plant); },
                   [&] { return expand_set(plant); }, R"({"type": "object"})"});
  keys({"integrator", "How the plant is integrated; as the knots by default"}, plant.integrator,
       WordForm{kIntegratorWords, "integrator"});
  keys({.name = "dt",
        .says = "Longest step of the plant, s; a knot by default",
        .examples = "[0.001]"},
       plant.dt, NumberForm{kPositive});
  keys({.name = "contacts",
        .says = "Contacts of the plant; scheduled: those of the phases; simulated: they open, "
                "close and slip by themselves, by steps in time of length dt, which is needed "
                "then"},
       PlacedWord(kContactsOfPlantWords, "kind of contacts", plant.simulated_contacts));
  keys({.name = "ground",
        .says = "What the contacts of the file may touch where they are simulated, shapes in the "
                "world that the controller's model does not have; with a 'terrain' its boxes and "
                "half-spaces by default",
        .examples = R"([["ground", {"box": {"size": [0.4, 2, 0.04],
                                            "placement": {"position": [0.8, 0, 0]}}}]])",
        .fallback = R"(["ground"])"},
       CustomValue{
           [&](const YamlReader& reader) { read_ground(reader, plant); },
           [&] { return expand_ground(plant); },
           R"({"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/touched"}})"});
  if (YamlMap* map = keys.reading()) check_plant(*map, plant);
}

namespace {

void describe_jump(Keys& keys, DisturbanceSpec& disturbance) {
  keys.about({.title = "Jump", .examples = R"([{"at": 1.2, "jump": {"omega": 1}}])"});
  keys({.name = "at", .says = "When the state jumps, s", .required = true, .examples = "[1.2]"},
       disturbance.at, NumberForm{kNotNegative});
  keys({.name = "jump",
        .says = "By how much, in the units of the state's components; 0 of those without a number",
        .required = true,
        .examples = R"([{"omega": 1}])"},
       disturbance.jump, ComponentsForm{});
  if (const auto jump = keys.found("jump");
      jump && jump->is_map() && disturbance.jump && disturbance.jump->map.empty())
    jump->error("this jump changes nothing", "write '{omega: 0.5}'");
}

void describe_push(Keys& keys, DisturbanceSpec& disturbance) {
  WrenchSpec& push = disturbance.push.emplace(disturbance.push.value_or(WrenchSpec{}));
  keys.about({.title = "Push", .examples = R"([{"at": 1.2, "frame": "trunk", "force": [60, 0, 0],
                               "duration": 0.1}])"});
  keys({.name = "at", .says = "When the push begins, s", .required = true, .examples = "[1.2]"},
       disturbance.at, NumberForm{kNotNegative});
  if (YamlMap* map = keys.reading();
      map != nullptr && !map->reader().has("force") && !map->reader().has("torque"))
    keys.error(
        "a disturbance is a jump, a push, noise or lateness: this one has no 'jump', 'force', "
        "'torque', 'noise' or 'late'",
        "write '{at: 1, jump: {omega: 0.5}}' or '{at: 1, frame: tool, force: [0, "
        "10, 0], duration: 0.1}'");
  keys({.name = "frame",
        .says = "Frame that is pushed at its origin",
        .required = true,
        .examples = R"(["trunk"])"},
       push.frame, NameForm{});
  keys({.name = "force", .says = "In world axes, N", .examples = "[[60, 0, 0]]"},
       push.wrench.linear, VectorForm{"[x, y, z] in N"});
  keys({.name = "torque", .says = "In world axes, Nm", .examples = "[[0, 0, 5]]"},
       push.wrench.angular, VectorForm{"[x, y, z] in Nm"});
  keys({.name = "duration",
        .says = "How long the push lasts, s",
        .required = true,
        .examples = "[0.1]"},
       disturbance.duration, NumberForm{kPositive});
}

void describe_seed(Keys& keys, std::uint64_t& seed) {
  keys({"seed", "Which random numbers"}, seed, IntegerForm{0, kLargestSeed});
}

}  // namespace

static void describe(Keys& keys, NoiseSpec& noise) {
  static constexpr Choice<bool> kWords[] = {{"state", true}};
  keys.about({.title = "Noise", .examples = R"([{"noise": "state", "sigma": 0.002, "seed": 3}])"});
  bool of_state = true;
  keys({.name = "noise",
        .says = "Normal random numbers are added to each measured state",
        .required = true},
       of_state, WordForm{kWords, "quantity with noise"});
  keys({.name = "sigma",
        .says = "Standard deviation in the units of the state's components; 0 of those without a "
                "number",
        .required = true,
        .examples = "[0.002]"},
       noise.sigma, ComponentsForm{kNotNegative});
  describe_seed(keys, noise.seed);
}

static void describe(Keys& keys, LateSpec& late) {
  static constexpr NumberRange kShare{0, 1, false, false, "a number from 0 to 1"};
  keys.about(
      {.title = "Late answers", .examples = R"([{"late": 0.1, "seed": 3}, {"late": 1, "at": 1.2,
                                                         "duration": 0.06}])"});
  keys({.name = "late",
        .says = "Share of the ticks whose answers come too late, drawn at random, without unit; 1: "
                "all",
        .required = true,
        .examples = "[0.1]"},
       late.share, NumberForm{kShare});
  keys({"at", "From when on, s"}, late.at, NumberForm{kNotNegative});
  keys({.name = "duration",
        .says = "For how long, s; to the end of the loop by default",
        .examples = "[0.06]"},
       late.duration, NumberForm{kPositive});
  describe_seed(keys, late.seed);
}

namespace {

void read_disturbance(const YamlReader& reader, MpcSpec& mpc) {
  YamlMap map(reader, "write '{at: 1, jump: {omega: 0.5}}'");
  if (!map.valid()) return;
  KeyReader keys(map);
  const auto has = [&](const char* key) { return reader.node().find(key) != nullptr; };
  if (has("noise")) {
    if (mpc.noise) map.find("noise")->error("there is noise already: a loop has one");
    return describe(keys, mpc.noise.emplace());
  }
  if (has("late")) return describe(keys, mpc.late.emplace_back());
  DisturbanceSpec& disturbance = mpc.disturbances.emplace_back();
  disturbance.place = reader.place();
  map.find("jump") ? describe_jump(keys, disturbance) : describe_push(keys, disturbance);
}

/// Jumps, pushes, noise and late answers.
struct DisturbancesForm {
  bool read(const YamlReader& reader, MpcSpec& mpc) const {
    const auto items = reader.items();
    if (!items) return false;
    for (const YamlReader& item : *items) read_disturbance(item, mpc);
    return true;
  }
  std::optional<OrderedJson> expand(MpcSpec mpc) const {
    OrderedJson json = OrderedJson::array();
    for (DisturbanceSpec& disturbance : mpc.disturbances) {
      KeyWriter keys;
      disturbance.jump ? describe_jump(keys, disturbance) : describe_push(keys, disturbance);
      json.push_back(std::move(keys.json));
    }
    if (mpc.noise) json.push_back(expand_map(*mpc.noise));
    for (const LateSpec& late : mpc.late) json.push_back(expand_map(late));
    return json;
  }
  OrderedJson schema(const MpcSpec& /*names the type*/, SchemaDefinitions& definitions) const {
    DisturbanceSpec none;
    const GroupValue jump([&](Keys& keys) { describe_jump(keys, none); });
    const GroupValue push([&](Keys& keys) { describe_push(keys, none); });
    const OrderedJson kinds = {jump.schema(definitions), push.schema(definitions),
                               map_schema<NoiseSpec>(definitions),
                               map_schema<LateSpec>(definitions)};
    return {{"type", "array"}, {"items", {{"anyOf", kinds}}}};
  }
};

/// `{lqr: STATE}`.
GroupValue regulator(const char* title, std::string_view says,
                     std::optional<TerminalLqrSpec>& lqr) {
  return GroupValue([&lqr, title, says](Keys& keys) {
    keys.about({.title = title, .examples = R"([{"lqr": "standing"}])"});
    keys({.name = "lqr", .says = says, .required = true}, lqr, LqrForm{});
  });
}

/// A word, or the regulator at the end of windows.
struct WindowEndForm {
  bool read(const YamlReader& reader, MpcSpec& mpc) const {
    mpc.window_end.place = reader.place();
    if (!reader.is_map())
      return WordForm(kWindowEndWords, "end of windows").read(reader, mpc.window_end.value);
    own_regulator(mpc).read(reader);
    mpc.window_end.value = WindowEnd::kRegulator;
    return true;
  }
  std::optional<OrderedJson> expand(MpcSpec mpc) const {
    if (mpc.terminal_lqr) return own_regulator(mpc).expand();
    return OrderedJson(word_of(kWindowEndWords, mpc.window_end.value));
  }
  OrderedJson schema(MpcSpec mpc, SchemaDefinitions& definitions) const {
    return {{"anyOf",
             {WordForm(kWindowEndWords, "").schema(), own_regulator(mpc).schema(definitions)}}};
  }

 private:
  static GroupValue own_regulator(MpcSpec& mpc) {
    return regulator("Regulator at the end of windows", "As that of 'terminal'", mpc.terminal_lqr);
  }
};

/// The name of a state, a state, or `{lqr: STATE}`.
struct HeldStateForm {
  bool read(const YamlReader& reader, FallbackSpec& fallback) const {
    if (reader.is_scalar()) {
      fallback.name = reader.name();
    } else if (!reader.is_map() || reader.node().find("lqr") == nullptr) {
      if (auto state = read_state(reader)) fallback.to = std::move(*state);
    } else {
      own_regulator(fallback).read(reader);
      if (fallback.by_lqr && fallback.by_lqr->set)
        reader.diagnostics().error(fallback.by_lqr->set_place, "a fallback has no terminal set",
                                   "write 'to: {lqr: STATE}'");
    }
    return true;
  }
  std::optional<OrderedJson> expand(FallbackSpec fallback) const {
    if (fallback.by_lqr) return own_regulator(fallback).expand();
    return fallback.name ? OrderedJson(fallback.name->value) : expand_map(fallback.to);
  }
  OrderedJson schema(FallbackSpec fallback, SchemaDefinitions& definitions) const {
    return {{"anyOf",
             {{{"type", "string"}},
              map_schema<StateSpec>(definitions),
              own_regulator(fallback).schema(definitions)}}};
  }

 private:
  static GroupValue own_regulator(FallbackSpec& fallback) {
    return regulator("Regulator as fallback", "The equilibrium, without a set", fallback.by_lqr);
  }
};

/// Constraints by name, or a single unnamed constraint; its residual then becomes its name.
struct ConditionsForm : ConstraintsForm {
  ConditionsForm() : ConstraintsForm{.last_node = true} {}
  bool read(const YamlReader& reader, std::vector<ConstraintSpec>& conditions) const {
    if (!reader.is_map()) {
      reader.expected("a mapping from names to conditions",
                      "write '{fallen: {residual: state, columns: theta, upper: 4}}'");
      return false;
    }
    const YamlNode* residual = reader.node().find("residual");
    if (residual != nullptr && residual->kind == YamlNode::Kind::kScalar) {
      YamlNode named{.kind = YamlNode::Kind::kMap, .mark = reader.node().mark};
      named.entries.push_back({residual->text, residual->mark, reader.node()});
      return read(reader.at(named, reader.place().path), conditions);
    }
    ConstraintsForm::read(reader, conditions);
    for (const ConstraintSpec& condition : conditions)
      if (condition.softness != Softness::hard)
        reader.diagnostics().error(condition.function.name.place,
                                   "a condition that ends the loop is not soft",
                                   "leave out 'soft' and 'weight'");
    return true;
  }
  OrderedJson schema(const std::vector<ConstraintSpec>& value,
                     SchemaDefinitions& definitions) const {
    OrderedJson by_name = ConstraintsForm::schema(value, definitions);
    by_name.erase("type");
    const OrderedJson one = by_name["additionalProperties"];
    return {{"type", "object"}, {"anyOf", {one, std::move(by_name)}}};
  }
};

}  // namespace

static void describe(Keys& keys, RetimeSpec& retime) {
  keys.about({.title = "Re-timing", .examples = R"([{"early": 0.06, "late": 0.04}])"});
  keys({.name = "early",
        .says = "How much earlier than planned a phase may begin whose contacts are closed, s; "
                "less than the shortest swing lasts",
        .examples = "[0.06]"},
       retime.early, NumberForm{kNotNegative});
  keys({.name = "late",
        .says = "How much longer than planned a phase may last while contacts of the next one are "
                "open, s; 0, or a tick at least",
        .examples = "[0.04]"},
       retime.late, NumberForm{kNotNegative});
  const auto unset = [&](std::string_view key) {
    const auto r = keys.found(key);
    return !r || (r->is_number() && r->number().value_or(1) == 0);
  };
  if (unset("early") && unset("late"))
    keys.error("this moves no phase: 'early' and 'late' are 0",
               "write '{early: 0.06, late: 0.04}'");
}

static void describe(Keys& keys, FallbackSpec& fallback) {
  keys.about(
      {.title = "Fallback", .examples = R"([{"after": 3, "to": {"values": {"theta": 0}}}])"});
  keys({"after", "How many ticks in a row have to fail"}, fallback.after,
       IntegerForm{1, kMostIterations});
  keys({.name = "to",
        .says = "State at rest whose quasi-static controls are applied, or its name; with 'lqr' an "
                "equilibrium, with the regulator's gains, in a file with a gait where the robot is "
                "by then",
        .required = true},
       fallback, HeldStateForm{});
}

void describe(Keys& keys, MpcSpec& mpc) {
  keys.about({.definition = "mpc",
              .title = "Closed loop",
              .says = "Model predictive control in a closed loop, which conddp mpc simulates; no "
                      "other command reads more of it than its keys",
              .examples = R"([{"horizon": 1, "tick": 0.02, "duration": 5,
                               "feedback": {"rate": 500}}])"});
  keys({.name = "horizon",
        .says = "Length of the windows that are solved, s",
        .required = true,
        .examples = "[1]"},
       mpc.horizon, NumberForm{kPositive});
  keys({.name = "tick",
        .says = "Time from one plan to the next, s, at most the horizon; it need not be a multiple "
                "of dt",
        .required = true,
        .examples = "[0.02]"},
       mpc.tick, NumberForm{kPositive});
  keys({.name = "duration",
        .says = "Length of the simulation, s",
        .required = true,
        .examples = "[5]"},
       mpc.duration, NumberForm{kPositive});
  keys({"iterations",
        "Of the solver in each tick after the first one, from the predicted state; tolerances: as "
        "many as the tolerances of the solver take, from the measured state, which ipopt always "
        "does"},
       mpc, IterationsForm{});
  keys({"repeat",
        "What follows the end of the phases; hold: their last knot, again and again; none: "
        "nothing, and the last windows shrink; gait: the gait of the file gets as many cycles as "
        "the loop needs"},
       mpc.repeat, WordForm{kRepeatWords, "continuation of the phases"});
  keys({.name = "terminal",
        .says = "What counts at the last node of windows that end before the phases do: nothing, "
                "the file's 'terminal', or the cost-to-go of a regulator, whose state moves along "
                "the way of the file's gait",
        .fallback = R"("none")"},
       mpc, WindowEndForm{});
  keys({.name = "delay",
        .says = "Time from a measurement to the first control of its plan, s, at most the tick; "
                "the state is predicted over it",
        .examples = "[0.002]"},
       mpc.delay, NumberForm{kNotNegative});
  keys.removed("predict",
               "leave it out: plans begin at the state predicted for the end of the delay");
  keys({"feedback",
        "Corrects controls by the gains of the plan between ticks; without it they correct the "
        "first control of each plan alone"},
       GroupValue(
           [&](Keys& feedback) {
             feedback.about({.title = "Feedback between ticks", .examples = R"([{"rate": 1000}])"});
             feedback({.name = "rate",
                       .says = "How often the gains of the plan correct its control, 1/s",
                       .required = true,
                       .examples = "[1000]"},
                      mpc.feedback_rate, NumberForm{kPositive});
           },
           "write '{rate: 1000}'"));
  keys({.name = "plant",
        .says = "What is controlled; the model itself by default",
        .fallback = R"({"set": {}, "contacts": "scheduled"})"},
       mpc.plant, MapForm{"write '{dt: 0.001}'"});
  keys({.name = "disturbances",
        .says = "Jumps of the state, pushes on frames of robots, noise on what is measured, and "
                "answers that come too late",
        .examples = R"([[{"at": 1.2, "jump": {"omega": 1}},
                         {"noise": "state", "sigma": 0.002, "seed": 3}]])",
        .fallback = "[]"},
       mpc, DisturbancesForm{});
  keys({"commands",
        "Velocities at which the gait of the file is to go on from times on; the controller learns "
        "of each one at its time"},
       mpc.commands, CommandsForm{});
  keys({"swings",
        "Where the references of swings begin: at their footholds, or where the feet are when they "
        "lift off"},
       PlacedWord(kSwingStartWords, "begin of swings", mpc.measured_swings));
  keys({"retime",
        "Lets phases begin when the contacts of a simulated plant close; without it they begin at "
        "their times. One of both limits is above 0; something follows the phases ('repeat')"},
       mpc.retime, MapForm{"write '{early: 0.06, late: 0.04}'"});
  keys({"fallback",
        "What controls after several failed ticks in a row, until one succeeds; the former plan, "
        "shifted, by default"},
       mpc.fallback, MapForm{"write '{after: 3, to: {configuration: standing}}'"});
  keys({.name = "stop_when",
        .says = "Constraints on states by name, or one without a name: the loop ends where one of "
                "them does not hold, with exit status 1",
        .examples = R"([{"fallen": {"residual": "state", "columns": "theta", "lower": 2,
                                    "upper": 4}}])",
        .fallback = "{}"},
       mpc.stop_when, ConditionsForm{});
}

}  // namespace conddp
