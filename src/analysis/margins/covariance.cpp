#include "analysis/margins/covariance.hpp"

namespace conddp {
namespace {

Eigen::MatrixXd diagonal_of_squares(const Eigen::VectorXd& sigma) {
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace

int first_timed_knot(const ShootingProblem& problem) {
  int k = 0;
  while (k < problem.knots() && problem.takes_no_time(k)) ++k;
  return k;
}

std::vector<Eigen::MatrixXd> propagate_covariance(const ShootingProblem& problem,
                                                  const Linearization& linear,
                                                  const std::vector<Eigen::MatrixXd>& gains,
                                                  const StateNoise& noise) {
  const int N = problem.knots(), n = problem.ndx(), first = first_timed_knot(problem);
  std::vector<Eigen::MatrixXd> P(N + 1, Eigen::MatrixXd::Zero(n, n));
  P[first] = diagonal_of_squares(noise.initial);
  for (int k = first; k < N; ++k) {
    const Eigen::MatrixXd F = linear.knots[k].dense_jacobian();
    const Eigen::MatrixXd BK = F.rightCols(problem.nu(k)) * gains[k];
    const Eigen::MatrixXd closed = F.leftCols(n) + BK;
    P[k + 1] = closed * P[k] * closed.transpose();
    if (problem.takes_no_time(k)) continue;
    P[k + 1] += BK * diagonal_of_squares(noise.measurement) * BK.transpose();
    P[k + 1] += diagonal_of_squares(noise.process);
  }
  return P;
}

}  // namespace conddp
