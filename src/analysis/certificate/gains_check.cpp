#include "analysis/certificate/gains_check.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "analysis/certificate/feasibility.hpp"
#include "analysis/derivatives/node_models.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Tolerance of the gain equations, relative to their terms. Feedforward equations add the
/// tolerance of the gradient. The constant kGainRounding is the rounding of sums over |J|ᵀ|V||J|,
/// for contact derivatives as badly conditioned as they may be.
constexpr double kGainTolerance = 1e-6, kGainRounding = 1e-14;
/// Smallest feedforward step, relative to the controls or absolute.
constexpr double kLeastMove = 1e-3;

/// Residuals of a sweep's equations with the answer's gains and these Hessians, in multiples of the
/// tolerances.
struct Deviation {
  Worst feedback, feedforward;
};

/// True if the answer's sweep held this control of a knot.
bool is_held(const ShootingProblem& problem, const SolutionClaims& claims, int k, int control) {
  const KnotModel& model = *problem.knot(k).model;
  const double u = claims.trajectory.u(k)[control] + claims.feedforward[k][control];
  const auto at = [u](double bound) {
    return std::isfinite(bound) && std::abs(u - bound) <= 1e-12 * std::max(1.0, std::abs(bound));
  };
  return (at(model.control_lower()[control]) || at(model.control_upper()[control])) &&
         claims.gains[k].row(control).isZero(0);
}

/// Inputs of the certificate's sweep.
struct SweepModel {
  const std::vector<NodeDerivatives>& derivatives;
  const std::vector<MatrixXd>& hessians;
};

/// Possible errors of the entries of one node's model.
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

/// A change that is not finite counts as zero.
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

/// A sweep along the answer's gains, backward node by node, and the residuals of its equations.
class ClaimedSweep {
 public:
  ClaimedSweep(const ShootingProblem& problem, const SolutionClaims& claims,
               const SweepModel& model, const MatrixXd& gap)
      : V(model.hessians.back()),
        v(model.derivatives.back().cost),
        claims_(claims),
        model_(model),
        gap_(gap),
        ndx_(problem.ndx()) {
    V.diagonal().array() += claims.gain_regularization;
  }

  /// Forms the equations of a node's stage; V and v are those of the next node.
  void enter(int k) {
    const MatrixXd &J = model_.derivatives[k].step, &K = claims_.gains[k];
    const Eigen::Index nu = K.rows();
    Q_ = model_.hessians[k];
    Q_.noalias() += J.transpose() * (V * J).eval();
    Q_.diagonal().array() += claims_.gain_regularization;
    q_ = model_.derivatives[k].cost + J.transpose() * (v + V * gap_.col(k));
    const auto Qux = Q_.bottomLeftCorner(nu, ndx_);
    Quu = Q_.bottomRightCorner(nu, nu);
    left = Quu * K + Qux;
    left_size = Quu.cwiseAbs() * K.cwiseAbs() + Qux.cwiseAbs();
    step_left = q_.tail(nu) + Quu * claims_.feedforward[k];
  }

  /// Updates V and v to the node that was entered.
  void leave(int k) {
    const MatrixXd& K = claims_.gains[k];
    const VectorXd& d = claims_.feedforward[k];
    const auto Qux = Q_.bottomLeftCorner(K.rows(), ndx_);
    v = q_.head(ndx_) + K.transpose() * step_left + Qux.transpose() * d;
    V = Q_.topLeftCorner(ndx_, ndx_) + K.transpose() * left + Qux.transpose() * K;
    V = (0.5 * (V + V.transpose())).eval();
  }

  MatrixXd V;  ///< Hessian of the cost to go, ndx x ndx
  VectorXd v;  ///< gradient of the cost to go
  MatrixXd Quu;
  MatrixXd left;       ///< Quu K + Qux
  MatrixXd left_size;  ///< sizes of its terms: |Quu| |K| + |Qux|
  VectorXd step_left;  ///< Quu k + qu

 private:
  const SolutionClaims& claims_;
  const SweepModel& model_;
  const MatrixXd& gap_;
  const Eigen::Index ndx_;
  MatrixXd Q_;
  VectorXd q_;
};

