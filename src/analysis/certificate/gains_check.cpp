#include "analysis/certificate/gains_check.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "analysis/certificate/feasibility.hpp"
#include "analysis/certificate/place_text.hpp"
#include "ocp/evaluation/evaluator.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Two sweeps differ by what Q_uu's condition makes of the rounding of derivatives, which may be
/// all of the gains where no cost sees a control: relative tolerance of gains, and the share of
/// |J|ᵀ|V||J| that rounding is where that cancels.
constexpr double kGainTolerance = 1e-6, kGainRounding = 1e-15;

/// How far the answer's gains are from those of a sweep with these Hessians, in tolerances.
struct Deviation {
  Worst feedback, feedforward;
};

/// Controls that the answer's sweep held.
std::vector<bool> held_controls(const ShootingProblem& problem, const SolutionClaims& claims,
                                int k) {
  const KnotModel& model = *problem.knot(k).model;
  std::vector<bool> held(problem.nu(k));
  for (int i = 0; i < problem.nu(k); ++i) {
    const double u = claims.trajectory.u(k)[i] + claims.feedforward[k][i];
    const auto at = [&](double bound) {
      return std::isfinite(bound) && std::abs(u - bound) <= 1e-12 * std::max(1.0, std::abs(bound));
    };
    held[i] = (at(model.control_lower()[i]) || at(model.control_upper()[i])) &&
              claims.gains[k].row(i).isZero(0);
  }
  return held;
}

Deviation compare(const ShootingProblem& problem, const SolutionClaims& claims,
                  const std::vector<NodeDerivatives>& derivatives, const MatrixXd& gap,
                  const Linearization& model) {
  const int N = problem.knots(), ndx = problem.ndx();
  // A proximal term is a cost of the model; the other kind is in the gains alone.
  const bool in_model = claims.gain_regularization_kind == RegularizationKind::proximal;
  const double model_weight = in_model ? claims.gain_regularization : 0;
  MatrixXd V = model.knots[N].hessian();
  V.diagonal().array() += model_weight;
  VectorXd v = derivatives[N].cost;
  // What rounding may have made of V, carried along the policy as V itself is.
  MatrixXd error = MatrixXd::Zero(ndx, ndx);
  Deviation out;
  for (int k = N - 1; k >= 0; --k) {
    const MatrixXd& J = derivatives[k].step;
    const int nu = problem.nu(k);
    MatrixXd Q = model.knots[k].hessian() + J.transpose() * V * J;
    Q.diagonal().array() += model_weight;
    const double summands =
        (J.cwiseAbs().transpose() * V.cwiseAbs() * J.cwiseAbs()).eval().maxCoeff();
    const VectorXd q = derivatives[k].cost + J.transpose() * (v + V * gap.col(k));
    const std::vector<bool> held = held_controls(problem, claims, k);
    MatrixXd Quu = Q.bottomRightCorner(nu, nu);
    Quu.diagonal().array() += claims.gain_regularization - model_weight;
    MatrixXd right = -Q.bottomLeftCorner(nu, ndx);
    VectorXd step = -q.tail(nu);
    VectorXd fixed = VectorXd::Zero(nu);
    for (int i = 0; i < nu; ++i)
      if (held[i]) fixed[i] = claims.feedforward[k][i];
    step -= Quu * fixed;
    for (int i = 0; i < nu; ++i) {
      if (!held[i]) continue;
      Quu.row(i).setZero();
      Quu.col(i).setZero();
      Quu(i, i) = 1;
      right.row(i).setZero();
      step[i] = 0;
    }
    const Eigen::LDLT<MatrixXd> factors(Quu);
    const MatrixXd K = factors.solve(right);
    const VectorXd d = factors.solve(step) + fixed;
    const double size = nu > 0 ? std::max(1e-6, K.cwiseAbs().maxCoeff()) : 1;
    const MatrixXd J_u = J.rightCols(nu), closed_loop = J.leftCols(ndx) + J_u * K;
    const MatrixXd carried = error * closed_loop;
    const double rounding =
        nu > 0 ? (kGainRounding * summands + (J_u.transpose() * carried).cwiseAbs().maxCoeff()) /
                     factors.vectorD().cwiseAbs().minCoeff()
               : 0;
    error = closed_loop.transpose() * carried;
    error.diagonal().array() += kGainRounding * summands;
    const double tolerance = std::max(rounding / size, kGainTolerance);
    const double move =
        nu > 0 ? std::max(1e-3 * claims.trajectory.u(k).lpNorm<Eigen::Infinity>() + 1e-3,
                          d.lpNorm<Eigen::Infinity>())
               : 1;
    // Near an optimum q is what is left of terms that cancel.
    const VectorXd terms =
        derivatives[k].cost.cwiseAbs() +
        J.cwiseAbs().transpose() * (v.cwiseAbs() + V.cwiseAbs() * gap.col(k).cwiseAbs());
    const double step_tolerance =
        nu > 0 ? tolerance * move +
                     kGainRounding * terms.maxCoeff() / factors.vectorD().cwiseAbs().minCoeff()
               : 1;
    for (int i = 0; i < nu; ++i) {
      out.feedforward.meet(std::abs(d[i] - claims.feedforward[k][i]) / step_tolerance,
                           step_tolerance, k, i);
      for (int j = 0; j < ndx; ++j)
        out.feedback.meet(std::abs(K(i, j) - claims.gains[k](i, j)) / (tolerance * size),
                          tolerance * size, k, i);
    }
    const auto Qux = Q.bottomLeftCorner(nu, ndx);
    const auto unregularised = Q.bottomRightCorner(nu, nu);
    v = (q.head(ndx) + K.transpose() * (unregularised * d + q.tail(nu)) + Qux.transpose() * d)
            .eval();
    V = (Q.topLeftCorner(ndx, ndx) + K.transpose() * unregularised * K + K.transpose() * Qux +
         Qux.transpose() * K)
            .eval();
    V = (0.5 * (V + V.transpose())).eval();
  }
  return out;
}

Check check_of(const char* name, const ShootingProblem& problem, const Worst& worst) {
  Check check{name, worst.value <= 1};
  if (check.holds) return check;
  check.place = place_text(problem, worst.knot, control_name(problem, worst.knot, worst.entry));
  check.message = fmt::format("off by {:.2g} from a sweep at the trajectory, tolerance {:.1g}",
                              worst.value * worst.size, worst.size);
  return check;
}

}  // namespace

std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const MatrixXd& gap) {
  if (!problem.constraints().empty() || !std::isfinite(claims.gain_regularization)) return {};
  if (claims.gain_regularization_kind == RegularizationKind::state &&
      claims.gain_regularization > 0)
    return {};
  Evaluator evaluator(problem);
  Linearization model(problem);
  evaluator.differentiate(claims.trajectory, model);
  Deviation found = compare(problem, claims, derivatives, gap, model);
  if (!(found.feedback.value <= 1)) {
    evaluator.reserve_lagrangian_hessian();
    evaluator.lagrangian_hessian(claims.trajectory, claims.costates, model);
    const Deviation exact = compare(problem, claims, derivatives, gap, model);
    if (!(exact.feedback.value > found.feedback.value)) found = exact;
  }
  return {check_of("feedback", problem, found.feedback),
          check_of("feedforward", problem, found.feedforward)};
}

}  // namespace conddp
