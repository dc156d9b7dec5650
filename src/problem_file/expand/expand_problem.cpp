#include "problem_file/expand/expand_problem.hpp"

#include <algorithm>
#include <cmath>

#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/lower/rewriting.hpp"
#include "problem_file/read/read_problem.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/terms/constraint_builder.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/yaml_text.hpp"

namespace conddp {
namespace {

/// All phases that take time, where none are named.
std::optional<std::vector<Name>> all_phases(const std::optional<std::vector<Name>>& named,
                                            const ProblemSpec& spec) {
  if (named) return named;
  std::vector<Name> all;
  for (const PhaseSpec& phase : spec.phases)
    if (!phase.takes_no_time()) all.push_back(phase.name);
  return all;
}

/// Sets defaults that depend on the problem: contacts, joints, phases, weights and sets of terms.
class Completion {
 public:
  Completion(const ProblemSpec& spec, const Plant& plant) : context_{spec, plant} {}

  void complete(ProblemSpec& spec) const {
    if (spec.first_use(&ResidualNeeds::previous_control) && !spec.initial_state.previous_control)
      spec.initial_state.previous_control = ComponentsSpec{.scalar = 0.0};
    if (!spec.contacts.empty() && !spec.phases.empty())
      spec.terminal_contacts = spec.named(spec.last_contacts());
    for (PhaseSpec& phase : spec.phases) phase.contacts = spec.named(phase.contacts);
    if (spec.mesh && spec.mesh->is_cut) spec.mesh->factor = 1;
    for (auto* costs : {&spec.costs, &spec.terminal_costs})
      for (CostSpec& cost : *costs) complete_cost(cost);
    for (CostSpec& integral : spec.integrals) complete_function(integral);
    for (ConstraintSpec& bounds : spec.control_bounds)
      bounds.function.phases = all_phases(bounds.function.phases, spec);
    for (auto* constraints : {&spec.constraints, &spec.terminal_constraints})
      for (ConstraintSpec& constraint : *constraints) complete_constraint(constraint);
    if (spec.mpc) complete_loop(*spec.mpc);
  }

 private:
  void complete_function(CostSpec& cost) const {
    complete_residual(cost, context_);
    // Knots alone may belong to phases that take no time; then the phases must not be named.
    if (!cost.where.last_node && !cost.knots) cost.phases = all_phases(cost.phases, context_.spec);
  }

  void complete_cost(CostSpec& cost) const {
    complete_function(cost);
    if (!cost.matrix && !cost.weights) cost.weights = ComponentsSpec{.scalar = 1.0};
  }

  void complete_constraint(ConstraintSpec& constraint) const {
    // Named phases of bounds exclude the last node, so the default is not written as all names.
    if (constraint.bounded) return;
    complete_function(constraint.function);
    if (!constraint.equals && !constraint.function.keys.value(key::cone) && is_zero(constraint))
      constraint.equals = ComponentsSpec{.scalar = 0.0};
  }

  /// Phases replace the gait in the expanded file: no cycles can be repeated.
  void complete_loop(MpcSpec& mpc) const {
    if (mpc.repeat.value == AfterTheEnd::kGait) mpc.repeat.value = AfterTheEnd::kHold;
    for (ConstraintSpec& condition : mpc.stop_when) complete_constraint(condition);
  }

  TermContext context_;
};

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

OrderedJson expand_phase_names(const std::optional<std::vector<Name>>& names,
                               const ProblemSpec& spec) {
  return *NamesForm().expand(*all_phases(names, spec));
}

OrderedJson expand_problem(const BuiltProblem& built) {
  ProblemSpec complete = *built.problem_spec;
  Completion(*built.problem_spec, built.plant).complete(complete);
  complete.integrator = {integrator_of(*built.problem), {}};
  OrderedJson json = expand_map(std::move(complete));
  json["solver"]["homotopy"] = OrderedJson::array();
  if (built.homotopy)
    add_moved("", expand_problem(built.homotopy->start()), json, json["solver"]["homotopy"]);
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
