#include <algorithm>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/text/spelling.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

static void describe(Keys& keys, Perturbation& perturbation) {
  static constexpr NumberRange kSpread{0, kLargestSpread, false, false, "a number from 0 to 1e6"};
  keys.about({.definition = "perturbation",
              .title = "One of many random instances",
              .says = "Moves initial state and first trajectory by random numbers, as conddp bench "
                      "--perturb does",
              .examples = R"([{"initial_state": 0.1, "seed": 5}])"});
  keys({"initial_state",
        "The initial state moves by a tangent vector with entries of up to this, each in its own "
        "unit; references that name it stay"},
       perturbation.initial_state, NumberForm{kSpread});
  keys({"guess",
        "Standard deviation of normal numbers that are added to states and controls of the first "
        "trajectory, each in its own unit"},
       perturbation.guess, NumberForm{kSpread});
  keys({"seed", "Which instance: the one of conddp bench with the same seed"}, perturbation.seed,
       IntegerForm{0, kLargestSeed});
  // An expanded file always has a seed.
  if (const auto seed = keys.found("seed");
      seed && !perturbation.any() && perturbation.seed != Perturbation{}.seed)
    seed->diagnostics().warning(seed->place(), "the seed has no effect, as nothing is perturbed",
                                "write 'perturbation: {initial_state: 0.1, seed: 2}'");
}

namespace {

void read_format(const YamlReader& reader) {
  const auto version = reader.integer(1, 1'000'000);
  if (version && *version != kProblemFormat)
    reader.error(fmt::format("the file has format {}, and this version reads format {}", *version,
                             kProblemFormat));
}

/// The name of the problem, by default that of its file.
void describe_name(Keys& keys, ProblemSpec& spec) {
  keys({.name = "name",
        .says = "Name of the problem and of its output folder; by default the file's",
        .examples = R"(["cartpole_swingup"])"},
       CustomValue{[&](const YamlReader& reader) {
                     spec.name = reader.name().value_or(spec.name);
                     if (!names_folder(spec.name.value)) reader.error(kFolderNameRule);
                   },
                   [&] { return OrderedJson(spec.name.value); },
                   R"({"type": "string", "minLength": 1, "pattern": "^[^./\\\\][^/\\\\]*$"})"});
  if (!keys.found("name") && !names_folder(spec.name.value))
    keys.error(fmt::format("the problem has the name of its file, '{}', and {}", spec.name.value,
                           kFolderNameRule),
               "write 'name: ...'");
}

/// Constants, which are read before all formulas, and tables.
void describe_names(Keys& keys, ExpressionNamesSpec& names) {
  keys({.name = "parameters",
        .says = "Constants by name, numbers or vectors in any unit, for expressions, and '=2*mass' "
                "stands for a number of the file",
        .examples = R"([{"mass": 2, "weight": "=9.81*mass", "goal": [1, 0]},
                        {"mass": {"free": true, "lower": 1, "upper": 3}}])",
        .fallback = "{}"},
       names, ParametersForm{});
  const int errors = keys.errors();
  keys({.name = "tables", .says = "Functions by name, for all expressions", .fallback = "{}"},
       names.tables, TablesForm{});
  names.incomplete = keys.errors() > errors;
}

/// The only robot of a problem, which has no name.
struct RobotForm {
  bool read(const YamlReader& reader, std::vector<RobotSpec>& robots) const {
    return read_map(reader, robots.emplace_back(), "write '{urdf: robot.urdf}'");
  }
  std::optional<OrderedJson> expand(const std::vector<RobotSpec>& robots) const {
    return expand_map(robots.front());
  }
  OrderedJson schema(const std::vector<RobotSpec>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return map_schema<RobotSpec>(definitions);
  }
};

