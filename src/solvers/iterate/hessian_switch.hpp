#pragma once

#include <vector>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// Second derivatives of the dynamics in the sweep.
enum class HessianUse {
  gauss_newton,
  when_slow,   ///< exact once Gauss-Newton's linear convergence turns out to be slow
  exact,       ///< exact once gaps are closed; Gauss-Newton where the exact ones lack a minimum
  exact_alone  ///< exact with open gaps, too; never Gauss-Newton
};

/// True if some cost is linear in its residual.
bool has_linear_costs(const ShootingProblem& problem);

/// True if some knot has so many directions that exact Hessians, which take a pass for each, are
/// expensive compared with the rest of an iteration.
bool exact_hessians_are_dear(const ShootingProblem& problem);

/// Hessians that a solver with this use takes for a problem, given the options. Costs that are
/// linear in their residuals lack a Gauss-Newton Hessian: their curvature comes from dynamics and
/// residuals, so only the exact one is used.
HessianUse hessian_use(HessianUse use, const SolverOptions& options,
                       const ShootingProblem& problem);

/// True if Hessians differ only by rounding, as for problems without curvature in dynamics and
/// residuals.
bool same_hessian(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Two sets of Hessians of a linearization, Gauss-Newton and exact: one is in the linearization,
/// the other is stored here. Decides when a solve turns from the former to the latter, or back.
class HessianSwitch {
 public:
  /// Allocates memory of exact Hessians if they are used from the start. Otherwise the first exact
  /// Hessian allocates it; most solves never compute one. `tolerance` is the stationarity
  /// tolerance.
  HessianSwitch(HessianUse use, double tolerance, Evaluator& evaluator,
                Linearization& linearization);

  /// Allocates this memory now, unless exact Hessians are never used.
  void reserve();
  /// Called at the start of a solve.
  void reset();
  /// Watches every row of the log for slow convergence, with either set.
  void watch(const IterationRecord& row);
  /// Turns to exact Hessians for good, if convergence may decide that. Returns true if this is a
  /// change.
  bool turn();

  /// Discards the exact Hessians and puts the Gauss-Newton ones into the linearization.
  /// Evaluator::differentiate requires this: it leaves structurally zero entries unchanged.
  void begin_iterate();
  /// True if the iterate should get exact Hessians.
  bool exact_wanted() const { return exact_wanted_; }
  /// True if Gauss-Newton Hessians cannot replace the exact ones.
  bool exact_alone() const { return use_ == HessianUse::exact_alone; }
  /// Evaluates the exact Hessians with these co-states (ndx x (N + 1)). If they equal the
  /// Gauss-Newton ones, they are discarded, and not wanted before the next slow window.
  void evaluate_exact(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                      const Augmentation* augmentation = nullptr);
  /// Evaluates exact Hessians again if the iterate has them with other co-states.
  void follow(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
              const Augmentation* augmentation);
  /// True if the iterate has exact Hessians.
  bool exact_known() const { return exact_known_; }

  /// Puts one of the sets into the linearization.
  void use(bool exact);
  bool exact_in_use() const { return exact_in_use_; }
  /// Result of `look` with the iterate's Gauss-Newton Hessians in the linearization.
  template <class Look>
  auto by_gauss_newton(const Look& look) {
    const bool exact = exact_in_use_;
    use(false);
    const auto seen = look();
    use(exact);
    return seen;
  }

 private:
  bool gauss_newton_is_slow(const IterationRecord& row) const;
  bool exact_is_slow(const IterationRecord& row) const;
  int window() const;
  void turn_if_slow(const IterationRecord& row);

  HessianUse use_;
  double tolerance_;
  double exact_cost_ = 0;  ///< cost of an exact iteration, in Gauss-Newton iterations
  Evaluator& evaluator_;
  Linearization& linearization_;
  std::vector<Eigen::MatrixXd> other_;  ///< the set outside the linearization
  Eigen::MatrixXd costates_;            ///< of the last exact Hessians
  bool exact_wanted_ = false;
  bool exact_known_ = false;
  bool exact_in_use_ = false;
  bool for_good_ = false;      ///< exact Hessians are never given up again
  bool same_ = false;          ///< the last exact Hessians equaled Gauss-Newton
  int returns_ = 0;            ///< number of times that exact Hessians were given up
  int watched_iteration_ = 0;  ///< iterate that convergence is compared with
  double watched_cost_ = 0;
  double watched_stationarity_ = 0;
};

}  // namespace conddp
