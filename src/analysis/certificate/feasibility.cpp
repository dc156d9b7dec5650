#include "analysis/certificate/feasibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "analysis/certificate/lagrangian_gradient.hpp"
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

/// A multiplier may exceed its limit or leave its normal cone by this share: rounding.
constexpr double kLimitRounding = 1e-10;

/// Entries of Worst that stand for constraints: −2 for the first, then downward.
int entry_of(int constraint) { return -2 - constraint; }

void meet_control_bounds(const ShootingProblem& problem, const SolutionClaims& claims, int k,
                         Feasibility& found) {
  const KnotModel& model = *problem.knot(k).model;
  for (int i = 0; i < problem.nu(k); ++i) {
    const double u = claims.trajectory.u(k)[i];
    for (const bool upper : {false, true}) {
      const double bound = upper ? model.control_upper()[i] : model.control_lower()[i];
      const double z = (upper ? claims.upper_multipliers : claims.lower_multipliers)[k][i];
      found.negative.meet(-z, 0, k, i);
      if (std::isfinite(bound)) {
        const double outside = upper ? u - bound : bound - u;
        found.violation.meet(outside, std::abs(bound), k, i);
        found.product.meet(std::abs(z * outside), std::abs(z) * std::max(1.0, std::abs(bound)), k,
                           i);
      } else if (z != 0) {
        found.product.meet(std::numeric_limits<double>::infinity(), 0, k, i);
      }
    }
  }
}

/// Soft constraint: its multiplier stays within the limit. If the constraint is violated, the part
/// of the multiplier that pushes back equals the limit.
void meet_limit(const NodeConstraint& c, double outside, double pushing, double size, int entry,
                Feasibility& found) {
  found.product.meet(outside * std::abs(c.limit - pushing), c.limit * std::max(1.0, outside),
                     c.node, entry);
  if (size > (1 + kLimitRounding) * c.limit) found.negative.meet(size - c.limit, 0, c.node, entry);
}

/// The multiplier of row i belongs to the bound selected by its sign, which must be finite.
void meet_multiplier(const NodeConstraint& c, int i, double g, double nu, int entry,
                     Feasibility& found) {
  const double bound = nu > 0 ? c.upper[i] : c.lower[i];
  const double inside = nu > 0 ? bound - g : g - bound;
  if (std::isfinite(bound))
    found.product.meet(std::abs(nu) * std::max(0.0, inside),
                       std::abs(nu) * std::max(1.0, std::abs(bound)), c.node, entry);
  else
    found.negative.meet(std::abs(nu), 0, c.node, entry);
}

void meet_rows(const NodeConstraint& c, const double* g, const double* nu, int entry,
               Feasibility& found) {
  for (int i = 0; i < c.term->rows; ++i) {
    const double above = g[i] - c.upper[i], below = c.lower[i] - g[i];
    if (c.is_soft())
      meet_limit(c, std::max({above, below, 0.0}), above > 0 ? nu[i] : -nu[i], std::abs(nu[i]),
                 entry, found);
    else
      found.violation.meet(std::max(below, above), std::abs(g[i]), c.node, entry);
    if (nu[i] != 0 && c.lower[i] != c.upper[i]) meet_multiplier(c, i, g[i], nu[i], entry, found);
  }
}

void meet_cone(const NodeConstraint& c, const double* g, const double* nu, int entry,
               Feasibility& found) {
  const Eigen::Map<const Eigen::VectorXd> value(g, c.term->rows), multiplier(nu, c.term->rows);
  const double outside = beyond_cone(value).norm();
  if (!c.is_soft()) {
    found.violation.meet(outside, value.lpNorm<1>(), c.node, entry);
  } else if (multiplier.norm() > (1 + kLimitRounding) * c.limit) {
    found.negative.meet(multiplier.norm() - c.limit, 0, c.node, entry);
  }
  const double paid = c.is_soft() ? c.limit * outside : 0;
  found.product.meet(std::abs(value.dot(multiplier) - paid),
                     value.cwiseAbs().dot(multiplier.cwiseAbs()) + paid, c.node, entry);
  const double off = beyond_cone(-multiplier).norm();
  if (off > kLimitRounding * multiplier.norm()) found.negative.meet(off, 0, c.node, entry);
}

/// Pairs (z, s): the smaller entry must vanish and may have any multiplier; the multiplier of the
/// larger one must vanish. If both are equal, the second counts as larger, as in the solvers.
void meet_pairs(const NodeConstraint& c, const double* g, const double* nu, int entry,
                Feasibility& found) {
  for (int i = 0; i < c.term->rows; i += 2) {
    const int smaller = g[i] <= g[i + 1] ? i : i + 1, larger = 2 * i + 1 - smaller;
    found.violation.meet(std::abs(g[smaller]), std::abs(g[larger]), c.node, entry);
    found.product.meet(std::abs(nu[larger] * g[larger]), std::abs(nu[larger]), c.node, entry);
  }
}

}  // namespace

Eigen::VectorXd beyond_cone(const Eigen::VectorXd& s) {
  const Eigen::Index n = s.size() - 1;
  const double v = s.head(n).norm(), t = s[n];
  if (v <= t) return Eigen::VectorXd::Zero(n + 1);
  if (v <= -t) return s;
  Eigen::VectorXd d(n + 1);
  d.head(n) = s.head(n) * (0.5 * (v - t) / v);
  d[n] = -0.5 * (v - t);
  return d;
}

Feasibility measure_feasibility(const ShootingProblem& problem, const SolutionClaims& claims,
                                const Eigen::VectorXd& values) {
  Feasibility found;
  for (int k = 0; k < problem.knots(); ++k) meet_control_bounds(problem, claims, k, found);
  for (std::size_t i = 0; i < problem.constraints().size(); ++i) {
    const NodeConstraint& c = problem.constraints()[i];
    const auto meet = c.term->is_cone() ? meet_cone : c.term->has_pairs() ? meet_pairs : meet_rows;
    meet(c, values.data() + c.row, claims.multipliers.data() + c.row, entry_of(static_cast<int>(i)),
         found);
  }
  return found;
}

int constraint_of(const Worst& worst) { return worst.entry > -2 ? -1 : -2 - worst.entry; }

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