/// Systems by name. The problem's system is the first one, until phases are known.
struct SystemsForm {
  static constexpr std::string_view kHint = "write '{a: {states: ..., rate: ...}, b: {...}}'";
  SystemForm form;
  bool read(const YamlReader& reader, std::vector<NamedSystemSpec>& systems) const {
    const auto entries = reader.named_entries(kHint);
    if (!entries) return false;
    for (const auto& [name, value] : *entries) {
      systems.push_back({name, {}});
      form.read(value, systems.back().system);
    }
    if (entries->empty()) reader.error("there is no system", std::string(kHint));
    return true;
  }
  std::optional<OrderedJson> expand(const std::vector<NamedSystemSpec>& systems) const {
    OrderedJson json = OrderedJson::object();
    for (const NamedSystemSpec& named : systems)
      json[named.name.value] = *form.expand(named.system);
    return json;
  }
  OrderedJson schema(const std::vector<NamedSystemSpec>& /*names the type*/,
                     SchemaDefinitions& definitions) const {
    return {{"type", "object"},
            {"minProperties", 1},
            {"additionalProperties", form.schema({}, definitions)}};
  }
};

void check_plant(YamlMap& map, ProblemSpec& spec) {
  constexpr std::string_view kWays[] = {"robot", "robots", "system", "systems"};
  bool any = false;
  for (const std::string_view& one : kWays) {
    any |= map.find(one).has_value();
    for (const std::string_view* other = &one + 1; other != std::end(kWays); ++other)
      map.exclusive({one, *other});
  }
  if (!spec.systems.empty()) spec.system = spec.systems.front().system;
  if (!any && map.valid())
    map.reader().error("the file defines nothing that moves: give 'robot', 'robots' or 'system'");
  if (const auto gravity = map.find("gravity"); gravity && spec.system)
    gravity->error("a closed-form system has its gravity among its parameters");
}

/// The robots or systems that move.
void describe_plant(Keys& keys, ProblemSpec& spec) {
  const bool robot = spec.robots.size() == 1 && spec.robots.front().name.value.empty();
  keys({.name = "robot", .omitted = spec.system || !robot}, spec.robots, RobotForm{});
  keys(
      {.name = "robots",
       .says = "Several robots or objects in one problem, by name; their joints and frames are "
               "then called name/joint and name/frame",
       .omitted = spec.system || robot},
      spec.robots,
      EntriesForm<RobotSpec>{.name = &RobotSpec::name, .entry_hint = "write '{urdf: robot.urdf}'"});
  keys({.name = "system", .omitted = !spec.systems.empty()}, spec.system, SystemForm{spec.names});
  keys({.name = "systems",
        .says = "Several systems, by name: phases that take time say which of them moves",
        .examples = R"([{"burn": {"states": ["v"], "controls": ["u"], "rate": {"v": "u"}},
                         "coast": {"states": ["v"], "controls": ["u"], "rate": {"v": "-0.1*v"}}}])",
        .omitted = spec.systems.empty()},
       spec.systems, SystemsForm{{spec.names}});
  keys({.name = "gravity",
        .says = "Of robots, in the world, m/s²",
        .examples = "[[0, 0, -1.62]]",
        .omitted = spec.system.has_value()},
       spec.gravity, VectorForm{"[x, y, z] in m/s²"});
  if (YamlMap* map = keys.reading()) check_plant(*map, spec);
}

/// The initial state, the integrator and the course of controls and running costs.
void describe_motion(Keys& keys, ProblemSpec& spec) {
  keys({.name = "initial_state", .says = "Where the motion starts", .required = true},
       spec.initial_state, MapForm{kStateHint});
  keys({"integrator",
        "How a knot is carried to the next one; trapezoidal, hermite_simpson, radau3 and radau5 "
        "are implicit (collocation). By default semi_implicit_euler for systems with positions and "
        "velocities, rk4 for first-order ones, discrete for those that give the next state "
        "themselves."},
       spec.integrator, WordForm(kIntegratorWords, "integrator"));
  keys({"controls",
        "What controls are between knots: constant, or linear from each knot's beginning to that "
        "of the next one. Linear ones need an integrator that sees them change (rk3, rk4 or "
        "collocation); running costs then are integrated by the trapezoidal rule."},
       spec.controls, WordForm(kControlCourseWords, "course of the controls"));
  keys({"running_costs",
        "rate: running costs are multiplied by the time step; integrated: they are integrated over "
        "the step by the stages of the integrator; sum: they are added up as they are"},
       spec.running_costs, WordForm(kRunningCostsWords, "kind of running costs"));
}

