#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/active_set.hpp"

namespace conddp {

/// Learns from the steps taken what the Gauss-Newton Hessian leaves out: L-BFGS (Nocedal, Wright,
/// Numerical Optimization, algorithm 7.4) with the sweep as its initial inverse Hessian.
///
/// It works on the feedforward v of the policy δu = v + K δx. In v the sweep's model has the
/// Hessian M = blockdiag(Q_uu) and, at v = 0, the gradient g = −M d, where d is the sweep's k. A
/// step s with the change y of g that it makes is a pair; M⁻¹ y is the change of −d. So a
/// correction costs a few dot products. Controls that a bound holds take no part.
class LbfgsCorrection {
 public:
  explicit LbfgsCorrection(const ControlBounds& bounds);

  void clear();
  /// Shows the direction that a sweep without regularisation found; with the step taken before it
  /// makes a pair.
  void observe(const Feedback& feedback, const BackwardSweep& sweep, const ActiveSet& active_set);
  /// Replaces the k that were observed by corrected ones; false where nothing is known.
  bool correct(Feedback& feedback);
  /// Puts the observed k back.
  void restore(Feedback& feedback) const;
  /// That the full step of this feedback has been taken.
  void step_taken(const Feedback& feedback);

 private:
  struct Pair {
    Eigen::VectorXd s, y, w;  ///< step, change of the gradient, M⁻¹ y
    double curvature = 0;     ///< sᵀ y
    double weight = 0;        ///< of the first loop
  };
  void apply_inverse();
  void stack(const std::vector<Eigen::VectorXd>& parts, Eigen::VectorXd& whole) const;
  bool free_entries(const Feedback& feedback, const ActiveSet& active_set);
  void add_pair(const BackwardSweep& sweep);

  const ControlBounds& bounds_;
  std::vector<Pair> pairs_;  ///< a ring
  int count_ = 0, newest_ = -1;
  double ratio_ = 1;                        ///< of the lengths of the last two directions
  bool observed_ = false;                   ///< d_ and g_ belong to the iterate before s_
  bool stepped_ = false;                    ///< s_ has been taken from there
  Eigen::VectorXd free_;                    ///< 1 where no bound holds the control, 0 elsewhere
  Eigen::VectorXd d_, g_, s_;               ///< of the last observation, and the step from there
  Eigen::VectorXd new_d_, new_g_, r_, Ms_;  ///< scratch
};

}  // namespace conddp
