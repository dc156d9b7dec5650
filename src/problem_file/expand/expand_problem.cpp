#include "problem_file/expand/expand_problem.hpp"

#include <algorithm>
#include <cmath>

#include "base/json/json_object.hpp"
#include "problem_file/build/homotopy.hpp"
#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

void expand_plant(const ProblemSpec& spec, OrderedJson& json) {
  if (!spec.systems.empty()) {
    for (const NamedSystemSpec& named : spec.systems)
      json["systems"][named.name.value] = expand_system(named.system);
    return;
  }
  if (spec.system) {
    json["system"] = expand_system(*spec.system);
    return;
  }
  for (const RobotSpec& robot : spec.robots) {
    if (robot.name.value.empty())
      json["robot"] = expand_robot(robot);
    else
      json["robots"][robot.name.value] = expand_robot(robot);
  }
  json["gravity"] = expand_vector(spec.gravity);
}

OrderedJson expand_coordinates(const ComponentsSpec& coordinates) {
  if (coordinates.form != ComponentsSpec::Form::kMap) return "all";
  if (coordinates.map.empty()) return "none";
  OrderedJson names = OrderedJson::array();
  for (const auto& entry : coordinates.map) names.push_back(entry.first.value);
  return names;
}

void expand_choice(const ChoiceSpec& choice, OrderedJson& json) {
  json["choose"] = expand_coordinates(choice.coordinates);
  if (choice.lower) json["lower"] = expand_components(*choice.lower);
  if (choice.upper) json["upper"] = expand_components(*choice.upper);
}

OrderedJson expand_jump(const JumpSpec& jump) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, expression] : jump.states) json[name.value] = expression.text;
  return json;
}

/// A phase that takes time.
void expand_knots(const PhaseSpec& phase, const ProblemSpec& spec, OrderedJson& json) {
  if (phase.system) json["system"] = phase.system->value;
  json["knots"] = phase.knots.value;
  json["dt"] = phase.dt;
  if (phase.refine)
    json["refine"] = {{"first", phase.refine->first},
                      {"last", phase.refine->last},
                      {"ratio", phase.refine->ratio}};
  if (phase.free_duration)
    json["free_duration"] = {{"lower", phase.free_duration->lower},
                             {"upper", phase.free_duration->upper}};
  if (!spec.contacts.empty()) json["contacts"] = expand_contact_names(phase.contacts, spec);
}

OrderedJson expand_phases(const ProblemSpec& spec) {
  OrderedJson json = OrderedJson::array();
  for (const PhaseSpec& phase : spec.phases) {
    OrderedJson entry = {{"name", phase.name.value}};
    if (phase.choice) {
      expand_choice(*phase.choice, entry);
      json.push_back(std::move(entry));
      continue;
    }
    if (phase.jump) {
      entry["jump"] = expand_jump(*phase.jump);
    } else if (phase.restitution) {
      entry["impulse"] = expand_contact_names(phase.contacts, spec);
      entry["restitution"] = *phase.restitution;
    } else {
      expand_knots(phase, spec, entry);
    }
    entry["weights"] = expand_numbers(phase.weights);
    json.push_back(std::move(entry));
  }
  return json;
}

OrderedJson expand_initial_state(const ProblemSpec& spec) {
  OrderedJson json = expand_state(spec.initial_state);
  if (spec.first_use(&ResidualNeeds::previous_control) && !spec.initial_state.previous_control)
    json["previous_control"] = 0.0;
  return json;
}

}  // namespace

OrderedJson expand_terminal_lqr(const TerminalLqrSpec& lqr) {
  return {{"about", lqr.name ? OrderedJson(lqr.name->value) : expand_state(lqr.state)},
          {"weight", lqr.weight},
          {"set", lqr.set}};
}

namespace {

OrderedJson expand_terminal(const ProblemSpec& spec, const Plant& plant) {
  OrderedJson json = OrderedJson::object();
  if (!spec.contacts.empty()) json["contacts"] = expand_contact_names(spec.last_contacts(), spec);
  if (spec.terminal_lqr) json["lqr"] = expand_terminal_lqr(*spec.terminal_lqr);
  json["costs"] = expand_costs(spec.terminal_costs, spec, plant, true);
  json["constraints"] = expand_terminal_constraints(spec, plant);
  return json;
}

/// The integrator of the first knot that takes time, or the default.
Integrator integrator_of(const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k)
    if (!problem.takes_no_time(k)) return problem.knot(k).model->integrator();
  return default_integrator(problem.knot(0).model->system().kind());
}

OrderedJson expand_solver(const SolverSpec& solver) {
  const OrderedJson options = expand_options(solver.options);
  OrderedJson json = json_object(options.size() + 2);  // with the homotopy
  json["name"] = solver.name.value;
  json.update(options);
  return json;
}

/// A part by its name or its index; null if it does not exist.
const OrderedJson* part_of(const OrderedJson& json, const std::string& step) {
  if (json.is_array()) {
    const std::size_t index = std::stoul(step);
    return index < json.size() ? &json[index] : nullptr;
  }
  const auto found = json.find(step);
  return found != json.end() ? &*found : nullptr;
}