/// Reports keys that only robots have.
void check_keys_of_robots(YamlMap& map) {
  constexpr std::pair<std::string_view, const char*> kOfRobots[] = {
      {"contacts", "a closed-form system has no frames that could touch the world"},
      {"loops", "a closed-form system has no frames that could be held together"},
      {"collision", "a closed-form system has no links that could carry shapes"},
      {"terrain", "a closed-form system has no feet that could stand on it"},
      {"contact_candidates", "a closed-form system has no frames that could touch anything"},
      {"stepping", "a closed-form system has no joints that could be stopped"},
      {"gait", "a closed-form system has no feet that could walk"}};
  for (const auto& [key, message] : kOfRobots)
    if (const auto reader = map.find(key)) reader->error(message);
}

/// Contacts, shapes, and candidates for contact-implicit steps.
void describe_surroundings(Keys& keys, ProblemSpec& spec) {
  keys({.name = "contacts",
        .says = "Frames that can touch the world, by name; 'defaults' is what they have in common",
        .examples = R"([{"defaults": {"friction": 0.6}, "LF": {"frame": "lf_foot"}}])"},
       spec.contacts, ContactsForm{});
  keys({.name = "loops",
        .says = "Frames that are always together, by name: they close loops of joints",
        .examples = R"([{"knee": {"frame": "rod_end", "to": "crank_pin"}}])"},
       spec.loops,
       EntriesForm<LoopSpec>{.name = &LoopSpec::name,
                             .hint = "write '{knee: {frame: rod_end, to: crank_pin}}'",
                             .may_be_missing = true});
  keys({.name = "collision",
        .says = "Shapes that must keep apart, for the residual 'distance'",
        .omitted = spec.system.has_value()},
       spec.collision, MapForm{});
  keys({.name = "terrain",
        .says = "Ground under footholds of gaits and swings, the highest of its pieces, by name",
        .examples = R"([{"ground": {"half_space": {}},
                         "step": {"box": {"size": [0.6, 2, 0.15],
                                          "placement": {"position": [0.8, 0, 0.075]}}}}])"},
       spec.terrain, EntriesForm{.name = &TerrainPieceSpec::name, .may_be_missing = true});
  if (YamlMap* map = keys.reading()) check_shape_names(spec, map->reader().diagnostics());
  if (const auto r = keys.found("contact_candidates"))
    spec.stepping = SteppingSpec{.place = r->place()};
  keys({.name = "contact_candidates",
        .says = "Points and spheres of the robot that may touch something at any time, by name; of "
                "ipopt",
        .examples = R"([{"toe": {"frame": "foot", "point": [0.1, 0, 0], "friction": 0.6}}])",
        .omitted = !spec.stepping},
       spec.candidates, EntriesForm<CandidateSpec>{&CandidateSpec::name});
  keys({"stepping"}, spec.stepping, MapForm{});
  YamlMap* map = keys.reading();
  if (map == nullptr || !spec.stepping) return;
  for (const std::string_view implicit : {"contact_candidates", "stepping"})
    for (const std::string_view planned : {"contacts", "loops", "gait"})
      map->exclusive({implicit, planned});
}

/// The system that a phase names; if the file has several, the name is required.
const NamedSystemSpec* find_system(const PhaseSpec& phase, const ProblemSpec& spec,
                                   Diagnostics& out) {
  std::vector<std::string> names;
  for (const NamedSystemSpec& system : spec.systems) names.push_back(system.name.value);
  if (!phase.system) {
    out.error(phase.name.place,
              fmt::format("the phase '{}' does not say which system moves", phase.name.value),
              "write 'system: " + names.front() + "'", names);
    return nullptr;
  }
  const auto found = std::find(names.begin(), names.end(), phase.system->value);
  if (found != names.end()) return &spec.systems[found - names.begin()];
  out.error(phase.system->place, fmt::format("unknown system '{}'", phase.system->value),
            name_hint(phase.system->value, names, "systems"), names);
  return nullptr;
}

/// Finds the systems of all phases that take time; the first one becomes the problem's system.
void settle_systems(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.system && spec.robots.empty()) return;  // the missing system has been reported
  bool first = true;
  for (const PhaseSpec& phase : spec.phases) {
    if (phase.jump && !spec.system)
      out.error(phase.jump->place, "jumps are for systems, not for robots",
                "write '- {impulse: [contacts]}'");
    if (spec.systems.empty() && phase.system)
      out.error(phase.system->place, "the file has no 'systems' of which a phase could have one");
    if (spec.systems.empty() || phase.takes_no_time()) continue;
    const NamedSystemSpec* system = find_system(phase, spec, out);
    if (system != nullptr && first) spec.system = system->system;
    first = false;
  }
}

