#include "analysis/margins/margins.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <tuple>

#include "base/exceeds.hpp"

namespace conddp {
namespace {

/// A quantity is constant up to rounding if noise moves it by less than this share of the effects
/// of the single state coordinates: the gains hold it.
constexpr double kConstant = 1e-9;
/// The plan holds a quantity at a bound if their distance is at most kAtBound and noise moves it by
/// less than the share kHeld of its motion elsewhere.
constexpr double kAtBound = 1e-6, kHeld = 1e-4;

/// First knot that takes time, or N. Earlier knots (the choice of an initial state, an impulse)
/// belong to the start.
int first_timed_knot(const ShootingProblem& problem) {
  int k = 0;
  while (k < problem.knots() && problem.takes_no_time(k)) ++k;
  return k;
}

Eigen::MatrixXd diagonal_of_squares(const Eigen::VectorXd& sigma) {
  return sigma.cwiseAbs2().asDiagonal();
}

/// Collects margins node by node.
class MarginCollector {
 public:
  MarginCollector(const ShootingProblem& problem, const Trajectory& trajectory,
                  const std::vector<Eigen::MatrixXd>& gains, const StateNoise& noise)
      : problem_(problem),
        trajectory_(trajectory),
        gains_(gains),
        measurement_(noise.measurement),
        linear_(problem) {
    Evaluator(problem).differentiate(trajectory, linear_);
    covariance_ = propagate_covariance(problem, linear_, gains, noise);
    const auto is_finite = [](const Eigen::MatrixXd& P) { return P.allFinite(); };
    if (!std::all_of(covariance_.begin(), covariance_.end(), is_finite) ||
        !std::isfinite(measurement_.squaredNorm()))
      throw std::overflow_error("the covariances of the states are not finite");
  }

  std::vector<MarginCurve> collect() {
    for (int k = first_timed_knot(problem_); k < problem_.knots(); ++k)
      if (!problem_.takes_no_time(k)) add_control_bounds(k);
    for (const NodeConstraint& constraint : problem_.constraints())
      if (constraint.node >= first_timed_knot(problem_)) add_constraint(constraint);
    leave_out_held();
    sort_worst_first(curves_.begin(), curves_.end(),
                     [](const MarginCurve& curve) { return -curve.smallest().steps(); });
    return std::move(curves_);
  }

 private:
  using Row = Eigen::RowVectorXd;

  /// Drops quantities that the plan holds at a bound: solvers leave at most a trace of their gains.
  void leave_out_held() {
    std::map<std::pair<std::string, int>, double> largest;  // of both sides
    for (const MarginCurve& curve : curves_)
      for (const Margin& margin : curve.nodes) {
        double& sigma = largest[{curve.name, curve.row}];
        sigma = std::max(sigma, margin.sigma);
      }
    for (MarginCurve& curve : curves_)
      std::erase_if(curve.nodes, [&](const Margin& margin) {
        return margin.sigma < kHeld * largest[{curve.name, curve.row}] &&
               std::abs(margin.distance) <= kAtBound;
      });
    std::erase_if(curves_, [](const MarginCurve& curve) { return curve.nodes.empty(); });
  }

  /// Standard deviation at a node of a quantity with this gradient with respect to (δx, δu).
  double sigma_of(int k, const Row& gradient) const {
    const int n = problem_.ndx();
    const Row spread = covariance_[k].diagonal().cwiseMax(0).cwiseSqrt().transpose();
    Row by_state = gradient.head(n), by_gains = Row::Zero(n);
    if (k < problem_.knots()) by_gains = gradient.tail(gradient.size() - n) * gains_[k];
    const double reach = (by_state.cwiseAbs() + by_gains.cwiseAbs()).dot(spread);
    by_state += by_gains;
    double variance = by_state.dot(by_state * covariance_[k]);
    if (k < problem_.knots() && !problem_.takes_no_time(k))
      variance += by_gains.cwiseProduct(measurement_.transpose()).squaredNorm();
    const double sigma = std::sqrt(std::max(variance, 0.0));
    return sigma > kConstant * reach ? sigma : 0;
  }

  void add(const std::string& name, int row, bool upper, const Margin& margin) {
    if (!(margin.sigma > 0) || !std::isfinite(margin.distance)) return;
    const auto [place, is_new] = place_.try_emplace({name, row, upper}, curves_.size());
    if (is_new) curves_.push_back({name, row, upper, {}});
    std::vector<Margin>& nodes = curves_[place->second].nodes;
    if (nodes.empty() || nodes.back().knot != margin.knot)
      nodes.push_back(margin);
    else if (margin.steps() < nodes.back().steps())
      nodes.back() = margin;  // smallest of several contacts
  }

  /// Adds both sides of lower ≤ value ≤ upper, except for an equality.
  void add_interval(const std::string& name, int row, int k, double value, double lower,
                    double upper, const Row& gradient) {
    if (lower == upper) return;
    const double sigma = sigma_of(k, gradient);
    add(name, row, true, {k, upper - value, sigma});
    add(name, row, false, {k, value - lower, sigma});
  }

  void add_control_bounds(int k) {
    const KnotModel& model = *problem_.knot(k).model;
    for (int i = 0; i < model.nu(); ++i) {
      Row gradient = Row::Zero(model.nz());
      gradient[model.ndx() + i] = 1;
      add_interval(model.system().control_columns()[i].name, -1, k, trajectory_.u(k)[i],
                   model.control_lower()[i], model.control_upper()[i], gradient);
    }
  }

  void add_constraint(const NodeConstraint& constraint) {
    const ConstraintTerm& term = *constraint.term;
    const int k = constraint.node;
    const int first = constraint.row - problem_.constraint_offset(k);
    const Eigen::MatrixXd C = linear_.knots[k].C.middleRows(first, term.rows);
    const Eigen::VectorXd g = linear_.constraint.segment(constraint.row, term.rows);
    if (term.is_cone()) return add_cone(term.name, k, g, C);
    if (!term.has_bounds()) return;
    for (int i = 0; i < term.rows; ++i)
      add_interval(term.name, term.rows == 1 ? -1 : i, k, g[i], constraint.lower[i],
                   constraint.upper[i], C.row(i));
  }

  /// Adds ‖v‖ ≤ t with g = (v, t). On the axis of a cone, the slope of the norm counts as zero.
  void add_cone(const std::string& name, int k, const Eigen::VectorXd& g,
                const Eigen::MatrixXd& C) {
    const Eigen::Index last = g.size() - 1;
    const double norm = g.head(last).norm();
    Row gradient = -C.row(last);
    if (norm > 0) gradient += (g.head(last) / norm).transpose() * C.topRows(last);
    add(name, -1, true, {k, g[last] - norm, sigma_of(k, gradient)});
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const std::vector<Eigen::MatrixXd>& gains_;
  const Eigen::VectorXd& measurement_;
  Linearization linear_;
  std::vector<Eigen::MatrixXd> covariance_;
  std::map<std::tuple<std::string, int, bool>, std::size_t> place_;
  std::vector<MarginCurve> curves_;
};

}  // namespace

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

double Margin::probability() const { return std::erfc(steps() / std::numbers::sqrt2) / 2; }

const Margin& MarginCurve::smallest() const {
  const Margin* smallest = &nodes.front();
  for (const Margin& margin : nodes)
    if (exceeds(-margin.steps(), -smallest->steps())) smallest = &margin;
  return *smallest;
}

std::vector<MarginCurve> constraint_margins(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const std::vector<Eigen::MatrixXd>& gains,
                                            const StateNoise& noise) {
  return MarginCollector(problem, trajectory, gains, noise).collect();
}

}  // namespace conddp