/// Bounds on the rounding errors of a sweep, carried along the given gains.
class CarriedRounding {
 public:
  CarriedRounding(const SolutionClaims& claims, const SweepModel& model, const MatrixXd& gap,
                  std::vector<NodeNoise> noise)
      : claims_(claims), model_(model), gap_(gap), noise_(std::move(noise)) {
    V_error_ = noise_.back().hessian.rowwise().sum().asDiagonal();
    v_error_ = noise_.back().cost.cwiseAbs2().asDiagonal();
  }

  /// Evaluates the errors at the node that the sweep has entered.
  void enter(int k, const ClaimedSweep& sweep) {
    const MatrixXd &J = model_.derivatives[k].step, &K = claims_.gains[k];
    const VectorXd& d = claims_.feedforward[k];
    const auto J_u = J.rightCols(K.rows());
    closed_loop_ = J.leftCols(J.rows()) + J_u * K;
    move_ = gap_.col(k) + J_u * d;
    const MatrixXd J_size = J.cwiseAbs(), V_size = sweep.V.cwiseAbs(), &J_off = noise_[k].step;
    const VectorXd next_size = sweep.v.cwiseAbs() + V_size * gap_.col(k).cwiseAbs();
    const MatrixXd V_moved = J_off.transpose() * V_size * (J_size + J_off);
    Q_off_ =
        kGainRounding * (J_size.transpose() * V_size * J_size + model_.hessians[k].cwiseAbs()) +
        V_moved + V_moved.transpose() + noise_[k].hessian;
    q_off_ =
        kGainRounding * (model_.derivatives[k].cost.cwiseAbs() + J_size.transpose() * next_size) +
        J_off.transpose() * next_size + noise_[k].cost;
    carried_ = V_error_ * closed_loop_;
    if (K.rows() == 0) return;
    const double K_largest = std::max(1.0, K.cwiseAbs().maxCoeff());
    const double d_largest = d.lpNorm<Eigen::Infinity>();
    const VectorXd rounding = Q_off_.bottomRows(K.rows()).rowwise().maxCoeff();
    feedback = rounding * K_largest + (J_u.transpose() * carried_).cwiseAbs().rowwise().maxCoeff();
    feedforward = q_off_.tail(K.rows()) + rounding * d_largest +
                  (J_u.transpose() * v_error_ * J_u).diagonal().cwiseMax(0).cwiseSqrt() +
                  (J_u.transpose() * V_error_ * move_).cwiseAbs();
  }

  /// Carries the errors over to the node that was entered.
  void leave(int k) {
    const MatrixXd K_size = claims_.gains[k].cwiseAbs();
    const Eigen::Index ndx = closed_loop_.rows(), nu = K_size.rows();
    const MatrixXd V_off = Q_off_.topLeftCorner(ndx, ndx) +
                           K_size.transpose() * Q_off_.bottomRightCorner(nu, nu) * K_size;
    const VectorXd v_off = q_off_.head(ndx) + K_size.transpose() * q_off_.tail(nu);
    v_error_ = (closed_loop_.transpose() * v_error_ * closed_loop_).eval();
    v_error_.diagonal() +=
        ((closed_loop_.transpose() * V_error_ * move_).cwiseAbs() + v_off).cwiseAbs2();
    V_error_ = closed_loop_.transpose() * carried_;
    // This diagonal bounds the rounding of the entries in every direction (Gershgorin).
    V_error_.diagonal() += V_off.rowwise().sum();
  }

  /// Errors in the equations of each control, nu.
  VectorXd feedback, feedforward;

 private:
  const SolutionClaims& claims_;
  const SweepModel& model_;
  const MatrixXd& gap_;
  std::vector<NodeNoise> noise_;
  MatrixXd V_error_, v_error_;  ///< errors of V; squared errors of v, as a covariance
  MatrixXd closed_loop_, Q_off_, carried_;
  VectorXd move_, q_off_;
};

