#include "analysis/certificate/kinks.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <fmt/format.h>

#include "analysis/certificate/motion_ranges.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/node_values.hpp"

namespace conddp {
namespace {

using Eigen::VectorXd;

/// Number of random directions, each followed to both sides.
constexpr int kDirections = 2;
/// Steps in ranges. A tenth of a step leaves a hundredth of the remainder of a smooth function, a
/// tenth of that of a kink, and all of that of a jump.
constexpr double kSteps[] = {1e-4, 1e-5, 1e-6, 1e-7};
constexpr double kLeastRatio = 1.0 / 20;
/// Smallest fall that counts at one node, and over all nodes, as shares of the cost.
constexpr double kOfNode = 1e-6, kOfAll = 1e-4;

class KinkSearch {
 public:
  KinkSearch(const JudgedPoint& point, double cost_size)
      : point_(point),
        problem_(point.problem),
        ranges_(problem_, point.trajectory),
        least_(kOfNode * cost_size),
        nodes_(problem_),
        evaluator_(problem_),
        here_(problem_),
        there_(problem_),
        worst_(problem_.knots() + 1) {}

  std::vector<FallingKink> run() {
    evaluator_.evaluate(point_.trajectory, here_);
    std::mt19937_64 engine(3);
    for (int direction = 0; direction < kDirections; ++direction) {
      std::vector<VectorXd> moves;
      for (int k = 0; k <= problem_.knots(); ++k) {
        VectorXd move = ranges_.unit(problem_, k);
        for (double& entry : move) entry *= 2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1;
        moves.push_back(std::move(move));
      }
      for (const double sign : {1.0, -1.0}) look(moves, sign);
    }
    std::erase_if(worst_, [](const FallingKink& kink) { return kink.node < 0; });
    return std::move(worst_);
  }

 private:
  /// Follows a direction to one side at all nodes at once, and more closely where the Lagrangian
  /// falls below its slope.
  void look(std::vector<VectorXd> moves, double sign) {
    const int ndx = problem_.ndx();
    Trajectory moved = point_.trajectory;
    for (int k = 0; k <= problem_.knots(); ++k) {
      moves[k] *= sign;
      if (k < problem_.knots()) stay_within_bounds(k, moves[k]);
      const VectorXd step = kSteps[0] * moves[k];
      problem_.manifold().integrate(moved.x(k).data(), step.data(), moved.x(k).data());
      if (k < problem_.knots()) moved.u(k) += step.tail(step.size() - ndx);
    }
    evaluator_.evaluate(moved, there_);
    for (int k = 0; k <= problem_.knots(); ++k) {
      double change = there_.cost[k] - here_.cost[k];
      const int row = problem_.constraint_offset(k);
      const int rows = static_cast<int>(point_.derivatives[k].constraint.rows());
      change += point_.multipliers.segment(row, rows).dot(there_.constraint.segment(row, rows) -
                                                          here_.constraint.segment(row, rows));
      if (k < problem_.knots())
        change += point_.costates.col(k + 1).dot(there_.gap.col(k) - here_.gap.col(k) +
                                                 kSteps[0] * moves[k + 1].head(ndx));
      if (change - kSteps[0] * slope(k, moves[k]) < -least_ * kSteps[0]) follow(k, moves[k]);
    }
  }

  void stay_within_bounds(int k, VectorXd& move) const {
    const KnotModel& model = *problem_.knot(k).model;
    for (int i = 0; i < problem_.nu(k); ++i) {
      double& entry = move[problem_.ndx() + i];
      const double u = point_.trajectory.u(k)[i] + kSteps[0] * entry;
      if (u < model.control_lower()[i] || u > model.control_upper()[i]) entry = 0;
    }
  }

  /// Slope of a node's Lagrangian along a move.
  double slope(int k, const VectorXd& move) const {
    const NodeDerivatives& d = point_.derivatives[k];
    double sum = d.cost.dot(move);
    if (d.constraint.rows() > 0)
      sum += point_.multipliers.segment(problem_.constraint_offset(k), d.constraint.rows())
                 .dot(d.constraint * move);
    if (d.step.rows() > 0) sum += point_.costates.col(k + 1).dot(d.step * move);
    return sum;
  }

