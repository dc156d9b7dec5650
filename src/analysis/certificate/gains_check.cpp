#include "analysis/certificate/gains_check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/certificate/feasibility.hpp"
#include "analysis/certificate/node_hessians.hpp"
#include "analysis/certificate/place_text.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of the equations of the gains, relative to their terms; and what rounding leaves of sums over
/// |J|ᵀ|V||J|, of derivatives of contacts as badly conditioned as they may be.
constexpr double kGainTolerance = 1e-6, kGainRounding = 1e-14;
/// Of feedforward terms: relative to controls, or absolute.
constexpr double kLeastMove = 1e-3;

/// How far the answer's gains are from solving the equations of a sweep with these Hessians, in
/// tolerances.
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

/// What the sweep of the certificate is made from.
struct SweepModel {
  const std::vector<NodeDerivatives>& derivatives;
  std::vector<MatrixXd> hessians;
};

/// How far the entries of one node's model may be off.
struct NodeNoise {
  VectorXd cost;
  MatrixXd step, hessian;
};

std::vector<NodeNoise> no_noise(const SweepModel& model) {
  std::vector<NodeNoise> noise;
  for (std::size_t k = 0; k < model.hessians.size(); ++k) {
    const MatrixXd& J = model.derivatives[k].step;
    noise.push_back({VectorXd::Zero(model.derivatives[k].cost.size()),
                     MatrixXd::Zero(J.rows(), J.cols()),
                     MatrixXd::Zero(model.hessians[k].rows(), model.hessians[k].cols())});
  }
  return noise;
}

/// A change that is not finite says nothing.
template <class Matrix>
Matrix finite_change(const Matrix& a, const Matrix& b, double margin) {
  return (margin * (a - b).cwiseAbs()).unaryExpr([](double change) {
    return std::isfinite(change) ? change : 0;
  });
}

std::vector<NodeNoise> noise_of(const SweepModel& here, const SweepModel& there, double margin) {
  std::vector<NodeNoise> noise;
  for (std::size_t k = 0; k < here.hessians.size(); ++k) {
    const NodeDerivatives &a = here.derivatives[k], &b = there.derivatives[k];
    noise.push_back({finite_change(a.cost, b.cost, margin), finite_change(a.step, b.step, margin),
                     finite_change(here.hessians[k], there.hessians[k], margin)});
  }
  return noise;
}

