#include "solvers/constraints/augmented_lagrangian.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "ocp/problem/by_name.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/constraints/row_lanes.hpp"

namespace conddp {
namespace {

/// Distance of values g from the origin of a cone, or the largest distance from a bound.
double size(const NodeConstraint& c, const Eigen::Ref<const Eigen::VectorXd>& g) {
  if (!c.term->has_bounds()) return g.norm();
  double largest = 0;
  for (int r = 0; r < c.term->rows; ++r)
    for (const double bound : {c.lower[r], c.upper[r]})
      if (std::isfinite(bound)) largest = std::max(largest, std::abs(g[r] - bound));
  return largest;
}

/// True if the constraint adds nothing to the augmented Lagrangian at these shifted values.
bool is_strictly_inside(const NodeConstraint& c, const double* shifted) {
  const int n = c.term->rows;
  if (c.term->has_bounds()) return all_strictly_inside(shifted, c.lower, c.upper, n);
  return Eigen::Map<const Eigen::VectorXd>(shifted, n - 1).norm() < shifted[n - 1];
}

}  // namespace

AugmentedLagrangian::AugmentedLagrangian(const ShootingProblem& problem,
                                         const SolverOptions& options, MultiplierSchedule schedule)
    : problem_(problem),
      options_(options.augmented_lagrangian),
      tolerance_(options.tolerances.constraint),
      schedule_(schedule),
      control_curvature_(problem),
      augmentation_(problem),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      next_(multipliers_),
      shifted_(multipliers_) {
  std::unordered_map<std::string, std::size_t> group_of;
  for (std::size_t i = 0; i < problem.constraints().size(); ++i) {
    const NodeConstraint& c = problem.constraints()[i];
    const auto [place, is_new] = group_of.try_emplace(constraint_name(problem, c), groups_.size());
    if (is_new) groups_.push_back(Group{.name = place->first});
    Group& group = groups_[place->second];
    group.constraints.push_back(static_cast<int>(i));
    group.soft = c.is_soft();
  }
  start(multipliers_);
}

void AugmentedLagrangian::start(const Eigen::VectorXd& multipliers) {
  multipliers_ = next_ = multipliers;
  stalled_.clear();
  for (Group& group : groups_) {
    group.penalty = group.first_penalty = options_.initial_penalty;
    group.before = group.allowed = std::numeric_limits<double>::infinity();
    group.reference = std::numeric_limits<double>::infinity();
    group.growths = 0;
    write(group);
  }
}

bool AugmentedLagrangian::fit_soft(const Eigen::VectorXd& values) {
  bool changed = false;
  for (Group& group : groups_) {
    if (!group.soft) continue;
    for (const int i : group.constraints) {
      const NodeConstraint& c = problem_.constraints()[i];
      const double reach = tuning::kReach * size(c, values.segment(c.row, c.term->rows));
      // A limit of 0, from a weight of 0, is compatible with any penalty.
      if (c.limit == 0 || !(reach * group.first_penalty > c.limit)) continue;
      group.first_penalty = c.limit / reach;
      changed = true;
    }
    group.penalty = group.first_penalty;
    write(group);
  }
  return changed;
}

bool AugmentedLagrangian::fit_to_costs(const Linearization& linearization) {
  const double curvature = control_curvature_.least(linearization, &augmentation_);
  bool changed = false;
  for (Group& group : groups_) {
    if (group.penalty > group.first_penalty) continue;
    double steepest = 0;
    for (const int i : group.constraints) {
      const NodeConstraint& c = problem_.constraints()[i];
      if (c.node == problem_.knots()) continue;
      const auto C = linearization.knots[c.node]
                         .C.middleRows(c.row - problem_.constraint_offset(c.node), c.term->rows)
                         .rightCols(problem_.nu(c.node));
      steepest = std::max(steepest, C.rowwise().squaredNorm().maxCoeff());
    }
    if (!(group.first_penalty * steepest > tuning::kStiffness * curvature)) continue;
    group.penalty = group.first_penalty = tuning::kStiffness * curvature / steepest;
    write(group);
    changed = true;
  }
  return changed;
}

void AugmentedLagrangian::adopt(const Eigen::VectorXd& multipliers) {
  multipliers_ = next_ = multipliers;
  for (const Group& group : groups_) write(group);
}

void AugmentedLagrangian::write(const Group& group) {
  for (const int i : group.constraints) {
    const NodeConstraint& c = problem_.constraints()[i];
    augmentation_.penalty.segment(c.row, c.term->rows).setConstant(group.penalty);
    augmentation_.shift.segment(c.row, c.term->rows) =
        multipliers_.segment(c.row, c.term->rows) / group.penalty;
  }
}

/// True if a constraint holds strictly and its multipliers are zero. It then contributes to no
/// norm.
bool AugmentedLagrangian::is_idle(const NodeConstraint& c, const Eigen::VectorXd& values) const {
  const double* multiplier = multipliers_.data() + c.row;
  return std::all_of(multiplier, multiplier + c.term->rows, [](double nu) { return nu == 0; }) &&
         is_strictly_inside(c, values.data() + c.row);
}

ConstraintNorms AugmentedLagrangian::measure(const Eigen::VectorXd& values) {
  ConstraintNorms norms;
  for (Group& group : groups_) {
    group.violation = group.change = 0;
    for (const int i : group.constraints) {
      const NodeConstraint& c = problem_.constraints()[i];
      if (is_idle(c, values)) {
        std::fill_n(next_.data() + c.row, c.term->rows, 0.0);
        continue;
      }
      const double* g = values.data() + c.row;
      const double distance = violation(c, g);
      if (!(distance <= group.violation)) group.violation = distance;
      norms.violation.meet(distance, c.node);
      auto next = next_.segment(c.row, c.term->rows);
      shifted_.head(next.size()) =
          values.segment(c.row, next.size()) + augmentation_.shift.segment(c.row, next.size());
      next_multipliers(c, shifted_.data(), group.penalty, next.data());
      auto change = shifted_.head(next.size());
      change = next - multipliers_.segment(c.row, next.size());
      norms.dual_gain += change.squaredNorm() / group.penalty;
      group.change = std::max(group.change, change.lpNorm<Eigen::Infinity>() / group.penalty);
      // Nothing more can be demanded of a soft constraint that is violated at its limit.
      if (c.is_soft()) group.violation = group.change;
      norms.complementarity = std::max(norms.complementarity, complementarity(c, g, next.data()));
    }
  }
  return norms;
}

bool AugmentedLagrangian::idle(const Eigen::VectorXd& values) {
  const auto& constraints = problem_.constraints();
  shifted_ = values + augmentation_.shift;
  return std::all_of(constraints.begin(), constraints.end(), [this](const NodeConstraint& c) {
    return is_strictly_inside(c, shifted_.data() + c.row);
  });
}

void AugmentedLagrangian::update(bool minimized) {
  const bool always = schedule_ == MultiplierSchedule::always;
  for (Group& group : groups_) {
    const bool at_limit = group.penalty >= options_.max_penalty;
    const bool grows = always ? grows_after_update(group) : grows_instead_of_update(group);
    if (always || !grows || at_limit) take_multipliers(group);
    const bool steeper = grows && minimized;
    if (steeper)
      group.penalty = std::min(group.penalty * options_.penalty_factor, options_.max_penalty);
    watch_progress(group, steeper || at_limit);
    group.before = group.violation;
    write(group);
  }
}

/// `grown`: the penalty has grown, or would have beyond its limit.
void AugmentedLagrangian::watch_progress(Group& group, bool grown) {
  if (!stays_violated(group)) {
    group.reference = group.violation;
    group.growths = 0;
  } else if (grown) {
    ++group.growths;
  }
  if (group.growths >= tuning::kGrowths && stalled_.empty()) stalled_ = group.name;
}

/// True if a group is violated and has not fallen to a share of its reference.
bool AugmentedLagrangian::stays_violated(const Group& group) const {
  return !group.soft &&
         group.violation > std::max(tuning::kVisible * tolerance_, tuning::kContradiction) &&
         !(group.violation <= tuning::kProgress * group.reference);
}

void AugmentedLagrangian::take_multipliers(const Group& group) {
  for (const int i : group.constraints) {
    const NodeConstraint& c = problem_.constraints()[i];
    multipliers_.segment(c.row, c.term->rows) = next_.segment(c.row, c.term->rows);
  }
}

/// A constraint that held before has not received multipliers yet, so its penalty does not grow.
bool AugmentedLagrangian::grows_after_update(const Group& group) const {
  return group.violation > tuning::kTighter * tolerance_ && group.before > tolerance_ &&
         group.violation > options_.sufficient_decrease * group.before;
}

bool AugmentedLagrangian::grows_instead_of_update(Group& group) {
  if (group.change > std::max(group.allowed, tuning::kTighter * tolerance_)) return true;
  if (group.change > tolerance_) group.allowed = tuning::kTighter * group.change;
  return false;
}

void AugmentedLagrangian::add(const Eigen::VectorXd& change, double step) {
  multipliers_ += step * change;
  for (const Group& group : groups_) write(group);
}

void AugmentedLagrangian::relax() {
  for (Group& group : groups_) {
    group.penalty = std::max(group.penalty / options_.penalty_factor, group.first_penalty);
    write(group);
  }
}

bool AugmentedLagrangian::may_relax() const {
  return std::any_of(groups_.begin(), groups_.end(),
                     [](const Group& group) { return group.penalty > group.first_penalty; });
}

double AugmentedLagrangian::largest_penalty() const {
  double largest = 0;
  for (const Group& group : groups_) largest = std::max(largest, group.penalty);
  return largest;
}

}  // namespace conddp
