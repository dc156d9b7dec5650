#include "analysis/certificate/solution_claims.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {

SolutionClaims::SolutionClaims(const ShootingProblem& problem)
    : trajectory(problem.create_trajectory()),
      costates(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      state_gradient(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      multipliers(Eigen::VectorXd::Zero(problem.constraint_rows())) {
  for (int k = 0; k < problem.knots(); ++k) {
    lower_multipliers.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    upper_multipliers.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    feedforward.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    gains.emplace_back(Eigen::MatrixXd::Zero(problem.nu(k), problem.ndx()));
  }
}

namespace {

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }
template <class Derived>
bool same(const Eigen::PlainObjectBase<Derived>& a, const Eigen::PlainObjectBase<Derived>& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::equal(a.data(), a.data() + a.size(), b.data(),
                    [](double x, double y) { return same(x, y); });
}
template <class T>
bool same(const std::vector<T>& a, const std::vector<T>& b) {
  return std::ranges::equal(a, b, [](const T& x, const T& y) { return same(x, y); });
}

}  // namespace

bool SolutionClaims::operator==(const SolutionClaims& o) const {
  const auto figures = [](const SolutionClaims& c) {
    const SolverOptions::Tolerances& t = c.tolerances;
    return std::vector<double>{c.cost,
                               c.stationarity,
                               c.gap,
                               c.constraint,
                               c.complementarity,
                               c.gain_regularization,
                               t.stationarity,
                               t.gap,
                               t.constraint,
                               t.complementarity,
                               t.cost_decrease};
  };
  return trajectory == o.trajectory && converged == o.converged && status == o.status &&
         gain_regularization_kind == o.gain_regularization_kind && cost_by_name == o.cost_by_name &&
         tangent_names == o.tangent_names && same(figures(*this), figures(o)) &&
         same(times, o.times) && same(costates, o.costates) &&
         same(state_gradient, o.state_gradient) && same(lower_multipliers, o.lower_multipliers) &&
         same(upper_multipliers, o.upper_multipliers) && same(multipliers, o.multipliers) &&
         same(gains, o.gains) && same(feedforward, o.feedforward);
}

}  // namespace conddp
