#include "problem_file/expand/problem_summary.hpp"

#include <algorithm>

#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/model/system_fields.hpp"
#include "problem_file/values/activation_keys.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

OrderedJson column_list(const std::vector<Column>& columns) {
  OrderedJson list = OrderedJson::array();
  for (const Column& column : columns) list.push_back(column.name);
  return list;
}

OrderedJson robots_json(const ProblemSpec& spec, const BuiltProblem& built) {
  OrderedJson robots = OrderedJson::array();
  for (const PlantPart& part : built.plant.parts) {
    const RobotModel& model = built.plant.robot();
    int dof = 0;
    OrderedJson joints = OrderedJson::array();
    for (int i = part.first_joint; i < part.first_joint + part.joint_count; ++i) {
      if (!built.plant.multibody()->velocity_row(i)) continue;  // follows another joint
      dof += model.joints[i].nv();
      joints.push_back(model.joints[i].name);
    }
    robots.push_back({{"name", part.spec->name.value},
                      {"file", part.spec->path.string()},
                      {"base", word_of(kBaseWords, part.spec->base)},
                      {"degrees_of_freedom", dof},
                      {"joints", std::move(joints)}});
  }
  return spec.system ? OrderedJson::array() : robots;
}

/// Rows of the cost's residual, from a knot model that contains it; 0 if its weight is 0
/// everywhere.
int rows_of(const std::string& cost, const ShootingProblem& problem, bool terminal) {
  const auto find = [&](const KnotModel& model) {
    for (const CostTerm& term : model.costs())
      if (term.name == cost) return term.residual->size();
    return 0;
  };
  if (terminal) return find(*problem.terminal().model);
  for (const Phase& phase : problem.phases())
    if (const int rows = find(*phase.model); rows > 0) return rows;
  return 0;
}

/// The phases with a nonzero weight of the cost at some knot.
OrderedJson phases_of(const std::string& cost, const ShootingProblem& problem) {
  OrderedJson names = OrderedJson::array();
  for (const Phase& phase : problem.phases()) {
    const KnotModel& model = *phase.model;
    bool counts = false;
    for (const CostTerm& term : model.costs())
      for (int k = 0; k < phase.knots() && term.name == cost; ++k)
        counts |= phase.parameters[k * model.parameter_count() + term.weight] != 0;
    if (counts) names.push_back(phase.name);
  }
  return names;
}

/// An equation such as "y' = v", without the line breaks of its text.
std::string formula(std::string_view of, std::string_view text) {
  std::string line(of);
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\n' || c == '\t' || c == '\r';
    if (!blank)
      line += c;
    else if (!line.empty() && line.back() != ' ')
      line += ' ';
  }
  return line;
}

/// Adds the equations of a system, definitions first, each prefixed by `before`.
void add_formulas(const std::string& before, const SystemSpec& spec, OrderedJson& list) {
  const auto* system = std::get_if<ExpressionSystemSpec>(&spec.parameters);
  if (system == nullptr) return;
  const ExpressionSystemText& text = system->text;
  for (const NamedExpression& definition : text.definitions)
    list.push_back(formula(before + definition.name + " = ", definition.text));
  const char* sign = text.kind == SystemKind::discrete ? "⁺ = " : "' = ";
  for (const NamedExpression& equation : text.equations)
    list.push_back(formula(before + equation.name + sign, equation.text));
}

/// Equations of the systems, and of states at jumps.
OrderedJson formulas_of(const ProblemSpec& spec) {
  OrderedJson list = OrderedJson::array();
  for (const NamedSystemSpec& named : spec.systems)
    add_formulas(named.name.value + ": ", named.system, list);
  if (spec.system && spec.systems.empty()) add_formulas("", *spec.system, list);
  for (const PhaseSpec& phase : spec.phases)
    if (phase.jump)
      for (const auto& [name, expression] : phase.jump->states)
        list.push_back(formula(phase.name.value + ": " + name.value + "⁺ = ", expression.text));
  return list;
}

/// The rows of a residual given by expressions.
OrderedJson formulas_of(const CostSpec& cost) {
  OrderedJson list = OrderedJson::array();
  const auto* rows = cost.keys.find(key::expression_rows);
  for (std::size_t i = 0; rows != nullptr && i < rows->texts.size(); ++i)
    list.push_back(formula(rows->names.empty() ? "" : rows->names[i] + " = ", rows->texts[i].text));
  return list;
}

