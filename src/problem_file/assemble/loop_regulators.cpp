#include "problem_file/assemble/loop_regulators.hpp"

#include <algorithm>

#include "problem_file/motion/planar_motion.hpp"

namespace conddp {
namespace {

/// State that the file names, at the start of the gait's path.
std::optional<std::vector<double>> named_state(const TerminalLqrSpec& lqr,
                                               const BuiltProblem& built, Diagnostics& out) {
  StateBuilder states(built.plant, out);
  const auto initial = built.problem->initial_state();
  states.set_initial({initial.begin(), initial.begin() + built.plant.system->nx()});
  return equilibrium_of(lqr, states);
}

/// True if a state moves with the gait: it has one movable base and does not specify a
/// displacement.
bool moves(const TerminalLqrSpec& lqr, const ProblemSpec& spec, const Plant& plant,
           std::vector<double> x) {
  return !spec.gait_way.empty() && plant.parts.size() == 1 && !lqr.state.displaced &&
         displace_base(plant, plant.parts.front(), {}, x);
}

bool turns(const ProblemSpec& spec) {
  const auto point_turns = [](const WayPoint& point) { return point.motion.yaw != 0; };
  const auto command_turns = [](const GaitCommand& command) { return command.turn != 0; };
  return std::ranges::any_of(spec.gait_way, point_turns) ||
         std::ranges::any_of(spec.mpc->commands, command_turns);
}

/// The problem with only a regulator's cost-to-go at its last node. Reports errors of the
/// regulator.
std::optional<BuiltProblem> with_regulator(const TerminalLqrSpec& lqr, const ProblemSpec& spec,
                                           const BuiltProblem& built, Diagnostics& out) {
  ProblemSpec alone = spec;
  alone.terminal_costs.clear();
  alone.terminal_constraints.clear();
  alone.terminal_lqr = lqr;
  alone.guess = {};
  Diagnostics own = out;  // avoids repeated reports
  auto problem = build_without_homotopy(alone, {.plant = &built.plant}, own);
  if (!own.has_errors()) return problem;
  out = own;
  return std::nullopt;
}

}  // namespace

std::optional<LoopRegulator> build_loop_regulator(const TerminalLqrSpec& lqr,
                                                  const ProblemSpec& spec,
                                                  const BuiltProblem& built, Diagnostics& out) {
  auto start = named_state(lqr, built, out);
  if (!start) return std::nullopt;
  const bool is_led = moves(lqr, spec, built.plant, *start);
  if (is_led && turns(spec) && built.plant.parts.front().spec->base == UrdfOptions::Base::planar) {
    out.error(lqr.name ? lqr.name->place : lqr.place,
              "the regulator of a planar base does not follow a gait that turns",
              "give its state 'displaced: [0, 0, 0]', where it stays, or take a floating base");
    return std::nullopt;
  }
  TerminalLqrSpec at_end = lqr;
  if (is_led) at_end.moved = spec.gait_way.back().motion;
  const auto problem = with_regulator(at_end, spec, built, out);
  if (!problem) return std::nullopt;
  LoopRegulator regulator{problem->problem->terminal(), problem->terminal_lqr->ingredients, {}};
  if (!is_led) return regulator;
  // Augmented controls are those that hold the state.
  const std::vector<double>& x = regulator.ingredients.x;
  start->insert(start->end(), x.begin() + static_cast<std::ptrdiff_t>(start->size()), x.end());
  regulator.start = *std::move(start);
  return regulator;
}

std::shared_ptr<const StatePath> path_along(const std::vector<WayPoint>& way,
                                            const std::vector<double>& times,
                                            const std::vector<double>& start, const Plant& plant) {
  if (start.empty()) return nullptr;
  auto path = std::make_shared<StatePath>();
  for (const auto& [node, motion] : way) {
    path->times.push_back(times[node]);
    path->states.push_back(start);
    displace_base(plant, plant.parts.front(), motion, path->states.back());
  }
  return path;
}

}  // namespace conddp
