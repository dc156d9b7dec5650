#include "problem_file/expand/expand_problem.hpp"

#include <algorithm>
#include <cmath>

#include "base/json/json_object.hpp"
#include "problem_file/build/homotopy.hpp"
#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/lower/rewriting.hpp"
#include "problem_file/read/read_problem.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_text.hpp"

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
      json["robot"] = expand_map(robot);
    else
      json["robots"][robot.name.value] = expand_map(robot);
  }
  json["gravity"] = expand_vector(spec.gravity);
}

OrderedJson expand_phases(const ProblemSpec& spec) {
  OrderedJson json = OrderedJson::array();
  for (PhaseSpec phase : spec.phases) {
    KeyWriter keys;
    describe(keys, phase, &spec);
    json.push_back(std::move(keys.json));
  }
  return json;
}

OrderedJson expand_initial_state(const ProblemSpec& spec) {
  OrderedJson json = expand_map(spec.initial_state);
  if (spec.first_use(&ResidualNeeds::previous_control) && !spec.initial_state.previous_control)
    json["previous_control"] = 0.0;
  return json;
}

OrderedJson expand_terminal(const ProblemSpec& spec, const Plant& plant) {
  OrderedJson json = OrderedJson::object();
  if (!spec.contacts.empty()) json["contacts"] = expand_contact_names(spec.last_contacts(), spec);
  if (spec.terminal_lqr) json["lqr"] = *LqrForm().expand(*spec.terminal_lqr);
  json["costs"] = expand_costs(spec.terminal_costs, spec, plant, true);
  json["constraints"] = expand_terminal_constraints(spec, plant);
  return json;
}

constexpr std::string_view kCore = "core";

/// The integrator of the first knot that takes time, or the default.
Integrator integrator_of(const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k)
    if (!problem.takes_no_time(k)) return problem.knot(k).model->integrator();
  return default_integrator(problem.knot(0).model->system().kind());
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

OrderedJson expand_options(const SolverOptions& options) { return expand_map(options); }

OrderedJson expand_problem(const BuiltProblem& built) {
  constexpr std::size_t kMostSections = 28;
  const ProblemSpec& spec = *built.problem_spec;
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
  if (auto contacts = ContactsForm().expand(spec.contacts)) json["contacts"] = *contacts;
  if (!spec.system) json["collision"] = expand_map(spec.collision);
  if (spec.stepping) {
    json["contact_candidates"] = *kCandidates.expand(spec.candidates);
    json["stepping"] = expand_map(*spec.stepping);
  }
  json["phases"] = expand_phases(spec);
  if (std::optional<MeshSpec> mesh = spec.mesh) {
    if (mesh->is_cut) mesh->factor = 1;
    json["mesh"] = expand_map(*mesh);
  }
  json["costs"] = expand_costs(spec.costs, spec, built.plant, false);
  for (const CostSpec& integral : spec.integrals) {
    OrderedJson& entry = json["integrals"][integral.name.value];
    entry = expand_residual_keys(integral, {spec, built.plant, {}});
    entry["phases"] = expand_phase_names(integral.phases, spec);
  }
  json["constraints"] = expand_constraints(spec, built.plant);
  json["terminal"] = expand_terminal(spec, built.plant);
  json["initial_guess"] =
      *GroupValue([guess = spec.guess](Keys& keys) mutable { describe(keys, guess, {}); }).expand();
  json["perturbation"] = expand_map(spec.perturbation);
  json["solver"] = expand_map(spec.solver);
  json["solver"]["homotopy"] = OrderedJson::array();
  if (built.homotopy)
    add_moved("", expand_problem(built.homotopy->start()), json, json["solver"]["homotopy"]);
  if (spec.mpc) json["mpc"] = expand_mpc(spec, built.plant);
  return json;
}

void warn_of_lost_gait(const BuiltProblem& built, Diagnostics& out) {
  const std::optional<MpcSpec>& mpc = built.facts().mpc;
  if (!mpc) return;
  const char* hint = "simulate the original file for it: an expanded file has phases, and no gait";
  if (mpc->repeat.value == AfterTheEnd::kGait)
    out.warning(mpc->repeat.place, "'repeat: gait' becomes 'repeat: hold' in the expanded file",
                hint);
  if (!mpc->commands.empty())
    out.warning(mpc->commands.front().place, "the expanded file has no 'mpc.commands'", hint);
}

std::vector<std::string> names_of_rewritings() {
  std::vector<std::string> names;
  for (const DocumentRewriting& rewriting : document_rewritings())
    names.emplace_back(rewriting.name);
  for (const SpecRewriting& rewriting : spec_rewritings()) names.emplace_back(rewriting.name);
  names.emplace_back(kCore);
  return names;
}

OrderedJson expand_after(std::string_view rewriting, const BuiltProblem& built) {
  const ProblemSpec& spec = *built.problem_spec;
  if (rewriting == kCore) return expand_core(built);
  if (rewriting == kWholeFile) return expand_problem(built);
  Diagnostics out;  // nothing new: the problem has been built
  for (const DocumentRewriting& own : document_rewritings())
    if (own.name == rewriting)
      return json_of(*rewritten_document(spec.text, spec.file, spec.settings, rewriting, out));
  BuiltProblem at_the_end = built;
  at_the_end.homotopy = nullptr;
  at_the_end.problem_spec = std::make_shared<const ProblemSpec>(
      *read_problem_text(spec.text, spec.file, spec.settings, out, {.last = rewriting}));
  return expand_problem(at_the_end);
}

std::string expanded_text(const BuiltProblem& built, std::string_view rewriting) {
  const OrderedJson problem = expand_after(rewriting, built);
  const bool is_file = problem.contains("conddp");
  return (is_file ? modeline(built.problem_spec->text) + '\n' : "") + yaml_text(problem);
}

}  // namespace conddp