OrderedJson costs_json(const std::vector<CostSpec>& costs, const BuiltProblem& built,
                       bool terminal) {
  OrderedJson list = OrderedJson::array();
  for (const CostSpec& cost : costs) {
    OrderedJson entry = {{"name", cost.name.value},
                         {"residual", cost.residual.value},
                         {"rows", rows_of(cost.name.value, *built.problem, terminal)},
                         {"formulas", formulas_of(cost)},
                         {"activation", word_of(kActivationWords, cost.activation.kind)},
                         {"weight", cost.weight}};
    if (!terminal) entry["phases"] = phases_of(cost.name.value, *built.problem);
    list.push_back(std::move(entry));
  }
  if (terminal && built.terminal_lqr)
    list.push_back({{"name", kTerminalLqrName},
                    {"residual", "state"},
                    {"rows", rows_of(kTerminalLqrName, *built.problem, true)},
                    {"formulas", OrderedJson::array()},
                    {"activation", word_of(kActivationWords, ActivationKind::quadratic)},
                    {"weight", built.terminal_lqr->weight}});
  return list;
}

/// The set of a constraint: bounds on coordinates, or a set for a residual.
std::string_view set_of(const ConstraintSpec& c) {
  if (c.bounded) return "bounds";
  if (c.function.keys.value(key::cone)) return "cone";
  return c.at_least || c.at_most ? "norm" : "rows";
}

OrderedJson constraints_json(const ProblemSpec& spec, const BuiltProblem& built) {
  OrderedJson list = OrderedJson::array();
  const auto add = [&](const std::string& name, const std::string& on, OrderedJson formulas,
                       std::string_view set, bool terminal, bool from_urdf, Softness softness,
                       OrderedJson phases) {
    const bool dropped = std::any_of(built.dropped.begin(), built.dropped.end(),
                                     [&](const DroppedConstraint& d) { return d.name == name; });
    list.push_back({{"name", name},
                    {"on", on},
                    {"formulas", std::move(formulas)},
                    {"set", set},
                    {"terminal", terminal},
                    {"from_urdf", from_urdf},
                    {"phases", std::move(phases)},
                    {"soft", softness == Softness::hard ? "no" : word_of(kSoftWords, softness)},
                    {"dropped", dropped}});
  };
  for (const ConstraintSpec& bounds : spec.control_bounds)
    add(bounds.function.name.value, "control", OrderedJson::array(), "bounds", false,
        bounds.from_urdf.has_value(), Softness::hard,
        expand_phase_names(bounds.function.phases, spec));
  for (const bool terminal : {false, true})
    for (const ConstraintSpec& c : terminal ? spec.terminal_constraints : spec.constraints)
      add(c.function.name.value,
          c.bounded ? word_of(kBoundedWords, c.bounded->value) : c.function.residual.value,
          formulas_of(c.function), set_of(c), terminal, c.from_urdf.has_value(), c.softness,
          terminal ? OrderedJson::array() : expand_phase_names(c.function.phases, spec));
  if (built.terminal_lqr && built.terminal_lqr->constrained)
    add(kTerminalLqrName, "state", OrderedJson::array(), "norm", true, false, Softness::hard,
        OrderedJson::array());
  return list;
}

std::string_view phase_kind(const Phase& phase) {
  if (phase.model->system().kind() == SystemKind::impulse) return "impulse";
  if (phase.instant) return "choice";
  return phase.dt.front() > 0 ? "motion" : "jump";
}

/// The closed contacts of a phase.
OrderedJson contacts_of(const Phase& phase) {
  OrderedJson names = OrderedJson::array();
  if (const auto* system = phase.model->system().as_multibody())
    for (const Contact& contact : system->contacts().contacts()) names.push_back(contact.name);
  return names;
}

OrderedJson phases_json(const ProblemSpec& spec, const ShootingProblem& problem) {
  OrderedJson list = OrderedJson::array();
  for (std::size_t p = 0; p < problem.phases().size(); ++p) {
    const Phase& phase = problem.phases()[p];
    double duration = 0;
    for (const double dt : phase.dt) duration += phase.instant ? 0 : dt;
    const auto [shortest, longest] = std::minmax_element(phase.dt.begin(), phase.dt.end());
    const ContactRank rank = phase.model->system().contact_rank(problem.initial_state().data());
    list.push_back({{"name", phase.name},
                    {"kind", phase_kind(phase)},
                    {"contacts", contacts_of(phase)},
                    {"contact_rows", rank.rows},
                    {"contact_rank", rank.rank},
                    {"redundant_contacts", rank.redundant},
                    {"knots", phase.knots()},
                    {"dt_s", phase.instant ? 0 : *longest},
                    {"shortest_dt_s", phase.instant ? 0 : *shortest},
                    {"duration_s", duration}});
    if (const auto& system = spec.phases[p].system) list.back()["system"] = system->value;
  }
  return list;
}

