#include "problem_file/expand/expand_problem.hpp"

#include <algorithm>
#include <cmath>

#include "problem_file/build/homotopy.hpp"
#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

void expand_plant(const ProblemSpec& spec, OrderedJson& json) {
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

OrderedJson expand_choice(const ChoiceSpec& choice) {
  if (choice.coordinates.form != ComponentsSpec::Form::kMap) return "all";
  if (choice.coordinates.map.empty()) return "none";
  OrderedJson names = OrderedJson::array();
  for (const auto& entry : choice.coordinates.map) names.push_back(entry.first.value);
  return names;
}

OrderedJson expand_phases(const ProblemSpec& spec) {
  OrderedJson json = OrderedJson::array();
  for (const PhaseSpec& phase : spec.phases) {
    OrderedJson entry = {{"name", phase.name.value}};
    if (phase.choice) {
      entry["choose"] = expand_choice(*phase.choice);
      if (phase.choice->lower) entry["lower"] = expand_components(*phase.choice->lower);
      if (phase.choice->upper) entry["upper"] = expand_components(*phase.choice->upper);
      json.push_back(std::move(entry));
      continue;
    }
    if (phase.restitution) {
      entry["impulse"] = expand_contact_names(phase.contacts, spec);
      entry["restitution"] = *phase.restitution;
    } else {
      entry["knots"] = phase.knots.value;
      entry["dt"] = phase.dt;
      if (phase.refine)
        entry["refine"] = {{"first", phase.refine->first},
                           {"last", phase.refine->last},
                           {"ratio", phase.refine->ratio}};
      if (phase.free_duration)
        entry["free_duration"] = {{"lower", phase.free_duration->lower},
                                  {"upper", phase.free_duration->upper}};
      if (!spec.contacts.empty()) entry["contacts"] = expand_contact_names(phase.contacts, spec);
    }
    entry["weights"] = expand_numbers(phase.weights);
    json.push_back(std::move(entry));
  }
  return json;
}

OrderedJson expand_initial_state(const ProblemSpec& spec, const KnotModel& model) {
  OrderedJson json = expand_state(spec.initial_state);
  if (model.has_control_memory() && !spec.initial_state.previous_control)
    json["previous_control"] = 0.0;
  return json;
}

OrderedJson expand_terminal(const ProblemSpec& spec, const Plant& plant) {
  OrderedJson json = OrderedJson::object();
  if (!spec.contacts.empty()) json["contacts"] = expand_contact_names(spec.last_contacts(), spec);
  json["costs"] = expand_costs(spec.terminal_costs, spec, plant, true);
  json["constraints"] = expand_terminal_constraints(spec, plant);
  return json;
}

/// That of the knots that take time.
Integrator integrator_of(const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k)
    if (!problem.takes_no_time(k)) return problem.knot(k).model->integrator();
  return default_integrator(problem.knot(0).model->system().kind());
}

OrderedJson expand_solver(const SolverSpec& solver) {
  OrderedJson json = {{"name", solver.name.value}};
  json.update(expand_options(solver.options));
  return json;
}

/// The numbers that differ between two problems of one shape, by their paths: what a homotopy moves
/// once defaults and gaits are filled in.
void add_moved(const std::string& path, const OrderedJson& from, const OrderedJson& to,
               OrderedJson& keys) {
  if (from.is_number() && to.is_number() && from != to)
    keys.push_back({{"key", path}, {"from", from}, {"to", to}});
  const std::string before = path.empty() ? "" : path + ".";
  if (from.is_object() && to.is_object()) {
    for (const auto& [name, part] : to.items())
      if (from.contains(name) && !(path.empty() && (name == "solver" || name == "initial_guess")))
        add_moved(before + name, from[name], part, keys);
  } else if (from.is_array() && to.is_array()) {
    for (std::size_t i = 0; i < std::min(from.size(), to.size()); ++i)
      add_moved(before + std::to_string(i), from[i], to[i], keys);
  }
}

std::string modeline(const std::string& text) {
  constexpr std::string_view kStart = "# yaml-language-server:";
  if (text.starts_with(kStart)) return text.substr(0, text.find_first_of("\r\n"));
  return std::string(kStart) + " $schema=../schemas/problem.schema.json";
}

}  // namespace

OrderedJson expand_options(const SolverOptions& options) {
  OrderedJson json = OrderedJson::object();
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
  const KnotModel& model = *built.problem->terminal().model;
  OrderedJson json = {{"conddp", kProblemFormat}, {"name", spec.name.value}};
  if (!spec.description.empty()) json["description"] = spec.description;
  json["parameters"] = expand_parameters(spec.names.parameters);
  json["tables"] = expand_tables(spec.names.tables);
  expand_plant(spec, json);
  json["initial_state"] = expand_initial_state(spec, model);
  json["integrator"] = word_of(kIntegratorWords, integrator_of(*built.problem));
  json["running_costs"] = word_of(kRunningCostsWords, spec.running_costs);
  if (!spec.contacts.empty()) json["contacts"] = expand_contacts(spec.contacts);
  if (!spec.system) json["collision"] = expand_collision(spec.collision);
  if (spec.stepping) {
    json["contact_candidates"] = expand_candidates(spec.candidates);
    json["stepping"] = expand_stepping(*spec.stepping);
  }
  json["phases"] = expand_phases(spec);
  json["costs"] = expand_costs(spec.costs, spec, built.plant, false);
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
  return json;
}

std::string expanded_text(const ProblemSpec& spec, const BuiltProblem& built) {
  return modeline(spec.text) + '\n' + yaml_text(expand_problem(spec, built));
}

}  // namespace conddp
