#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/stopwatch.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/feasible.hpp"
#include "solvers/common/finite_check.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/augmentation_change.hpp"
#include "solvers/constraints/augmented_lagrangian.hpp"
#include "solvers/constraints/outer_strategy.hpp"

namespace conddp {
namespace {

class AugmentedStrategy final : public OuterStrategy {
 public:
  AugmentedStrategy(const ShootingProblem& problem, const SolverOptions& options,
                    MultiplierSchedule schedule)
      : problem_(problem),
        options_(options),
        by_the_sweep_(schedule == MultiplierSchedule::by_the_sweep),
        lagrangian_(problem, options, schedule),
        former_(problem),
        change_(problem),
        no_multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())) {}

  const Augmentation* augmentation() const override { return &lagrangian_.augmentation(); }
  const Eigen::VectorXd* multipliers() const override { return &lagrangian_.multipliers(); }
  void start(const DualGuess* known) override {
    inner_tolerance_ = tuning::kFirstInnerTolerance;
    inner_decrease_ = tuning::kFirstInnerDecrease;
    inner_start_ = recoveries_ = relaxations_ = 0;
    lagrangian_.start(known ? known->constraints : no_multipliers_);
  }
  bool fit(Iterate& iterate) override {
    const bool lower = iterate.hessian.by_gauss_newton(
        [&] { return lagrangian_.fit_to_costs(iterate.linearization); });
    return lagrangian_.fit_soft(iterate.linearization.constraint) || lower;
  }
  /// Cost of constraints that are soft by their distance.
  double soft_cost(const Iterate& iterate) const override {
    return linear_soft_cost(problem_, iterate.linearization.constraint);
  }
  void measure(const Iterate& iterate, IterationRecord& row) override;
  bool minimized(const IterationRecord& row, const MeritModel& merit) const override;
  bool update(Iterate& iterate, const Feedback& feedback, const MeritModel& merit, bool stuck,
              SolveRecord& record) override;
  bool recovers(const SolveRecord& record, bool stuck) override;
  void take_multipliers() override {
    if (!by_the_sweep_) lagrangian_.take_multipliers();
  }
  void adopt(const Eigen::VectorXd& multipliers) override { lagrangian_.adopt(multipliers); }
  void add(const Eigen::VectorXd& change, double step) override { lagrangian_.add(change, step); }

 private:
  bool to_the_end(const IterationRecord& row, const MeritModel& merit) const;
  bool hidden_by_rounding(const IterationRecord& row, const MeritModel& merit, bool stuck) const;
  bool relax_for_rounding(Iterate& iterate, SolveRecord& record);
  void begin_minimization(IterationRecord& row);
  void update_derivatives(Iterate& iterate, const Feedback& feedback, bool relaxed);
  void change_augmentation(Iterate& iterate, const Feedback& feedback);

  const ShootingProblem& problem_;
  const SolverOptions& options_;
  bool by_the_sweep_;
  AugmentedLagrangian lagrangian_;
  Augmentation former_;  ///< the augmentation before the last update
  AugmentationChange change_;
  Eigen::VectorXd no_multipliers_;
  double inner_tolerance_ = 0, inner_decrease_ = 0;  ///< of the current minimization
  int inner_start_ = 0;                              ///< iteration at its start
  double dual_gain_ = 0;                             ///< ConstraintNorms::dual_gain
  int recoveries_ = 0;                               ///< minimizations that ended without a step
  int relaxations_ = 0;  ///< relaxations of penalties whose rounding hid the stationarity
};

void AugmentedStrategy::measure(const Iterate& iterate, IterationRecord& row) {
  OuterStrategy::measure(iterate, row);
  const ConstraintNorms norms = lagrangian_.measure(iterate.linearization.constraint);
  if (!(norms.violation.value <= row.constraint)) {
    row.constraint = norms.violation.value;
    row.constraint_knot = norms.violation.knot;
  }
  row.complementarity = norms.complementarity;
  row.constraint_penalty = lagrangian_.largest_penalty();
  dual_gain_ = norms.dual_gain;
}

bool AugmentedStrategy::minimized(const IterationRecord& row, const MeritModel& merit) const {
  if (by_the_sweep_ ||
      row.gap > std::max(options_.tolerances.gap, tuning::kGapsOfViolation * row.constraint))
    return false;
  if (row.stationarity <= std::max(inner_tolerance_, options_.tolerances.stationarity)) return true;
  return row.iteration > inner_start_ && row.step >= tuning::kShortStep &&
         row.actual_decrease <= inner_decrease_ * std::abs(merit.cost);
}

/// True if the finished minimization left no more to gain than other multipliers will. A
/// minimization that ended early because its steps gained little may still be far from its minimum.
/// Its violations are then its own and do not count against the penalties.
bool AugmentedStrategy::to_the_end(const IterationRecord& row, const MeritModel& merit) const {
  return row.stationarity <= std::max(inner_tolerance_, options_.tolerances.stationarity) ||
         row.actual_decrease <= tuning::kDualShare * dual_gain_ ||
         merit.hidden(row.actual_decrease);
}

