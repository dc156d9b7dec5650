#pragma once

#include <memory>
#include <vector>

#include "support/constrained_problems.hpp"
#include "support/sizes.hpp"

/// Random feasible convex conic linear-quadratic problems.
namespace conddp::testing {

/// C z − reference with z = (x, u), or only x if C has no more columns. Parameter: the reference.
class AffineResidual : public ResidualBase<AffineResidual> {
 public:
  AffineResidual(Eigen::MatrixXd C, int nx)
      : ResidualBase({{static_cast<int>(C.rows()), column_range(0, static_cast<int>(C.cols()))}},
                     static_cast<int>(C.rows()), C.cols() > nx),
        nx_(nx),
        C_(std::move(C)) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (int i = 0; i < size(); ++i) {
      r[i] = -in.parameters[i];
      for (int j = 0; j < C_.cols(); ++j) r[i] += (j < nx_ ? in.x[j] : in.u[j - nx_]) * C_(i, j);
    }
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    for (int i = 0; i < C_.size(); ++i) jacobian[i] = S(C_.data()[i]);
  }

  const Eigen::MatrixXd& matrix() const { return C_; }

 private:
  int nx_;
  Eigen::MatrixXd C_;
};

/// Numbers of a random problem, per knot.
struct ConicSize {
  int nx, nu, knots;
  int equalities, boxes, cones;  ///< rows, rows, cones of `cone_rows` each
  int cone_rows = 4;
  int terminal = 0;        ///< equalities of the last state
  double control = kFree;  ///< limit of |u|
  double slack = 0.3;      ///< largest margin of the known point inside boxes and cones
  double spectral_radius = 1;
  int copies = 1;          ///< copies of every constraint
  int contradictions = 0;  ///< additional contradictory equalities of the last state
};

/// Includes constraints of every kind.
inline ConicSize middle_size() {
  return {.nx = kSmallSizes ? 8 : 12,
          .nu = kSmallSizes ? 4 : 6,
          .knots = kSmallSizes ? 15 : 40,
          .equalities = 1,
          .boxes = 4,
          .cones = 1,
          .terminal = 2,
          .control = 1};
}

/// Saturated controls and active rows alternate from sweep to sweep.
inline ConicSize alternating_size() {
  ConicSize size = middle_size();
  size.control = 0.3;
  size.slack = 1;
  size.spectral_radius = 1.02;
  return size;
}

/// Only equalities, at every knot and on the last state.
inline ConicSize equality_size() {
  return {.nx = kSmallSizes ? 8 : 20,
          .nu = kSmallSizes ? 5 : 10,
          .knots = kSmallSizes ? 15 : 60,
          .equalities = kSmallSizes ? 2 : 4,
          .boxes = 0,
          .cones = 0,
          .terminal = kSmallSizes ? 3 : 5};
}

/// 2226 rows, with the largest supported numbers of states, controls, and knots.
inline ConicSize large_size() {
  return {
      .nx = 40, .nu = 20, .knots = 100, .equalities = 2, .boxes = 8, .cones = 3, .terminal = 26};
}

/// A random problem with constraints that a random motion satisfies and that exclude the
/// unconstrained optimum. Jacobians are dense in state and control, except the terminal ones.
struct ConicLinearQuadratic {
  LinearQuadratic lq;
  double control;
  std::vector<Added> constraints;
  std::unique_ptr<ShootingProblem> problem;

  ConicLinearQuadratic(unsigned seed, const ConicSize& size);
};

}  // namespace conddp::testing
