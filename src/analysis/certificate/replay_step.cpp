#include "analysis/certificate/replay_step.hpp"

#include <algorithm>
#include <limits>

#include "base/matrix_decompositions.hpp"
#include "ocp/knot/collocation_residual.hpp"

namespace conddp {

/// A collocation step, whose slopes follow from the state and the actuators.
class CollocationStep {
 public:
  CollocationStep(const std::shared_ptr<const CollocationSystem>& system, Step step)
      : model_(std::move(step)),
        actuators_(system->actuators()),
        x_(model_.nx(), 0.0),
        w_(model_.nu(), 0.0) {
    model_.add_constraint(
        make_constraint("collocation",
                        collocation_residual(system, model_.ndx(), std::nullopt,
                                             model_.step().controls_in_state() > 0),
                        ConstraintKind::bounds));
    parameters_.assign(model_.parameter_count(), 0.0);
    work_ = std::make_unique<KnotWorkspace<double>>(model_);
  }

  /// Solves for the next state by Newton's method, starting from the slopes of the previous step.
  /// Returns NaN if it fails.
  std::vector<double> go(const double* x, const StepControl& u, double h) {
    const int unknown = model_.constraint_rows();
    const ConstraintTerm& term = model_.constraints().front();
    std::copy_n(x, model_.system().nx(), x_.begin());
    std::copy_n(u.begin, model_.step().tail(), x_.begin() + model_.system().nx());
    std::copy_n(u.end, actuators_, w_.begin());
    parameters_[term.parameters] = h;
    parameters_[term.active()] = 1;
    Eigen::MatrixXd by_slopes(unknown, unknown);
    Eigen::Map<Eigen::VectorXd> slopes(w_.data() + actuators_, unknown);
    for (int i = 0; i < kIterations; ++i) {
      model_.differentiate(KnotInput<double>{x_.data(), w_.data(), parameters_.data(), h, 1.0},
                           *work_, false);
      const Eigen::Map<const Eigen::VectorXd> off(work_->constraint.data(), unknown);
      if (off.lpNorm<Eigen::Infinity>() <= kRounding * (1 + h * slopes.lpNorm<Eigen::Infinity>()))
        return {work_->next().begin(), work_->next().begin() + model_.system().nx()};
      by_slopes.setZero();
      const auto& pattern = model_.constraint_pattern();
      const int first = model_.ndx() + actuators_;
      for (std::size_t e = 0; e < pattern.size(); ++e)
        if (const auto& [row, column] = pattern[e]; column >= first)
          by_slopes(row, column - first) = work_->constraint_jacobian[e];
      slopes -= by_slopes.partialPivLu().solve(off);
    }
    slopes.setZero();
    return std::vector<double>(model_.system().nx(), std::numeric_limits<double>::quiet_NaN());
  }

 private:
  static constexpr int kIterations = 30;
  static constexpr double kRounding = 1e-13;

  KnotModel model_;
  int actuators_;
  std::vector<double> x_, w_, parameters_;
  std::unique_ptr<KnotWorkspace<double>> work_;
};

namespace {

std::shared_ptr<const System> without_slopes(const KnotModel& model) {
  const CollocationSystem* collocation = model.system().as_collocation();
  return collocation ? collocation->inside() : model.shared_system();
}

}  // namespace

ReplayStep::ReplayStep(const KnotModel& model) : ReplayStep(model, model.integrator()) {}

ReplayStep::ReplayStep(const KnotModel& model, Integrator rule)
    : system_(without_slopes(model)),
      integrator_(rule),
      linear_(model.step().controls_in_state() > 0),
      data_(system_->create_data(double{})) {
  if (const auto collocation = info_of(rule).collocation) {
    const auto system = std::make_shared<const CollocationSystem>(system_, *collocation);
    implicit_ = std::make_unique<CollocationStep>(system, model.step().alike(system, rule));
  } else {
    work_.emplace(*system_, rule, false, linear_);
  }
}

ReplayStep::~ReplayStep() = default;

const SystemData<double>& ReplayStep::look(const double* x, const double* u) {
  system_->evaluate(x, u, *data_);
  return *data_;
}

void ReplayStep::go(const StepControl& u, double dt, double* x) {
  if (implicit_) {
    const std::vector<double> next = implicit_->go(x, u, dt);
    std::copy(next.begin(), next.end(), x);
    return;
  }
  integrate(*system_, integrator_, x, u.begin, dt, *data_, *work_, linear_ ? u.end : nullptr);
  std::copy(work_->next.begin(), work_->next.end(), x);
}

}  // namespace conddp