/// True for phases that consist of a choice of the start alone.
bool is_choice(const YamlNode& phases) {
  return phases.items.size() == 1 && phases.items.front().find("choose") != nullptr;
}

/// The phases, and the gait that makes those after a choice of the start.
void describe_schedule(Keys& keys, ProblemSpec& spec) {
  YamlMap* map = keys.reading();
  if (const auto phases = keys.found("phases"); phases && !is_choice(phases->node()))
    map->exclusive({"phases", "gait"});
  keys({"gait"}, spec.gait, GaitForm{spec.contacts});
  const bool gait = spec.gait.has_value();
  keys({.name = "phases", .says = "In the order of time", .required = map != nullptr && !gait},
       spec.phases, PhasesForm{!spec.contacts.empty(), gait});
  if (map == nullptr) return;
  if (spec.system) check_keys_of_robots(*map);
  settle_systems(spec, map->reader().diagnostics());
}

/// Costs by name.
EntriesForm<CostSpec> costs_form(bool last_node) {
  return {.name = &CostSpec::name,
          .hint = "write '{effort: {residual: control}}'",
          .initial = {.where = {.last_node = last_node}},
          .entry_hint =
              "write '{residual: control}', or of an expression to be minimized as it is "
              "'{residual: expression, rows: u^2, activation: linear}'"};
}

void describe_terminal(Keys& keys, ProblemSpec& spec) {
  keys.about({.title = "Last node",
              .examples = R"([{"costs": {"goal": {"residual": "state", "weight": 100}}}])"});
  keys({.name = "contacts",
        .says = "Contacts that it holds, for its costs and for swings that touch down there; those "
                "of the last phase by default",
        .omitted = spec.contacts.empty()},
       spec.terminal_contacts, ContactNamesForm{});
  keys({"lqr",
        "Adds the cost-to-go of the linear-quadratic regulator about an equilibrium, from the "
        "running costs and the linearized motion of the last knot that takes time"},
       spec.terminal_lqr, LqrForm{});
  keys({.name = "costs",
        .says = "Costs on the last node by name; never multiplied by a time step",
        .fallback = "{}"},
       spec.terminal_costs, costs_form(true));
  keys({.name = "constraints",
        .says = "Constraints on the last node by name; bounds on the state stand among the others "
                "and hold there too",
        .fallback = "{}"},
       spec.terminal_constraints, ConstraintsForm{.last_node = true});
}

/// Prefix in outputs for names of the last node.
constexpr std::string_view kOfLastNode = "terminal/";

/// Outputs sum by name, so terms need distinct names.
void check_running_name(const Name& name, Diagnostics& out) {
  if (name.value.starts_with(kOfLastNode))
    out.error(name.place,
              fmt::format("in outputs, names '{}...' are reserved for entries under 'terminal'",
                          kOfLastNode),
              "give it another name");
}

/// The same for soft constraints, which outputs list among the costs.
void check_soft_names(const std::vector<ConstraintSpec>& constraints,
                      const std::vector<CostSpec>& costs, Diagnostics& out) {
  for (const ConstraintSpec& constraint : constraints) {
    const Name& name = constraint.function.name;
    if (constraint.softness != Softness::hard &&
        std::ranges::any_of(costs, [&](const CostSpec& c) { return c.name.value == name.value; }))
      out.error(name.place,
                fmt::format("a cost has the name '{}', too, and soft constraints count as costs",
                            name.value),
                "give one of them another name");
  }
}

void check_names(const ProblemSpec& spec, Diagnostics& out) {
  for (const CostSpec& cost : spec.costs) check_running_name(cost.name, out);
  for (const auto* constraints : {&spec.control_bounds, &spec.constraints})
    for (const ConstraintSpec& c : *constraints) check_running_name(c.function.name, out);
  check_soft_names(spec.constraints, spec.costs, out);
  check_soft_names(spec.terminal_constraints, spec.terminal_costs, out);
}