/// True for parts of a problem that a homotopy does not move.
bool is_apart(const std::string& path, const std::string& name) {
  return path.empty() && (name == "solver" || name == "initial_guess");
}

/// The numbers that differ between two problems of the same shape, by path. A homotopy moves these
/// once defaults and gaits are filled in.
void add_moved(const std::string& path, const OrderedJson& from, const OrderedJson& to,
               OrderedJson& keys) {
  if (from.is_number() && to.is_number() && from != to)
    keys.push_back({{"key", path}, {"from", from}, {"to", to}});
  if (from.type() != to.type() || !from.is_structured()) return;
  const std::string before = path.empty() ? "" : path + ".";
  for (const auto& [name, part] : to.items()) {
    const OrderedJson* former = part_of(from, name);
    if (former != nullptr && !is_apart(path, name)) add_moved(before + name, *former, part, keys);
  }
}

std::string modeline(const std::string& text) {
  constexpr std::string_view kStart = "# yaml-language-server:";
  if (text.starts_with(kStart)) return text.substr(0, text.find_first_of("\r\n"));
  return std::string(kStart) + " $schema=../schemas/problem.schema.json";
}

}  // namespace

OrderedJson expand_options(const SolverOptions& options) {
  OrderedJson json = json_object(option_table().size());
  for (const OptionInfo& info : option_table()) {
    OrderedJson value;
    std::visit([&](const auto& v) { value = v; }, info.get(options));
    if (value.is_number_float() && !std::isfinite(value.get<double>())) value = nullptr;
    const std::size_t dot = info.name.find('.');
    if (dot == std::string_view::npos)
      json[std::string(info.name)] = std::move(value);
    else
      json[std::string(info.name.substr(0, dot))][std::string(info.name.substr(dot + 1))] =
          std::move(value);
  }
  json["options"] = OrderedJson::object();
  for (const auto& [name, value] : options.ipopt)
    std::visit([&, key = name](const auto& v) { json["options"][key] = v; }, value);
  return json;
}

OrderedJson expand_problem(const ProblemSpec& spec, const BuiltProblem& built) {
  constexpr std::size_t kMostSections = 28;
  OrderedJson json = json_object(kMostSections);
  json["conddp"] = kProblemFormat;
  json["name"] = spec.name.value;
  if (!spec.description.empty()) json["description"] = spec.description;
  json["parameters"] = expand_parameters(spec.names.parameters);
  json["tables"] = expand_tables(spec.names.tables);
  expand_plant(spec, json);
  json["initial_state"] = expand_initial_state(spec);
  json["integrator"] = word_of(kIntegratorWords, integrator_of(*built.problem));
  json["controls"] = word_of(kControlCourseWords, spec.controls.value);
  json["running_costs"] = word_of(kRunningCostsWords, spec.running_costs.value);
  if (!spec.contacts.empty()) json["contacts"] = expand_contacts(spec.contacts);
  if (!spec.system) json["collision"] = expand_collision(spec.collision);
  if (spec.stepping) {
    json["contact_candidates"] = expand_candidates(spec.candidates);
    json["stepping"] = expand_stepping(*spec.stepping);
  }
  json["phases"] = expand_phases(spec);
  if (spec.mesh)  // its factor is already in the phases
    json["mesh"] = {{"error", spec.mesh->error},
                    {"factor", 1},
                    {"rounds", spec.mesh->rounds},
                    {"knots", spec.mesh->most_knots}};
  json["costs"] = expand_costs(spec.costs, spec, built.plant, false);
  for (const CostSpec& integral : spec.integrals) {
    OrderedJson& entry = json["integrals"][integral.name.value];
    entry = expand_residual_keys(integral, {spec, built.plant, {}});
    entry["phases"] = expand_phase_names(integral.phases, spec);
  }
  json["constraints"] = expand_constraints(spec, built.plant);
  json["terminal"] = expand_terminal(spec, built.plant);
  json["initial_guess"] = expand_guess(spec.guess);
  json["perturbation"] = {{"initial_state", spec.perturbation.initial_state},
                          {"guess", spec.perturbation.guess},
                          {"seed", spec.perturbation.seed}};
  json["solver"] = expand_solver(spec.solver);
  json["solver"]["homotopy"] = OrderedJson::array();
  if (built.homotopy) {
    const Homotopy::Station& start = built.homotopy->start();
    add_moved("", expand_problem(start.spec, *start.built), json, json["solver"]["homotopy"]);
  }
  if (spec.mpc) json["mpc"] = expand_mpc(spec, built.plant);
  return json;
}

void warn_of_lost_gait(const ProblemSpec& spec, Diagnostics& out) {
  if (!spec.mpc) return;
  const char* hint = "simulate the original file for it: an expanded file has phases, and no gait";
  if (spec.mpc->repeat.value == AfterTheEnd::kGait)
    out.warning(spec.mpc->repeat.place,
                "'repeat: gait' becomes 'repeat: hold' in the expanded file", hint);
  if (!spec.mpc->commands.empty())
    out.warning(spec.mpc->commands.front().place, "the expanded file has no 'mpc.commands'", hint);
}

std::string expanded_text(const ProblemSpec& spec, const BuiltProblem& built) {
  return modeline(spec.text) + '\n' + yaml_text(expand_problem(spec, built));
}

}  // namespace conddp
