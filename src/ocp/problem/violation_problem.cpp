#include "ocp/problem/violation_problem.hpp"

#include <algorithm>

namespace conddp {
namespace {

bool is_asked_for(const ConstraintTerm& term) {
  return term.softness == Softness::hard && !term.has_pairs();
}

std::shared_ptr<const KnotModel> of_violation(const KnotModel& of) {
  auto model = std::make_shared<KnotModel>(of.step());
  model->set_control_bounds(of.control_lower(), of.control_upper());
  for (const ConstraintTerm& term : of.constraints())
    if (is_asked_for(term))
      model->add_constraint(
          make_constraint(term.name, term.residual, term.kind, term.slope, Softness::l2));
  return model;
}

/// Appends a knot's parameters that the model of its violation uses.
void append_parameters(const KnotModel& model, const double* parameters,
                       std::vector<double>& list) {
  const auto append = [&](int first, int end) {
    list.insert(list.end(), parameters + first, parameters + end);
  };
  append(0, model.step().parameter_count());
  for (const ConstraintTerm& term : model.constraints()) {
    if (!is_asked_for(term)) continue;
    append(term.parameters, term.parameter_end());
    list.push_back(1);  // weight
  }
}

Phase of_violation(const Phase& phase) {
  Phase own{.name = phase.name,
            .model = of_violation(*phase.model),
            .dt = phase.dt,
            .cost_scale = std::vector<double>(phase.dt.size(), 1.0),
            .parameters = {},
            .instant = phase.instant};
  const int count = phase.model->parameter_count();
  for (int k = 0; k < phase.knots(); ++k)
    append_parameters(*phase.model, phase.parameters.data() + k * count, own.parameters);
  return own;
}

}  // namespace

ShootingProblem violation_problem(const ShootingProblem& problem) {
  std::vector<Phase> phases;
  std::ranges::transform(problem.phases(), std::back_inserter(phases),
                         [](const Phase& phase) { return of_violation(phase); });
  return ShootingProblem(problem.initial_state(), std::move(phases),
                         of_violation(problem.terminal()));
}

}  // namespace conddp
