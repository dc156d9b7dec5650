#pragma once

#include <vector>

#include <Eigen/Core>

#include "solvers/common/control_bounds.hpp"
#include "solvers/constraints/horizon_constraints.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/riccati/linear_rollout.hpp"

namespace conddp {

/// Control bounds as ½ w dist²(u + δu + ν/w, [lower, upper]) in the linear model of the horizon.
/// They serve the search for an active set if controls alternate between held and free and do not
/// settle. With the bounds' multipliers ν of the iterate and weights w from the stages' own
/// curvature, the minimum is close to that with bounds.
class PenalizedBounds {
 public:
  explicit PenalizedBounds(const ControlBounds& bounds);

  /// Takes an iterate, its ∇_u L (the entries at bounds are the bounds' multipliers), and weights
  /// from the Q_uu of a sweep. The model does not include any bound yet.
  void start(const Trajectory& trajectory, const Eigen::VectorXd& gradient,
             const BackwardSweep& sweep);
  /// Models the bounds around a step (δx, δu of each node). Returns the number of controls that
  /// changed sides.
  int revise(const std::vector<Eigen::VectorXd>& z, Linearization& linearization);
  /// Removes the bounds from the model.
  void remove(Linearization& linearization);
  /// Derivative of the penalties along d = to − z at z + α d, minus that of the model.
  double slope_beyond_model(const std::vector<Eigen::VectorXd>& z,
                            const std::vector<Eigen::VectorXd>& to, double alpha) const;
  /// u + δu + ν/w minus its projection on the bounds, for a knot's controls at the point of the
  /// last revision.
  auto outside(int k) const {
    return outside_.segment(bounds_.offset(k), bounds_.offset(k + 1) - bounds_.offset(k));
  }

 private:
  /// Derivative of the penalty divided by w, for an entry at s on the side given by `outside`.
  double model(int k, int i, double s, double outside) const {
    return outside < 0 ? s - bounds_.lower(k)[i] : outside > 0 ? s - bounds_.upper(k)[i] : 0;
  }
  void set(int k, int i, double outside, KnotLinearization& knot);

  const ControlBounds& bounds_;
  Eigen::VectorXd weight_, base_, outside_;  ///< one number per control
};

/// A point in the linear model of the horizon that descends from sweep to sweep. The method is
/// Newton's with an exact line search, on the augmented Lagrangian with penalties for the control
/// bounds. Both are convex and piecewise quadratic. It therefore converges even if the sets of
/// active rows and bounds alternate under full steps.
class HorizonDescent {
 public:
  HorizonDescent(const ShootingProblem& problem, const ControlBounds& bounds);

  /// Begins with a step that has the gaps of the iterate. The model is that of the iterate.
  void start(const LinearRollout& step, const Trajectory& trajectory,
             const Eigen::VectorXd& gradient, const BackwardSweep& sweep,
             HorizonConstraints& constraints, Linearization& linearization);
  /// Moves the point towards the minimum of the model around it, and the model with it. True if
  /// this was the minimum of the penalized model.
  bool advance(const LinearRollout& minimum, HorizonConstraints& constraints,
               Linearization& linearization);
  /// Removes the penalties for bounds from the model, and holds controls where they pushed.
  void leave(ActiveSet& active_set, Linearization& linearization);
  /// Writes the point as δu = k + K δx with the present K.
  void write(Feedback& feedback) const;

 private:
  double step_length(const LinearRollout& minimum, HorizonConstraints& constraints,
                     const Linearization& linearization);

  const ControlBounds& bounds_;
  int ndx_;
  PenalizedBounds penalties_;
  std::vector<Eigen::VectorXd> point_;  ///< (δx, δu) of each node
  Eigen::VectorXd d_, product_;
};

}  // namespace conddp
