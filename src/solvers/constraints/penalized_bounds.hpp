#pragma once

#include <vector>

#include <Eigen/Core>

#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"

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

}  // namespace conddp