/// All contact candidates with their counterparts.
OrderedJson candidates_json(const ProblemSpec& spec) {
  constexpr const char* kForms[] = {"half-space", "sphere", "box"};
  OrderedJson list = OrderedJson::array();
  for (const CandidateSpec& candidate : spec.candidates) {
    const TouchedSpec& touched = candidate.against;
    list.push_back({{"name", candidate.name.value},
                    {"frame", candidate.frame.value},
                    {"radius_m", candidate.radius},
                    {"against", kForms[touched.form.index()]},
                    {"of", touched.frame ? touched.frame->value : "world"},
                    {"friction", candidate.friction}});
  }
  return list;
}

std::string_view bounds_word(const SolverInfo& solver, const ShootingProblem& problem) {
  if (!problem.has_control_bounds()) return "none";
  return solver.control_bounds == BoundSupport::exact ? "kept" : "clipped";
}

OrderedJson loop_json(const BuiltMpc* loop) {
  if (loop == nullptr) return nullptr;
  const MpcOptions& controller = loop->controller;
  return {{"duration_s", loop->loop.duration},
          {"tick_s", controller.tick},
          {"horizon_s", controller.horizon},
          {"solver", controller.solver}};
}

}  // namespace

OrderedJson problem_summary(const BuiltProblem& built,
                            const std::vector<const SolverInfo*>& candidates,
                            const BuiltMpc* loop) {
  const ProblemSpec& spec = *built.problem_spec;
  const ShootingProblem& problem = *built.problem;
  const SolverInfo& solver = *candidates.front();
  OrderedJson then = OrderedJson::array();
  for (std::size_t i = 1; i < candidates.size(); ++i) then.push_back(candidates[i]->name);
  OrderedJson homotopy = OrderedJson::array();
  for (const HomotopyKeySpec& key : spec.solver.homotopy)
    homotopy.push_back({{"key", key.key.value}, {"from", key.from.value}, {"to", key.to.value}});
  // A knot that sets the initial state, or a jump, does not represent the others.
  int moving = 0;
  while (moving + 1 < problem.knots() && problem.takes_no_time(moving)) ++moving;
  const KnotModel& model = *problem.knot(moving).model;
  OrderedJson guess = {{"states", built.guess_used.states},
                       {"controls", built.guess_used.controls},
                       {"seed", nullptr}};
  if (built.guess_used.seed) guess["seed"] = *built.guess_used.seed;
  return {{"format", "conddp.check/1"},
          {"name", spec.name.value},
          {"file", spec.file.string()},
          {"robots", robots_json(spec, built)},
          {"system", spec.system ? OrderedJson(kSystemTypes[spec.system->parameters.index()].name)
                                 : OrderedJson(nullptr)},
          {"formulas", formulas_of(spec)},
          {"state",
           {{"numbers", problem.nx()},
            {"tangent", problem.ndx()},
            {"columns", column_list(built.state_columns)}}},
          {"control",
           {{"numbers", built.control_columns.size()},
            {"columns", column_list(built.control_columns)}}},
          {"integrator", word_of(kIntegratorWords, model.integrator())},
          {"knots", problem.knots()},
          {"duration_s", problem.times().back()},
          {"phases", phases_json(spec, problem)},
          {"contact_candidates", candidates_json(spec)},
          {"costs", costs_json(spec.costs, built, false)},
          {"terminal_costs", costs_json(spec.terminal_costs, built, true)},
          {"constraints", constraints_json(spec, built)},
          {"solver",
           {{"name", solver.name},
            {"description", solver.description},
            {"control_bounds", bounds_word(solver, problem)},
            {"then", std::move(then)},
            {"homotopy", std::move(homotopy)},
            {"restarts", spec.solver.options.restarts.count}}},
          {"initial_guess", std::move(guess)},
          {"mpc", loop_json(loop)}};
}

}  // namespace conddp
