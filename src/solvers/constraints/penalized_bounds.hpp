#pragma once

#include <vector>

#include <Eigen/Core>

#include "solvers/common/control_bounds.hpp"
#include "solvers/riccati/backward_sweep.hpp"

namespace conddp {

/// Control bounds as ½ w dist²(u + δu + ν/w, [lower, upper]) in the linear model of the horizon:
/// for the search of an active set where controls that are held at bounds one sweep and free the
/// next do not settle. With the bounds' multipliers ν of the iterate and weights w of the stages'
/// own curvature the minimum is close to that with bounds.
class PenalizedBounds {
 public:
  explicit PenalizedBounds(const ControlBounds& bounds);

  /// Takes an iterate, with ∇_u L, whose entries at bounds are their multipliers, and weights from
  /// the Q_uu of a sweep. The model knows of no bound yet.
  void start(const Trajectory& trajectory, const Eigen::VectorXd& gradient,
             const BackwardSweep& sweep);
  /// Models them around a step (δx, δu of each node). Returns how many controls changed sides.
  int revise(const std::vector<Eigen::VectorXd>& z, Linearization& linearization);
  /// Takes them out of the model again.
  void remove(Linearization& linearization);
  /// How much more the derivative of the penalties along d = to − z is at z + α d than the model
  /// has it.
  double slope_beyond_model(const std::vector<Eigen::VectorXd>& z,
                            const std::vector<Eigen::VectorXd>& to, double alpha) const;
  /// u + δu + ν/w minus its nearest point between the bounds, of a knot's controls at the point of
  /// the last revision.
  auto outside(int k) const {
    return outside_.segment(bounds_.offset(k), bounds_.offset(k + 1) - bounds_.offset(k));
  }

 private:
  /// Derivative of the penalty by w, of an entry at s whose side is that of `outside`.
  double model(int k, int i, double s, double outside) const {
    return outside < 0 ? s - bounds_.lower(k)[i] : outside > 0 ? s - bounds_.upper(k)[i] : 0;
  }
  void set(int k, int i, double outside, KnotLinearization& knot);

  const ControlBounds& bounds_;
  Eigen::VectorXd weight_, base_, outside_;  ///< a number per control
};

}  // namespace conddp
