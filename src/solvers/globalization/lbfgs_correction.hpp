#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/active_set.hpp"

namespace conddp {

/// Learns from previous steps what the Gauss-Newton Hessian omits: L-BFGS (Nocedal, Wright,
/// Numerical Optimization, algorithm 7.4) with the sweep as its initial inverse Hessian.
///
/// It acts on the feedforward v of the policy δu = v + K δx. In v, the sweep's model has the
/// Hessian M = blockdiag(Q_uu) and, at v = 0, the gradient g = −M d, where d is the sweep's k. A
/// pair consists of a step s and the change y of g that it causes; M⁻¹ y is the change of −d. A
/// correction therefore costs only a few dot products. Controls held at a bound are excluded.
class LbfgsCorrection {
 public:
  explicit LbfgsCorrection(const ControlBounds& bounds);

  void clear();
  /// Observes the direction of a sweep without regularization, which forms a pair with the step
  /// taken before it.
  void observe(const Feedback& feedback, const BackwardSweep& sweep, const ActiveSet& active_set);
  /// Replaces the observed k by corrected ones; false if nothing is known.
  bool correct(Feedback& feedback);
  /// Restores the observed k.
  void restore(Feedback& feedback) const;
  /// Records that the full step of this feedback was taken.
  void step_taken(const Feedback& feedback);

 private:
  struct Pair {
    Eigen::VectorXd s, y, w;  ///< step, change of the gradient, M⁻¹ y
    double curvature = 0;     ///< sᵀ y
    double weight = 0;        ///< from the first loop
  };
  void apply_inverse();
  void stack(const std::vector<Eigen::VectorXd>& parts, Eigen::VectorXd& whole) const;
  bool free_entries(const Feedback& feedback, const ActiveSet& active_set);
  void add_pair(const BackwardSweep& sweep);

  const ControlBounds& bounds_;
  std::vector<Pair> pairs_;  ///< a ring buffer
  int count_ = 0, newest_ = -1;
  bool observed_ = false;                   ///< d_ and g_ belong to the iterate before s_
  bool stepped_ = false;                    ///< s_ was taken from there
  Eigen::VectorXd free_;                    ///< 0 where a bound holds the control, 1 elsewhere
  Eigen::VectorXd d_, g_, s_;               ///< from the last observation, and the step from there
  Eigen::VectorXd new_d_, new_g_, r_, Ms_;  ///< scratch
};

}  // namespace conddp