Deviation compare(const ShootingProblem& problem, const SolutionClaims& claims,
                  const SweepModel& model, const MatrixXd& gap,
                  const std::vector<NodeNoise>& noise) {
  const int N = problem.knots(), ndx = problem.ndx();
  // A proximal term is a cost of the model; the other kind is in the gains alone.
  const bool in_model = claims.gain_regularization_kind == RegularizationKind::proximal;
  const double model_weight = in_model ? claims.gain_regularization : 0;
  MatrixXd V = model.hessians[N];
  V.diagonal().array() += model_weight;
  VectorXd v = model.derivatives[N].cost;
  // What rounding may have made of V and v, carried along the policy as they are.
  MatrixXd V_error = noise[N].hessian.rowwise().sum().asDiagonal();
  MatrixXd v_error = noise[N].cost.cwiseAbs2().asDiagonal();  // squared, as a covariance is
  Deviation out;
  for (int k = N - 1; k >= 0; --k) {
    const MatrixXd &J = model.derivatives[k].step, &hessian = model.hessians[k];
    const VectorXd& cost = model.derivatives[k].cost;
    const int nu = problem.nu(k);
    const MatrixXd& K = claims.gains[k];
    const VectorXd& d = claims.feedforward[k];
    const auto J_u = J.rightCols(nu);
    const MatrixXd closed_loop = J.leftCols(ndx) + J_u * K;
    const VectorXd move = gap.col(k) + J_u * d;
    MatrixXd Q = hessian + J.transpose() * V * J;
    Q.diagonal().array() += model_weight;
    const VectorXd q = cost + J.transpose() * (v + V * gap.col(k));
    const auto Qux = Q.bottomLeftCorner(nu, ndx);
    const auto unregularised = Q.bottomRightCorner(nu, nu);
    MatrixXd Quu = unregularised;
    Quu.diagonal().array() += claims.gain_regularization - model_weight;
    const MatrixXd left = Quu * K + Qux;
    const VectorXd step_left = Quu * d + q.tail(nu);

    const MatrixXd J_size = J.cwiseAbs(), V_size = V.cwiseAbs(), &J_off = noise[k].step;
    const VectorXd next_size = v.cwiseAbs() + V_size * gap.col(k).cwiseAbs();
    const MatrixXd V_moved = J_off.transpose() * V_size * (J_size + J_off);
    const MatrixXd Q_off =
        kGainRounding * (J_size.transpose() * V_size * J_size + hessian.cwiseAbs()) + V_moved +
        V_moved.transpose() + noise[k].hessian;
    const VectorXd q_off = kGainRounding * (cost.cwiseAbs() + J_size.transpose() * next_size) +
                           J_off.transpose() * next_size + noise[k].cost;
    const MatrixXd carried = V_error * closed_loop;
    if (nu > 0) {
      const double K_largest = std::max(1.0, K.cwiseAbs().maxCoeff());
      const double d_largest = d.lpNorm<Eigen::Infinity>();
      const double step =
          std::max(kLeastMove * (1 + claims.trajectory.u(k).lpNorm<Eigen::Infinity>()), d_largest);
      const MatrixXd terms = Quu.cwiseAbs() * K.cwiseAbs() + Qux.cwiseAbs();
      const MatrixXd J_carried = J_u.transpose() * carried;
      const VectorXd step_carried =
          (J_u.transpose() * v_error * J_u).diagonal().cwiseMax(0).cwiseSqrt() +
          (J_u.transpose() * V_error * move).cwiseAbs();
      const std::vector<bool> held = held_controls(problem, claims, k);
      for (int i = 0; i < nu; ++i) {
        if (held[i]) continue;
        const double rounding = Q_off.row(ndx + i).maxCoeff();
        const double tolerance =
            kGainTolerance * std::max(terms.row(i).maxCoeff(), kGainTolerance * Quu(i, i)) +
            rounding * K_largest + J_carried.row(i).cwiseAbs().maxCoeff();
        out.feedback.meet(left.row(i).lpNorm<Eigen::Infinity>() / tolerance, tolerance, k, i);
        const double step_tolerance = kGainTolerance * Quu.row(i).lpNorm<1>() * step +
                                      q_off[ndx + i] + rounding * d_largest + step_carried[i];
        out.feedforward.meet(std::abs(step_left[i]) / step_tolerance, step_tolerance, k, i);
      }
    }
    v = (q.head(ndx) + K.transpose() * (unregularised * d + q.tail(nu)) + Qux.transpose() * d)
            .eval();
    V = (Q.topLeftCorner(ndx, ndx) + K.transpose() * unregularised * K + K.transpose() * Qux +
         Qux.transpose() * K)
            .eval();
    V = (0.5 * (V + V.transpose())).eval();
    const MatrixXd K_size = K.cwiseAbs();
    const MatrixXd V_off = Q_off.topLeftCorner(ndx, ndx) +
                           K_size.transpose() * Q_off.bottomRightCorner(nu, nu) * K_size;
    const VectorXd v_off = q_off.head(ndx) + K_size.transpose() * q_off.tail(nu);
    v_error = (closed_loop.transpose() * v_error * closed_loop).eval();
    v_error.diagonal() +=
        ((closed_loop.transpose() * V_error * move).cwiseAbs() + v_off).cwiseAbs2();
    V_error = closed_loop.transpose() * carried;
    // A diagonal that no rounding of the entries exceeds in any direction (Gershgorin).
    V_error.diagonal() += V_off.rowwise().sum();
  }
  return out;
}

Check check_of(const char* name, const ShootingProblem& problem, const Worst& worst) {
  Check check{name, worst.value <= 1};
  if (check.holds) return check;
  check.place = place_text(problem, worst.knot, control_name(problem, worst.knot, worst.entry));
  check.message =
      fmt::format("the equation of a sweep at the trajectory is off by {:.2g}, tolerance {:.1g}",
                  worst.value * worst.size, worst.size);
  return check;
}

}  // namespace

std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<MatrixXd>& hessians, const MatrixXd& gap,
                               const DisplacedModel* displaced) {
  if (!problem.constraints().empty() || !std::isfinite(claims.gain_regularization)) return {};
  if (claims.gain_regularization_kind == RegularizationKind::state &&
      claims.gain_regularization > 0)
    return {};
  const auto deviation = [&](const auto& hessians_at) {
    const SweepModel model{derivatives, hessians_at(claims.trajectory)};
    if (displaced == nullptr) return compare(problem, claims, model, gap, no_noise(model));
    const SweepModel there{displaced->derivatives, hessians_at(displaced->trajectory)};
    return compare(problem, claims, model, gap, noise_of(model, there, displaced->margin));
  };
  Deviation found = deviation([&](const Trajectory& trajectory) {
    return &trajectory == &claims.trajectory ? hessians
                                             : gauss_newton_hessians(problem, trajectory);
  });
  if (!(found.feedback.value <= 1)) {
    const Deviation exact = deviation([&](const Trajectory& trajectory) {
      return exact_hessians(problem, trajectory, claims.costates);
    });
    if (!(exact.feedback.value > found.feedback.value)) found = exact;
  }
  return {check_of("feedback", problem, found.feedback),
          check_of(kFeedforwardCheck, problem, found.feedforward)};
}

}  // namespace conddp
