#include "analysis/certificate/coarse_grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>

#include "analysis/certificate/replay.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Ratio of a step's error to its difference from two half steps: 1 / (1 − 2⁻ᵖ) for order p.
double extrapolation(Integrator rule) { return 1 / (1 - std::pow(0.5, info_of(rule).order)); }

/// The planned steps in turn, each divided into parts and into halves of these parts.
class PlannedSteps {
 public:
  PlannedSteps(const ShootingProblem& problem, const Trajectory& trajectory,
               std::optional<Integrator> rule, int parts)
      : problem_(problem), trajectory_(trajectory), rule_(rule), parts_(parts) {}

  bool has_error(int k) const {
    const KnotModel& model = *problem_.knot(k).model;
    return !problem_.takes_no_time(k) && info_of(model.integrator()).order > 0 &&
           model.system().as_stepping() == nullptr;
  }
  Integrator rule(int k) const { return rule_.value_or(problem_.knot(k).model->integrator()); }

  /// Estimated error of the step of a knot, as a tangent vector.
  void error(int k, Eigen::VectorXd& out) {
    const Eigen::VectorXd once = run(k, parts_), twice = run(k, 2 * parts_);
    problem_.manifold().difference(once.data(), twice.data(), out.data());
    out *= extrapolation(rule(k));
  }

 private:
  Eigen::VectorXd run(int k, int steps) {
    const KnotModel& model = *problem_.knot(k).model;
    auto& stepper = steppers_[&model];
    if (!stepper) stepper = std::make_unique<ReplayStep>(model, rule(k));
    Eigen::VectorXd x = trajectory_.x(k);
    Eigen::VectorXd from = model.step().first_control(x, trajectory_.u(k)), to = from;
    const double dt = model.step().time_step(problem_.knot(k).dt, x.data()) / steps;
    for (int s = 0; s < steps; ++s) {
      stepper->look(x.data(), from.data());
      to += (trajectory_.u(k).head(to.size()) - to) / (steps - s);
      stepper->go({from.data(), to.data()}, dt, x.data());
      from = to;
    }
    return x;
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const std::optional<Integrator> rule_;
  const int parts_;
  std::map<const KnotModel*, std::unique_ptr<ReplayStep>> steppers_;
};

/// Notes the steps with the largest errors of one component.
void note_worst(const Eigen::VectorXd& errors, GridError& out) {
  std::vector<int> order(errors.size());
  std::iota(order.begin(), order.end(), 0);
  const std::size_t count = std::min(GridError::kWorst, order.size());
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(count);
  std::partial_sort(order.begin(), end, order.end(), [&](int a, int b) {
    return errors[a] > errors[b] || (errors[a] == errors[b] && a < b);
  });
  for (std::size_t i = 0; i < count && errors[order[i]] > 0; ++i) {
    out.worst.push_back(order[i]);
    out.of_worst += errors[order[i]];
  }
  out.knot = out.worst.empty() ? -1 : out.worst.front();
}

const System& end_system(const ShootingProblem& problem) {
  return problem.terminal().model->system();
}

}  // namespace

Eigen::VectorXd motion_scale(const ShootingProblem& problem, const Trajectory& trajectory) {
  /// Smallest ranges, as shares of the largest number and, without a unit, of the farthest entry.
  constexpr double kRounding = 1e-9, kLittle = 1e-6;
  const int own = end_system(problem).ndx();
  Eigen::VectorXd way = motion_range(problem, trajectory).head(own);
  double largest = 0;
  for (int k = 0; k <= problem.knots(); ++k)
    largest =
        std::max(largest, trajectory.x(k).head(end_system(problem).nx()).cwiseAbs().maxCoeff());
  const std::vector<Column> columns = tangent_columns(end_system(problem));
  std::map<std::string, double> farthest;
  for (int i = 0; i < own; ++i) {
    double& most = farthest[columns[i].unit];
    most = std::max(most, way[i]);
  }
  for (int i = 0; i < own; ++i) {
    const std::string& unit = columns[i].unit;
    const bool comparable = unit != "1" && !unit.empty();
    way[i] = std::max({way[i], (comparable ? 1 : kLittle) * farthest[unit], kRounding * largest});
    if (way[i] == 0) way[i] = kInfinity;
  }
  return way;
}

std::optional<GridError> grid_error(const ShootingProblem& problem, const Trajectory& trajectory) {
  const Eigen::VectorXd scale = motion_scale(problem, trajectory);
  GridError result;
  if (scale.size() == 0) return result;
  PlannedSteps steps(problem, trajectory, std::nullopt, 1);
  Eigen::MatrixXd errors = Eigen::MatrixXd::Zero(problem.ndx(), problem.knots());
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(scale.size()), largest = sum, error(problem.ndx());
  for (int k = 0; k < problem.knots(); ++k) {
    if (!steps.has_error(k)) continue;
    steps.error(k, error);
    const auto own = error.head(scale.size());
    if (!own.allFinite()) {
      if (info_of(steps.rule(k)).collocation) return std::nullopt;
      Eigen::Index entry = 0;
      while (std::isfinite(own[entry])) ++entry;
      result = {kInfinity, kInfinity, scale[entry], static_cast<int>(entry), k, {}, kInfinity};
      for (int i = 0; i < problem.knots(); ++i)
        if (steps.has_error(i)) result.worst.push_back(i);
      return result;
    }
    errors.col(k) = error;
    sum += own;
    largest = largest.cwiseMax(sum.cwiseAbs());
  }
  Eigen::Index entry = 0;
  result.relative = largest.cwiseQuotient(scale).maxCoeff(&entry);
  result.sum = largest[entry];
  result.way = scale[entry];
  result.entry = static_cast<int>(entry);
  note_worst(errors.row(entry).cwiseAbs(), result);
  return result;
}

std::optional<double> error_by(const ShootingProblem& problem, const Trajectory& trajectory,
                               const GridError& error, std::optional<Integrator> rule,
                               int parts) try {
  PlannedSteps steps(problem, trajectory, rule, parts);
  Eigen::VectorXd there(problem.ndx());
  double sum = 0;
  for (const int k : error.worst) {
    steps.error(k, there);
    if (!there.allFinite() && info_of(steps.rule(k)).collocation) return std::nullopt;
    sum += std::abs(there[error.entry]);
  }
  if (!std::isfinite(sum)) return kInfinity;
  // Without a finite error to compare with, the steps are judged by themselves.
  return std::isfinite(error.of_worst) ? error.relative * sum / error.of_worst : sum / error.way;
} catch (const std::invalid_argument&) {  // no collocation on curved spaces
  return std::nullopt;
}

std::optional<GridError> coarse_grid(const ShootingProblem& problem, const Trajectory& trajectory,
                                     const std::vector<Eigen::MatrixXd>& gains) {
  const auto error = grid_error(problem, trajectory);
  if (!error || !(error->relative > kCoarse)) return std::nullopt;
  const auto replayed =
      replay_with_feedback(problem, trajectory, gains, 2, motion_scale(problem, trajectory));
  const Integrator rule = problem.knot(error->knot).model->integrator();
  if (!replayed || !(extrapolation(rule) * *replayed > kCoarse)) return std::nullopt;
  return error;
}

}  // namespace conddp