/// True if multipliers and penalties have done their work, and the remaining stationarity is
/// rounding: ρ times that of the constraints' values.
bool AugmentedStrategy::hidden_by_rounding(const IterationRecord& row, const MeritModel& merit,
                                           bool stuck) const {
  const auto& tolerance = options_.tolerances;
  if (!is_feasible(row, tolerance)) return false;
  return stuck ||
         (inner_tolerance_ <= tolerance.stationarity && merit.hidden(row.actual_decrease)) ||
         inner_tolerance_ <= tuning::kHopelessGoal * tolerance.stationarity;
}

bool AugmentedStrategy::update(Iterate& iterate, const Feedback& feedback, const MeritModel& merit,
                               bool stuck, SolveRecord& record) {
  const bool idle = lagrangian_.idle(iterate.linearization.constraint);
  const bool by_rounding = hidden_by_rounding(record.row, merit, stuck);
  former_ = lagrangian_.augmentation();
  iterate.hessian.by_gauss_newton([&] { return lagrangian_.fit_to_costs(iterate.linearization); });
  lagrangian_.update(to_the_end(record.row, merit));
  if (by_rounding && !relax_for_rounding(iterate, record)) return false;
  if (!lagrangian_.stalled().empty()) {
    iterate.linearized = false;  // the results must belong to the last multipliers
    return record.end(SolveStatus::infeasible,
                      fmt::format("the violation of '{}' does not fall as its penalty grows: {}",
                                  lagrangian_.stalled(), record.residual_text()));
  }
  begin_minimization(record.row);
  // Rows strictly inside their sets have zero derivatives, so nothing changes.
  const bool unchanged =
      iterate.linearized && idle && lagrangian_.idle(iterate.linearization.constraint);
  if (!unchanged) update_derivatives(iterate, feedback, by_rounding);
  return true;
}

/// Lowers the penalties because rounding hides the rest of the stationarity. False if they have
/// been lowered often enough; the solve then ends.
bool AugmentedStrategy::relax_for_rounding(Iterate& iterate, SolveRecord& record) {
  if (++relaxations_ > tuning::kTries) {
    iterate.linearized = false;
    record.result.failed_quantity = kRoundedCost;
    return record.end(
        SolveStatus::line_search_failed,
        "rounding hides the remaining stationarity, whatever the penalties of the constraints: {}",
        record.residual_text());
  }
  lagrangian_.relax();
  inner_tolerance_ = std::max(inner_tolerance_, options_.tolerances.stationarity);
  return true;
}

void AugmentedStrategy::begin_minimization(IterationRecord& row) {
  ++row.outer;
  inner_tolerance_ *= tuning::kTighter;
  inner_decrease_ = std::max(tuning::kTighter * inner_decrease_, tuning::kLastInnerDecrease);
  inner_start_ = row.iteration;
}

/// Updates the derivatives of the iterate. With relaxed penalties they are evaluated again, so that
/// their rounding is that of the new penalties.
void AugmentedStrategy::update_derivatives(Iterate& iterate, const Feedback& feedback,
                                           bool relaxed) {
  if (iterate.linearized && !relaxed && !iterate.hessian.exact_wanted())
    change_augmentation(iterate, feedback);
  else
    iterate.differentiate(feedback, augmentation());
}

/// Changes the known derivatives of the iterate from the former augmentation to the present one.
void AugmentedStrategy::change_augmentation(Iterate& iterate, const Feedback& feedback) {
  const Stopwatch watch(iterate.times().differentiate);
  if (!change_.apply(former_, lagrangian_.augmentation(), iterate.linearization)) return;
  iterate.adjoint.compute(iterate.linearization, iterate.trajectory, iterate.gaps, feedback);
  iterate.linearized = std::isfinite(iterate.linearization.augmentation.sum()) &&
                       all_finite(iterate.adjoint.costates()) &&
                       all_finite(iterate.adjoint.gradient());
}

/// True if another minimization may help a stalled one: with other multipliers and penalties, or
/// with lower penalties against rounding.
bool AugmentedStrategy::recovers(const SolveRecord& record, bool stuck) {
  const SolveStatus status = record.result.status;
  if (by_the_sweep_ ||
      (status != SolveStatus::line_search_failed && status != SolveStatus::regularization_limit))
    return false;
  const bool by_rounding = stuck && lagrangian_.may_relax();
  if (record.row.constraint <= options_.tolerances.constraint && !by_rounding) return false;
  return ++recoveries_ <= tuning::kTries;
}

}  // namespace

std::unique_ptr<OuterStrategy> augmented_lagrangian_strategy(const ShootingProblem& problem,
                                                             const SolverOptions& options,
                                                             MultiplierSchedule schedule) {
  return std::make_unique<AugmentedStrategy>(problem, options, schedule);
}

}  // namespace conddp