/// Compares the residuals of a node's equations with their tolerances.
void meet_equations(const ShootingProblem& problem, const SolutionClaims& claims,
                    const ClaimedSweep& sweep, const CarriedRounding* rounding, int k,
                    Deviation& out) {
  const int nu = problem.nu(k);
  if (nu == 0) return;
  const VectorXd& d = claims.feedforward[k];
  const double step = std::max(kLeastMove * (1 + claims.trajectory.u(k).lpNorm<Eigen::Infinity>()),
                               d.lpNorm<Eigen::Infinity>());
  for (int i = 0; i < nu; ++i) {
    if (is_held(problem, claims, k, i)) continue;
    double tolerance = kGainTolerance * std::max(sweep.left_size.row(i).maxCoeff(),
                                                 kGainTolerance * sweep.Quu(i, i));
    double step_tolerance =
        kGainTolerance * (sweep.Quu.row(i).lpNorm<1>() * step + claims.tolerances.stationarity);
    if (rounding != nullptr) {
      tolerance += rounding->feedback[i];
      step_tolerance += rounding->feedforward[i];
    }
    out.feedback.meet(sweep.left.row(i).lpNorm<Eigen::Infinity>() / tolerance, tolerance, k, i);
    out.feedforward.meet(std::abs(sweep.step_left[i]) / step_tolerance, step_tolerance, k, i);
  }
}

/// Residuals over all knots; `rounding`, if given, adds to the tolerances.
Deviation compare(const ShootingProblem& problem, const SolutionClaims& claims,
                  const SweepModel& model, const MatrixXd& gap, CarriedRounding* rounding) {
  ClaimedSweep sweep(problem, claims, model, gap);
  Deviation out;
  for (int k = problem.knots() - 1; k >= 0; --k) {
    sweep.enter(k);
    if (rounding != nullptr) rounding->enter(k, sweep);
    meet_equations(problem, claims, sweep, rounding, k, out);
    sweep.leave(k);
    if (rounding != nullptr) rounding->leave(k);
  }
  return out;
}

bool holds(const Deviation& deviation) {
  return deviation.feedback.value <= 1 && deviation.feedforward.value <= 1;
}

Check check_of(const char* name, const ShootingProblem& problem, const Worst& worst) {
  Check check{name, worst.value <= 1};
  if (check.holds) return check;
  check.place = place_text(problem, worst.knot, control_name(problem, worst.knot, worst.entry));
  check.message =
      std::isfinite(worst.value) && std::isfinite(worst.size)
          ? fmt::format(
                "the equation of a sweep at the trajectory is off by {:.2g}, tolerance "
                "{:.1g}",
                worst.value * worst.size, worst.size)
          : "a sweep at the trajectory overflows, and nothing shows that the gains belong to it";
  return check;
}

}  // namespace

std::vector<Check> check_gains(const ShootingProblem& problem, const SolutionClaims& claims,
                               const std::vector<NodeDerivatives>& derivatives,
                               const std::vector<MatrixXd>& hessians, const MatrixXd& gap,
                               const DisplacedModel* displaced) {
  if (!problem.constraints().empty() || !std::isfinite(claims.gain_regularization)) return {};
  // Rounding errors are carried along only if the equations do not hold without them. `hessians_at`
  // returns the Hessians at the displaced trajectory.
  const auto deviation = [&](const std::vector<MatrixXd>& hessians_here, const auto& hessians_at) {
    const SweepModel model{derivatives, hessians_here};
    const Deviation plain = compare(problem, claims, model, gap, nullptr);
    if (holds(plain)) return plain;
    const auto noise = [&] {
      if (displaced == nullptr) return no_noise(model);
      const std::vector<MatrixXd> hessians_there = hessians_at(displaced->trajectory);
      return noise_of(model, {displaced->derivatives, hessians_there}, displaced->margin);
    };
    CarriedRounding rounding(claims, model, gap, noise());
    return compare(problem, claims, model, gap, &rounding);
  };
  Deviation found = deviation(hessians, [&](const Trajectory& trajectory) {
    return gauss_newton_hessians(problem, trajectory);
  });
  if (!(found.feedback.value <= 1)) {
    const auto exact_at = [&](const Trajectory& trajectory) {
      return exact_hessians(problem, trajectory, claims.costates);
    };
    const Deviation exact = deviation(exact_at(claims.trajectory), exact_at);
    if (!(exact.feedback.value > found.feedback.value)) found = exact;
  }
  return {check_of("feedback", problem, found.feedback),
          check_of(kFeedforwardCheck, problem, found.feedforward)};
}

}  // namespace conddp
