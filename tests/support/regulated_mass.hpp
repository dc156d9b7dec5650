#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/terminal/terminal_ingredients.hpp"
#include "ocp/residuals/residuals.hpp"
#include "support/steps.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp::testing {

/// A mass moved by additive forces, exact over 0.1 s; `pull` opposes them.
inline std::shared_ptr<const System> pushed_mass(int forces, double pull = 0) {
  const Eigen::Matrix2d A{{1, 0.1}, {0, 1}};
  const Eigen::MatrixXd B = Eigen::Vector2d(0.005, 0.1).replicate(1, forces);
  return linear_system(A, B, -pull * Eigen::Vector2d(0.005, 0.1));
}

/// A constraint of a knot and its parameters: reference, bounds, switch, weight.
struct StageConstraint {
  ConstraintTerm term;
  std::vector<double> numbers;
};

/// Stage cost of a regulator: ½ (x − reference)ᵀ diag(state) (x − reference) + ½ effort ‖u‖² as a
/// rate.
struct StageCost {
  std::vector<double> reference, state;
  double effort = 0.1;
};

/// A knot of 0.1 s of a discrete system.
inline Phase stage_of(const std::shared_ptr<const System>& system, const StageCost& cost,
                      std::vector<double> lower, std::vector<double> upper,
                      std::vector<StageConstraint> constraints = {}, Memory memory = Memory::none) {
  const int nu = system->nu();
  const auto model = std::make_shared<KnotModel>(step_with(system, Integrator::discrete, memory));
  std::vector<int> states(system->nx());
  for (int i = 0; i < system->nx(); ++i) states[i] = i;
  model->add_cost("state", coordinate_residual(model->manifold(), states), {.weights = cost.state});
  model->add_cost("effort", control_residual(model->ndx(), nu), {});
  model->set_control_bounds(std::move(lower), std::move(upper));
  Phase phase{.name = "knot", .dt = {0.1}, .cost_scale = {0.1}};
  phase.parameters = cost.reference;  // references, then the weight of each cost
  phase.parameters.push_back(1);
  phase.parameters.resize(phase.parameters.size() + nu);
  phase.parameters.push_back(cost.effort);
  for (StageConstraint& constraint : constraints) {
    model->add_constraint(std::move(constraint.term));
    phase.parameters.insert(phase.parameters.end(), constraint.numbers.begin(),
                            constraint.numbers.end());
  }
  phase.model = model;
  return phase;
}

/// A knot of the mass with Q = I and R = 0.1 as rates.
inline Phase mass_stage(const std::shared_ptr<const System>& mass, std::vector<double> lower,
                        std::vector<double> upper, std::vector<StageConstraint> constraints = {}) {
  return stage_of(mass, {.reference = {0, 0}, .state = {1, 1}}, std::move(lower), std::move(upper),
                  std::move(constraints));
}

/// Regulator at the origin from zero controls. States are named x0, x1, and so on.
inline TerminalResult regulated(const Phase& phase, int knot = 0) {
  const KnotModel& model = *phase.model;
  std::vector<std::string> names;
  for (int i = 0; i < model.ndx(); ++i) names.push_back("x" + std::to_string(i));
  return find_terminal_ingredients(
      {phase, knot, std::vector<double>(model.nx(), 0.0), Eigen::VectorXd::Zero(model.nu())},
      names);
}

}  // namespace conddp::testing