  /// The parts of a node's Lagrangian at a multiple of a move: costs, constraints, dynamics.
  VectorXd parts(int k, const VectorXd& move, double step) {
    const int ndx = problem_.ndx(), nu = static_cast<int>(move.size()) - ndx;
    VectorXd x(problem_.nx()), u(nu), dx = step * move.head(ndx);
    problem_.manifold().integrate(point_.trajectory.x(k).data(), dx.data(), x.data());
    const bool last = k == problem_.knots();
    if (!last) u = point_.trajectory.u(k) + step * move.tail(nu);
    const KnotWorkspace<double>& work = nodes_.at(k, x.data(), last ? nullptr : u.data());
    const auto& costs = problem_.knot(k).model->costs();
    const auto& constraints = problem_.knot(k).model->constraints();
    VectorXd out = VectorXd::Zero(costs.size() + constraints.size() + 2);
    double sum = 0;
    for (std::size_t i = 0; i < costs.size(); ++i) sum += out[i] = work.term_costs[i];
    for (std::size_t i = 0; i < constraints.size(); ++i)
      out[costs.size() + i] =
          point_.multipliers
              .segment(problem_.constraint_offset(k) + constraints[i].row, constraints[i].rows)
              .dot(Eigen::Map<const VectorXd>(work.constraint.data() + constraints[i].row,
                                              constraints[i].rows));
    if (!last) {
      problem_.manifold().difference(point_.trajectory.x(k + 1).data(), work.next().data(),
                                     dx.data());
      out[out.size() - 2] = point_.costates.col(k + 1).dot(dx);
    }
    out[out.size() - 1] = work.cost - sum;  // l2-soft constraints
    return out;
  }

  void follow(int k, const VectorXd& move) {
    const VectorXd here = parts(k, move, 0);
    const double slope = this->slope(k, move);
    double before = 0;
    for (const double step : kSteps) {
      const double below = (parts(k, move, step) - here).sum() - step * slope;
      if (!(below < -least_ * step) || below > kLeastRatio * before) return;
      before = below;
    }
    const double last = *std::rbegin(kSteps);
    if (const double fall = -before / last; fall > worst_[k].fall)
      worst_[k] = {k, part(k, move, last, here), fall};
  }

  /// Name of the part that falls to both sides most.
  std::string part(int k, const VectorXd& move, double step, const VectorXd& here) {
    const VectorXd bend = parts(k, move, step) + parts(k, move, -step) - 2 * here;
    Eigen::Index most = 0;
    bend.minCoeff(&most);
    const auto& costs = problem_.knot(k).model->costs();
    const auto& constraints = problem_.knot(k).model->constraints();
    const std::size_t i = static_cast<std::size_t>(most);
    if (i < costs.size()) return fmt::format("cost '{}'", costs[i].name);
    if (i < costs.size() + constraints.size())
      return fmt::format("constraint '{}'", constraints[i - costs.size()].name);
    return most == bend.size() - 1 ? "a soft constraint" : "the dynamics";
  }

  const JudgedPoint& point_;
  const ShootingProblem& problem_;
  MotionRanges ranges_;
  double least_;
  NodeEvaluation nodes_;
  Evaluator evaluator_;
  Evaluation here_, there_;  ///< at the point, and along a move
  std::vector<FallingKink> worst_;
};

}  // namespace

std::optional<FallingKink> find_falling_kink(const JudgedPoint& point, double cost_size) {
  const std::vector<FallingKink> kinks = KinkSearch(point, cost_size).run();
  if (kinks.empty()) return std::nullopt;
  FallingKink out = *std::ranges::max_element(kinks, {}, &FallingKink::fall);
  out.fall = 0;
  for (const FallingKink& kink : kinks) out.fall += kink.fall;
  if (out.fall <= kOfAll * cost_size) return std::nullopt;
  return out;
}

}  // namespace conddp
