#include "support/constrained_problems.hpp"

namespace conddp::testing {
namespace {

void add_constraints(const std::vector<Added>& list, int first_node, Phase& phase) {
  const int last_node = first_node + phase.knots() - 1;
  auto model = std::make_shared<KnotModel>(*phase.model);
  const int before = phase.model->parameter_count();
  std::vector<const Added*> here;
  for (const Added& added : list) {
    if (added.first > last_node || added.last < first_node) continue;
    here.push_back(&added);
    model->add_constraint(
        make_constraint(added.name, added.residual, added.kind, added.slope, added.softness));
  }
  std::vector<double> parameters;
  for (int k = 0; k < phase.knots(); ++k) {
    const auto old = phase.parameters.begin() + k * before;
    parameters.insert(parameters.end(), old, old + before);
    for (const Added* added : here) {
      const int node = first_node + k;
      const bool on = added->first <= node && node <= added->last;
      const bool own = on && !added->references.empty();
      const auto& reference = own ? added->references[node - added->first] : added->reference;
      for (const auto* part : {&reference, &added->lower, &added->upper})
        parameters.insert(parameters.end(), part->begin(), part->end());
      parameters.push_back(on ? 1 : 0);
      if (added->softness != Softness::hard) parameters.push_back(added->weight);
    }
  }
  phase.model = std::move(model);
  phase.parameters = std::move(parameters);
}

}  // namespace

SolverOptions tight_options() {
  SolverOptions options;
  options.tolerances.stationarity = options.tolerances.constraint = 1e-9;
  options.max_iterations = 500;
  return options;
}

ShootingProblem with_constraints(const ShootingProblem& problem, const std::vector<Added>& list) {
  std::vector<Phase> phases = problem.phases();
  int first = 0;
  for (Phase& phase : phases) {
    add_constraints(list, first, phase);
    first += phase.knots();
  }
  Phase terminal = problem.terminal();
  add_constraints(list, problem.knots(), terminal);
  return ShootingProblem(problem.initial_state(), std::move(phases), std::move(terminal));
}

Added goal_constraint(const ShootingProblem& problem, std::vector<double> goal) {
  const std::vector<double> zero(problem.ndx(), 0.0);
  return {.name = "goal",
          .residual = state_residual(problem.manifold()),
          .reference = std::move(goal),
          .lower = zero,
          .upper = zero,
          .first = problem.knots(),
          .last = problem.knots()};
}

std::vector<PublishedCase> published_cases() {
  std::vector<PublishedCase> cases;
  const auto with_goal = [&](const std::string& name, const ShootingProblem& free,
                             std::vector<double> goal, double control, double cost,
                             std::vector<Added> others = {}) {
    others.push_back(goal_constraint(free, std::move(goal)));
    cases.push_back({name, with_constraints(free, others), control, cost});
  };
  const auto mass = tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                     {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  with_goal("double integrator", mass, {1, 0}, 0, 0.744087,
            {{.name = "speed",
              .residual = coordinate_residual(mass.manifold(), {1}),
              .reference = {0},
              .lower = {-0.6},
              .upper = {0.6},
              .first = 1,
              .last = 20}});
  with_goal("pendulum",
            tracking_problem(pendulum({}), Integrator::rk4, 50, 0.06, {0, 0},
                             {{M_PI, 0}, {1e-3, 1e-3}, {1e-3}, {1, 1}}, -3, 3),
            {M_PI, 0}, 0.1, 0.018405);
  with_goal("cart-pole", cartpole_swing_up(3, Integrator::rk3), {0, M_PI, 0, 0}, 0.01, 1.495874);
  const TrackingCost effort{{3, 3, 0}, {1, 1, 1}, {0.5, 0.5}, {10, 10, 10}};
  Phase ride = tracking_phase(unicycle(), Integrator::rk4, 100, 0.05, effort, -3, 3);
  auto forward = std::make_shared<KnotModel>(*ride.model);
  forward->set_control_bounds({0, -3}, {3, 3});
  ride.model = std::move(forward);
  const ShootingProblem drive({0, 0, 0}, {std::move(ride)}, terminal_phase(unicycle(), effort));
  std::vector<Added> discs;
  for (const double at : {0.75, 1.5, 2.25})
    discs.push_back({.name = "disc " + std::to_string(discs.size()),
                     .residual = coordinate_residual(drive.manifold(), {0, 1}),
                     .kind = ConstraintKind::norm,
                     .reference = {at, at},
                     .lower = {0.425},
                     .upper = {kFree},
                     .first = 1,
                     .last = 99});
  with_goal("three obstacles", drive, {3, 3, 0}, 0.01, 9.43375, discs);
  return cases;
}

}  // namespace conddp::testing
