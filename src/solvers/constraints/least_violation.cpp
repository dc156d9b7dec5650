#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "ocp/problem/by_name.hpp"
#include "ocp/problem/problem.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/constraints/violation_slope.hpp"

namespace conddp {
namespace {

/// Number of violated constraints that a message names.
constexpr std::size_t kNamed = 3;

class LeastViolation final : public OuterStrategy {
 public:
  LeastViolation(const ShootingProblem& problem, const ControlBounds& bounds,
                 const SolverOptions& options)
      : problem_(problem),
        options_(options),
        slope_(problem, bounds),
        augmentation_(problem),
        multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())) {}

  const Augmentation* augmentation() const override { return &augmentation_; }
  const Eigen::VectorXd* multipliers() const override { return &multipliers_; }
  void start(const DualGuess* /*known*/) override {
    inner_start_ = 0;
    weigh(1);
  }
  bool fit(Iterate& iterate) override;
  double soft_cost(const Iterate& iterate) const override {
    return linear_soft_cost(problem_, iterate.linearization.constraint);
  }
  void measure(const Iterate& iterate, IterationRecord& row) override;
  bool solved(const IterationRecord& row, const SolverOptions::Tolerances& tolerances,
              double /*stationarity*/) const override {
    return row.gap <= tolerances.gap &&
           (row.constraint <= tolerances.constraint || violation_ <= tuning::kRestored * at_start_);
  }
  bool minimized(const IterationRecord& row, const MeritModel& merit) const override;
  bool update(Iterate& iterate, const Feedback& feedback, const MeritModel& merit, bool stuck,
              SolveRecord& record) override;
  bool recovers(const SolveRecord& record, bool /*stuck*/) override {
    return penalty_ < tuning::kMostPenalty &&
           (record.result.status == SolveStatus::line_search_failed ||
            record.result.status == SolveStatus::regularization_limit);
  }

 private:
  void weigh(double penalty);
  struct Worst {
    std::string name;
    double by = 0;
    int knot = -1;
    bool given = false;  ///< violated by the initial state itself
  };
  std::vector<Worst> violated(const Eigen::VectorXd& values) const;
  std::string violated_text(const Eigen::VectorXd& values) const;

  const ShootingProblem& problem_;
  const SolverOptions& options_;
  ViolationSlope slope_;
  Augmentation augmentation_;
  Eigen::VectorXd multipliers_;
  double penalty_ = 0;
  double violation_ = 0, at_start_ = 0;
  double share_ = 0;     ///< for the gradient of cost and violation along the last sweep's gains
  int inner_start_ = 0;  ///< first iteration of the current minimization
};

bool LeastViolation::fit(Iterate& iterate) {
  at_start_ = slope_.violation(iterate.linearization.constraint);
  if (!(at_start_ > 0)) return false;
  const double cost = std::abs(iterate.linearization.total_cost());
  weigh(std::clamp(2 * tuning::kFirstWeight * cost / (at_start_ * at_start_), 1.0,
                   std::sqrt(tuning::kMostPenalty)));
  return true;
}

void LeastViolation::weigh(double penalty) {
  penalty_ = penalty;
  for (const NodeConstraint& c : problem_.constraints())
    augmentation_.penalty.segment(c.row, c.term->rows).setConstant(penalty);
}

void LeastViolation::measure(const Iterate& iterate, IterationRecord& row) {
  const Eigen::VectorXd& values = iterate.linearization.constraint;
  const Extremum largest = largest_violation(problem_, iterate.bounds, iterate.trajectory, values);
  row.constraint = largest.value;
  row.constraint_knot = largest.knot;
  row.constraint_penalty = penalty_;
  violation_ = slope_.violation(values);
  multipliers_ = penalty_ * slope_.distances();
  row.complementarity = 0;
  for (const NodeConstraint& c : problem_.constraints()) {
    if (c.is_soft())
      next_multipliers(c, values.data() + c.row, penalty_, multipliers_.data() + c.row);
    row.complementarity =
        std::max(row.complementarity,
                 complementarity(c, values.data() + c.row, multipliers_.data() + c.row));
  }
  share_ = slope_.share(iterate.adjoint.gradient(), iterate.trajectory) / penalty_;
}

bool LeastViolation::minimized(const IterationRecord& row, const MeritModel& merit) const {
  if (row.gap > options_.tolerances.gap) return false;
  return share_ <= tuning::kMinimizedShare ||
         (row.iteration > inner_start_ && row.step >= tuning::kShortStep &&
          row.actual_decrease <= tuning::kSmallDecrease * std::abs(merit.cost));
}

bool LeastViolation::update(Iterate& iterate, const Feedback& feedback, const MeritModel& /*merit*/,
                            bool /*stuck*/, SolveRecord& record) {
  const bool closed = record.row.gap <= options_.tolerances.gap;
  const double share = slope_.share(iterate.evaluator, iterate.trajectory, iterate.gaps);
  if (closed && share <= tuning::kLeastShare)
    return record.end(
        SolveStatus::infeasible,
        fmt::format("no small change of the controls lowers the violation: to first order by a "
                    "share of {:.1e} at most, within their bounds; violated: {}; {}",
                    share, violated_text(iterate.linearization.constraint),
                    record.residual_text()));
  if (penalty_ >= tuning::kMostPenalty)
    return record.end(
        SolveStatus::line_search_failed,
        fmt::format("neither feasible nor a point of least violation (share {:.1e}): {}", share,
                    record.residual_text()));
  inner_start_ = record.row.iteration;
  ++record.row.outer;
  weigh(tuning::kPenaltyFactor * penalty_);
  iterate.differentiate(feedback, augmentation());
  return true;
}

/// The worst violation of each constraint above tolerance, the largest ones first.
std::vector<LeastViolation::Worst> LeastViolation::violated(const Eigen::VectorXd& values) const {
  std::vector<Worst> list;
  for (const NodeConstraint& c : problem_.constraints()) {
    const double by = violation(c, values.data() + c.row);
    if (!(by > options_.tolerances.constraint)) continue;
    const std::string name = constraint_name(problem_, c);
    const bool given = c.node == 0 && !c.term->depends_on_control(problem_.ndx());
    auto known =
        std::find_if(list.begin(), list.end(), [&](const Worst& w) { return w.name == name; });
    if (known == list.end()) known = list.insert(list.end(), Worst{.name = name});
    if (by > known->by) *known = {name, by, c.node, given};
  }
  std::stable_sort(list.begin(), list.end(),
                   [](const Worst& a, const Worst& b) { return a.by > b.by; });
  return list;
}

/// Formats "'goal' by 0.20 (knot 35), 'walls' by ...".
std::string LeastViolation::violated_text(const Eigen::VectorXd& values) const {
  const std::vector<Worst> list = violated(values);
  std::string text;
  for (std::size_t i = 0; i < std::min(list.size(), kNamed); ++i)
    text += fmt::format(
        "{}'{}' by {:.2g} ({})", i == 0 ? "" : ", ", list[i].name, list[i].by,
        list[i].given ? "the initial state itself" : fmt::format("knot {}", list[i].knot));
  if (list.size() > kNamed) text += fmt::format(" and {} more", list.size() - kNamed);
  return text;
}

}  // namespace

std::unique_ptr<OuterStrategy> least_violation_strategy(const ShootingProblem& problem,
                                                        const ControlBounds& bounds,
                                                        const SolverOptions& options) {
  return std::make_unique<LeastViolation>(problem, bounds, options);
}

}  // namespace conddp
