#pragma once

#include <vector>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/iteration_record.hpp"
#include "solvers/common/options.hpp"

namespace conddp {

/// Second derivatives of the dynamics in the sweep.
enum class HessianUse {
  gauss_newton,
  when_slow,   ///< exact once Gauss-Newton's convergence, linear as it is, turns out to be slow
  exact,       ///< once gaps are closed; where these have no minimum, the Gauss-Newton ones
  exact_alone  ///< with open gaps, too, and never the Gauss-Newton ones
};

/// Whether a cost is linear in its residual.
bool has_linear_costs(const ShootingProblem& problem);

/// Whether some knot has so many directions that exact Hessians, which take a pass for each, are
/// dear beside all else of an iteration.
bool exact_hessians_are_dear(const ShootingProblem& problem);

/// What a solver with this use does with a problem as the options ask. Costs that are linear in
/// their residuals have no Gauss-Newton Hessian: what curvature there is comes from the dynamics
/// and residuals, so the exact one stands alone there.
HessianUse hessian_use(HessianUse use, const SolverOptions& options,
                       const ShootingProblem& problem);

/// Whether Hessians differ by rounding alone: those of problems without curvature in dynamics and
/// residuals do.
bool same_hessian(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// The Hessians of a linearisation in two sets, Gauss-Newton and exact, of which one is in the
/// linearisation and the other here; and when a solve turns from the former to the latter, or back.
class HessianSwitch {
 public:
  /// Allocates what exact Hessians need if they are used from the start; otherwise the first of
  /// them does, which most solves never compute. `tolerance` is that of the stationarity.
  HessianSwitch(HessianUse use, double tolerance, Evaluator& evaluator,
                Linearization& linearization);

  /// Allocates it now, if exact Hessians may be used at all.
  void reserve();
  /// At the start of a solve.
  void reset();
  /// With every row of the log: watches for slow convergence, with either set.
  void watch(const IterationRecord& row);
  /// Turns to exact Hessians for good, where convergence may decide that. Returns whether that is
  /// news.
  bool turn();

  /// Forgets the exact Hessians and puts the Gauss-Newton ones into the linearisation, as
  /// Evaluator::differentiate wants it: that leaves entries alone that are zero by structure.
  void begin_iterate();
  /// Whether the iterate should get exact Hessians.
  bool exact_wanted() const { return exact_wanted_; }
  /// Whether the Gauss-Newton ones are no substitute.
  bool exact_alone() const { return use_ == HessianUse::exact_alone; }
  /// Gives it those with these co-states (ndx x (N + 1)). Where they turn out to be the
  /// Gauss-Newton ones they are known no more, nor wanted before the next slow window.
  void evaluate_exact(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                      const Augmentation* augmentation = nullptr);
  /// Once more, where the iterate has those with other co-states.
  void follow(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
              const Augmentation* augmentation);
  /// Whether the iterate has them.
  bool exact_known() const { return exact_known_; }

  /// Puts one of the sets into the linearisation.
  void use(bool exact);
  bool exact_in_use() const { return exact_in_use_; }
  /// What `look` returns with the iterate's Gauss-Newton Hessians in place.
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
  double exact_cost_ = 0;  ///< of an iteration, in Gauss-Newton iterations
  Evaluator& evaluator_;
  Linearization& linearization_;
  std::vector<Eigen::MatrixXd> other_;  ///< the set that is not in the linearisation
  Eigen::MatrixXd costates_;            ///< of the last exact Hessians
  bool exact_wanted_ = false;
  bool exact_known_ = false;
  bool exact_in_use_ = false;
  bool for_good_ = false;      ///< exact Hessians are not given up
  bool same_ = false;          ///< the last exact Hessians were those of Gauss-Newton
  int returns_ = 0;            ///< how often exact Hessians were given up
  int watched_iteration_ = 0;  ///< the iterate that convergence is compared with
  double watched_cost_ = 0;
  double watched_stationarity_ = 0;
};

}  // namespace conddp
