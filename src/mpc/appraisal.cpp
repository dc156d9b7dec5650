#include "mpc/appraisal.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace conddp {
namespace {

double violation(const ConstraintTerm& term, const KnotBatch<double>& batch,
                 const double* parameters) {
  const bool bounds = term.has_bounds();
  return distance_to_set(term, batch.work.constraint.data() + term.row,
                         bounds ? parameters + term.lower() : nullptr,
                         bounds ? parameters + term.upper() : nullptr);
}

}  // namespace

Appraisal::Appraisal(const TimeLine& line, bool other_forces)
    : line_(line), other_forces_(other_forces) {
  const ShootingProblem& problem = line.problem();
  for (int k = 0; k < problem.knots(); ++k) {
    auto& batch = batches_[problem.knot(k).model];
    if (!batch) batch = std::make_unique<KnotBatch<double>>(*problem.knot(k).model);
  }
  auto& end = batches_[problem.terminal().model.get()];
  if (!end) end = std::make_unique<KnotBatch<double>>(*problem.terminal().model);
}

bool Appraisal::counts(const Residual& residual) const {
  return !other_forces_ || residual.reads() != Reads::forces;
}

StepFigures Appraisal::of_step(double time, double length, const double* u, const double* x) const {
  const int k = line_.at(time).knot;
  const KnotModel& model = *line_.problem().knot(k).model;
  const KnotNumbers numbers = line_.numbers(k);
  KnotBatch<double>& batch = *batches_.at(&model);
  std::copy_n(x, model.nx(), batch.x.begin());
  std::copy_n(u, model.nu(), batch.u.begin());
  batch.dt = length;  // step over which running costs are integrated
  const double share = std::abs(length - numbers.dt) < kSameTime ? 1 : length / numbers.dt;
  batch.cost_scale = numbers.cost_scale * share;
  return figures(model, numbers.parameters);
}

StepFigures Appraisal::of_end(const double* x) const {
  const ShootingProblem& problem = line_.problem();
  const KnotModel& model = *problem.terminal().model;
  const KnotNumbers numbers = line_.numbers(problem.knots());
  KnotBatch<double>& batch = *batches_.at(&model);
  std::copy_n(x, model.nx(), batch.x.begin());
  batch.cost_scale = numbers.cost_scale;
  return figures(model, numbers.parameters);
}

/// Evaluates the model at the inputs that its batch holds. The equations and pairs of a
/// contact-implicit step, its last two constraints, and the regularization of its forces, its last
/// cost, belong to the plan's forces.
StepFigures Appraisal::figures(const KnotModel& model, const double* parameters) const {
  KnotBatch<double>& batch = *batches_.at(&model);
  std::copy_n(parameters, model.parameter_count(), batch.parameters.begin());
  const auto& constraints = model.constraints();
  const bool implicit = !constraints.empty() && constraints.back().has_pairs();
  for (const CostTerm& term : model.costs())
    if (!counts(*term.residual)) batch.parameters[term.weight] = 0;
  if (implicit) batch.parameters[model.costs().back().weight] = 0;
  model.evaluate(batch.input(), batch.work);
  StepFigures found{.cost = batch.work.cost};
  for (const ConstraintTerm& term :
       std::span(constraints).first(constraints.size() - (implicit ? 2 : 0)))
    if (parameters[term.active()] != 0 && term.softness == Softness::hard && counts(*term.residual))
      found.violation = std::max(found.violation, violation(term, batch, parameters));
  return found;
}

StopCheck::StopCheck(const std::optional<StopCondition>& condition) : condition_(condition) {
  if (!condition) return;
  if (condition->model->parameter_count() != static_cast<int>(condition->parameters.size()))
    throw std::invalid_argument("the stop condition has another number of parameters");
  batch_ = std::make_unique<KnotBatch<double>>(*condition->model);
  std::copy(condition->parameters.begin(), condition->parameters.end(), batch_->parameters.begin());
}

const ConstraintTerm* StopCheck::first_met(const double* x) const {
  if (!batch_) return nullptr;
  const KnotModel& model = *condition_->model;
  std::copy_n(x, model.nx(), batch_->x.begin());
  model.evaluate(batch_->input(), batch_->work);
  for (const ConstraintTerm& term : model.constraints())
    if (violation(term, *batch_, condition_->parameters.data()) > 0) return &term;
  return nullptr;
}

}  // namespace conddp
