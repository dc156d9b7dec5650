#include "analysis/certificate/infeasibility.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/certificate/feasibility.hpp"
#include "analysis/certificate/reduced_gradient.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/violation_problem.hpp"

namespace conddp {
namespace {

using Eigen::VectorXd;

/// The smaller value of each pair, which must be zero.
VectorXd from_pairs(const VectorXd& g) {
  VectorXd d = VectorXd::Zero(g.size());
  for (Eigen::Index i = 0; i + 1 < g.size(); i += 2) {
    const Eigen::Index smaller = g[i] <= g[i + 1] ? i : i + 1;
    d[smaller] = g[smaller];
  }
  return d;
}

VectorXd from_set(const NodeConstraint& c, const VectorXd& g) {
  if (c.term->is_cone()) return beyond_cone(g);
  if (c.term->has_pairs()) return from_pairs(g);
  VectorXd d = VectorXd::Zero(g.size());
  for (Eigen::Index i = 0; i < g.size(); ++i) {
    if (g[i] > c.upper[i]) d[i] = g[i] - c.upper[i];
    if (g[i] < c.lower[i]) d[i] = g[i] - c.lower[i];
  }
  return d;
}

/// Distance that a control can move downhill along a slope; nullopt without a bound there.
std::optional<double> way_down(const KnotModel& model, int i, double u, double slope) {
  const double way = slope < 0 ? model.control_upper()[i] - u : u - model.control_lower()[i];
  return std::isfinite(way) ? std::optional(std::max(0.0, way)) : std::nullopt;
}

double largest_control(const ShootingProblem& problem, const Trajectory& trajectory) {
  double largest = 1;
  for (int k = 0; k < problem.knots(); ++k)
    for (const double u : trajectory.u(k)) largest = std::max(largest, std::abs(u));
  return largest;
}

}  // namespace

double attainable_share(const ShootingProblem& problem, const Trajectory& trajectory,
                        const std::vector<NodeDerivatives>& derivatives, const VectorXd& values) {
  VectorXd distances = VectorXd::Zero(values.size());
  for (const NodeConstraint& c : problem.constraints())
    if (!c.is_soft())
      distances.segment(c.row, c.term->rows) = from_set(c, values.segment(c.row, c.term->rows));
  std::vector<NodeDerivatives> without_cost = derivatives;
  for (NodeDerivatives& d : without_cost) d.cost.setZero();
  const AdjointPass pass = adjoint_pass(problem, without_cost, distances, {});
  const double largest = largest_control(problem, trajectory);
  double sum = 0;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) {
      const double slope = pass.control[k][i];
      const auto way = way_down(*problem.knot(k).model, i, trajectory.u(k)[i], slope);
      sum += std::abs(slope) * way.value_or(largest);
    }
  return sum / distances.squaredNorm();
}

SecondOrder violation_model(const ShootingProblem& problem, const Trajectory& trajectory,
                            const Eigen::MatrixXd& gaps) {
  const ShootingProblem violation = violation_problem(problem);
  const NodeValues values(violation, trajectory);
  double cost = 0;
  for (int k = 0; k <= violation.knots(); ++k)
    for (const double own : values.soft_costs(k)) cost += own;
  const NodeModels models = node_models(violation, trajectory, gaps);
  const VectorXd multipliers = VectorXd::Zero(violation.constraint_rows());
  const RiccatiPolicy policy =
      riccati_policy(violation, trajectory, models.derivatives, models.hessians);
  const AdjointPass pass = adjoint_pass(violation, models.derivatives, multipliers, policy.K);
  return second_order({violation, trajectory, gaps, models.derivatives, models.hessians,
                       values.constraint(), multipliers, pass.costates, pass.control, cost, 0});
}

}  // namespace conddp