/// Hard bounds on the control, and the other constraints.
void describe_constraints(Keys& keys, ProblemSpec& spec) {
  std::vector<ConstraintSpec> all = spec.control_bounds;
  all.insert(all.end(), spec.constraints.begin(), spec.constraints.end());
  keys({.name = "constraints", .says = "Constraints by name", .fallback = "{}"}, all,
       ConstraintsForm{});
  if (keys.reading() == nullptr) return;
  for (ConstraintSpec& constraint : all)
    (constraint.bounds_controls() ? spec.control_bounds : spec.constraints)
        .push_back(std::move(constraint));
}

/// The costs and constraints.
void describe_terms(Keys& keys, ProblemSpec& spec) {
  keys({.name = "costs", .says = "Running costs by name", .fallback = "{}"}, spec.costs,
       costs_form(false));
  keys({.name = "integrals",
        .says = "Numbers of the state by name, which begin at 0 and grow by the time step times an "
                "expression",
        .examples = R"([{"energy": "u[elbow]*v[elbow]"}])"},
       spec.integrals, IntegralsForm{});
  describe_constraints(keys, spec);
  keys({.name = "terminal",
        .says = "The last node",
        .fallback = R"({"costs": {}, "constraints": {}})"},
       GroupValue([&](Keys& terminal) { describe_terminal(terminal, spec); }));
  if (YamlMap* map = keys.reading()) check_names(spec, map->reader().diagnostics());
}

}  // namespace

void describe(Keys& keys, ProblemSpec& spec) {
  keys.about({.title = "conddp problem file",
              .says = "An optimal-control problem: what moves, from where, for how long, what it "
                      "costs, what must hold. SI units and radians.",
              .examples = R"([{
                "conddp": 1, "name": "swing_up", "system": {"type": "pendulum"},
                "initial_state": {"values": {"theta": 0}},
                "phases": [{"knots": 100, "dt": 0.02}],
                "costs": {"effort": {"residual": "control", "weight": 0.01}},
                "terminal": {"costs": {"up": {"residual": "state", "weight": 100,
                  "reference": {"values": {"theta": 3.141592653589793}}}}}}])",
              .rules = R"(
                "anyOf": [{"required": ["phases"]}, {"required": ["gait"]}],
                "oneOf": [{"required": ["robot"]}, {"required": ["robots"]},
                          {"required": ["system"]}, {"required": ["systems"]}])"});
  keys({.name = "conddp", .says = "This version reads format 1.", .required = true},
       CustomValue{read_format, [] { return OrderedJson(kProblemFormat); },
                   R"({"const": 1, "title": "Format of the file"})"});
  describe_name(keys, spec);
  keys({"description", "For people"},
       CustomValue{[&](const YamlReader& reader) {
                     spec.description = reader.text().value_or(spec.description);
                   },
                   [&] {
                     return spec.description.empty() ? std::nullopt
                                                     : std::optional<OrderedJson>(spec.description);
                   },
                   R"({"type": "string", "minLength": 1})"});
  describe_names(keys, spec.names);
  describe_plant(keys, spec);
  describe_motion(keys, spec);
  describe_surroundings(keys, spec);
  describe_schedule(keys, spec);
  keys({"mesh"}, spec.mesh, MapForm{"write '{error: 1.0e-6}'"});
  describe_terms(keys, spec);
  keys({.name = "draw",
        .says = "Further things that reports draw, by name, beside robots and built-in systems; "
                "they have no effect on the motion"},
       spec.drawings,
       EntriesForm<DrawingSpec>{.name = &DrawingSpec::name,
                                .hint = "write '{car: {box: {size: [4, 2, 1]}, at: [x, y]}}'",
                                .may_be_missing = true});
  keys({"initial_guess"}, spec.guess, MapForm{});
  keys({"perturbation"}, spec.perturbation, MapForm{});
  keys({"solver"}, spec.solver, MapForm{"write '{name: box_fddp}'"});
  if (keys.found("mpc")) {
    spec.mpc.emplace();
    // Ipopt has no real-time iteration: it solves windows to its tolerances.
    if (spec.solver.name.value == "ipopt") spec.mpc->iterations.reset();
  }
  keys({"mpc"}, spec.mpc, MapForm{"write '{horizon: 1, tick: 0.02, duration: 5}'"});
  if (const auto mpc = keys.found("mpc")) stand_on_terrain(*mpc, spec);
}

}  // namespace conddp
