#include "problem_file/yaml/synonyms.hpp"

#include <algorithm>

#include "base/text/spelling.hpp"

namespace conddp {
const std::vector<Synonyms>& synonyms() {
  static const std::vector<Synonyms> table = {
      {"lower", {"min", "minimum", "lb", "lower_bound", "low"}},
      {"at_least", {"min", "minimum", "min_distance", "lb"}},
      {"upper", {"max", "maximum", "ub", "upper_bound", "high"}},
      {"at_most", {"max", "maximum", "max_distance", "ub"}},
      {"equals", {"value", "eq", "equal_to"}},
      {"reference", {"target", "goal", "ref", "desired", "setpoint", "xref"}},
      {"weight", {"gain", "scale", "cost_weight"}},
      {"weights", {"gains", "diagonal", "Q", "R"}},
      {"columns", {"components", "indices", "dims", "coordinates"}},
      {"frame", {"link", "body", "end_effector", "ee"}},
      {"joints", {"q", "dofs", "positions"}},
      {"axes", {"reference_frame", "expressed_in"}},
      {"friction", {"mu", "friction_coefficient"}},
      {"urdf", {"file", "path", "model"}},
      {"robot", {"model"}},
      {"base", {"root", "root_joint", "floating_base"}},
      {"initial_state", {"x0", "start", "initial", "initial_condition"}},
      {"initial_guess", {"guess", "warm_start", "init", "initialization"}},
      {"terminal", {"final", "end", "terminal_costs", "terminal_constraints"}},
      {"costs", {"objective", "objectives", "cost", "cost_function", "minimize"}},
      {"constraints", {"limits", "bounds"}},
      {"phases", {"horizon", "knots", "duration", "stages", "schedule", "contact_sequence"}},
      {"knots", {"N", "nodes", "node", "steps", "at", "horizon"}},
      {"dt", {"h", "timestep", "time_step", "step_size"}},
      {"duration", {"T", "tf", "time", "final_time"}},
      {"free_duration", {"free_time", "free_final_time"}},
      {"solver", {"algorithm", "method", "optimizer"}},
      {"name", {"type", "algorithm", "method"}},
      {"max_iterations", {"iterations", "maxiter", "max_iter", "iteration_limit"}},
      {"max_time_s", {"time_limit", "timeout", "max_time"}},
      {"tolerances", {"tol", "eps", "precision"}},
      {"soft", {"slack", "relaxed", "penalty"}},
      {"keyframes", {"waypoints", "way_points", "via_points"}},
      {"actuation", {"actuators", "motors"}},
      {"rate",
       {"dynamics", "ode", "rhs", "f", "xdot", "x_dot", "derivative", "derivatives", "equations"}},
      {"states", {"x", "variables"}},
      {"controls", {"u", "inputs", "input"}},
      {"acceleration", {"acc", "qdd"}},
      {"next", {"step", "map", "update", "x_next"}},
      {"let", {"definitions", "define", "where", "with"}}};
  return table;
}

namespace {

std::string ask(const std::vector<std::string>& names) {
  std::string question;
  for (const std::string& name : names)
    question += (question.empty() ? "did you mean '" : " or '") + name + "'";
  return question.empty() ? question : question + "?";
}

}  // namespace

std::string meaning_question(std::string_view word, const std::vector<std::string>& accepted,
                             const std::vector<Synonyms>& more) {
  if (const auto near = similar_names(word, accepted); !near.empty()) return ask({near.front()});
  std::vector<std::string> meant;
  for (const auto* table : {&synonyms(), &more})
    for (const Synonyms& entry : *table) {
      if (std::find(entry.theirs.begin(), entry.theirs.end(), word) == entry.theirs.end()) continue;
      if (std::find(accepted.begin(), accepted.end(), entry.ours) == accepted.end()) continue;
      meant.emplace_back(entry.ours);
    }
  return ask(meant);
}

}  // namespace conddp
