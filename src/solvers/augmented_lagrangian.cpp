#include "solvers/augmented_lagrangian.hpp"

#include <algorithm>
#include <limits>

namespace conddp {
namespace {

/// Updates at the largest penalty without progress after which a constraint is given up.
constexpr int kPatience = 5;
constexpr double kNoProgress = 0.9;
/// Smaller violations, and those below a few tolerances, are rounding and no contradiction.
constexpr double kContradiction = 1e-5;

}  // namespace

AugmentedLagrangian::AugmentedLagrangian(const ShootingProblem& problem,
                                         const SolverOptions& options)
    : problem_(problem),
      options_(options.augmented_lagrangian),
      tolerance_(options.tolerances.constraint),
      augmentation_(problem),
      multipliers_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      next_(multipliers_) {
  for (std::size_t i = 0; i < problem.constraints().size(); ++i) {
    const NodeConstraint& c = problem.constraints()[i];
    const std::string name = (c.node == problem.knots() ? "terminal/" : "") + c.term->name;
    auto group = std::find_if(groups_.begin(), groups_.end(),
                              [&](const Group& g) { return g.name == name; });
    if (group == groups_.end()) group = groups_.insert(group, Group{.name = name});
    group->constraints.push_back(static_cast<int>(i));
  }
  start(multipliers_);
}

void AugmentedLagrangian::start(const Eigen::VectorXd& multipliers) {
  multipliers_ = next_ = multipliers;
  hopeless_.clear();
  for (Group& group : groups_) {
    group.penalty = options_.initial_penalty;
    group.before = std::numeric_limits<double>::infinity();
    group.stalled = 0;
    write(group);
  }
}

void AugmentedLagrangian::adopt(const Eigen::VectorXd& multipliers) {
  multipliers_ = next_ = multipliers;
  for (Group& group : groups_) {
    group.penalty = options_.initial_penalty;
    write(group);
  }
}

void AugmentedLagrangian::write(const Group& group) {
  for (const int i : group.constraints) {
    const NodeConstraint& c = problem_.constraints()[i];
    augmentation_.penalty.segment(c.row, c.term->rows).setConstant(group.penalty);
    augmentation_.shift.segment(c.row, c.term->rows) =
        multipliers_.segment(c.row, c.term->rows) / group.penalty;
  }
}

ConstraintNorms AugmentedLagrangian::measure(const Eigen::VectorXd& values) {
  ConstraintNorms norms;
  for (Group& group : groups_) {
    group.violation = 0;
    for (const int i : group.constraints) {
      const NodeConstraint& c = problem_.constraints()[i];
      const double* g = values.data() + c.row;
      const double distance = distance_to_set(*c.term, g, c.lower, c.upper);
      if (!(distance <= group.violation)) group.violation = distance;
      if (!(distance <= norms.violation.value)) norms.violation = {distance, c.node};
      auto next = next_.segment(c.row, c.term->rows);
      next = values.segment(c.row, c.term->rows) + augmentation_.shift.segment(c.row, c.term->rows);
      if (c.term->has_bounds())
        for (int r = 0; r < c.term->rows; ++r)
          next[r] = outside_bounds(next[r], c.lower[r], c.upper[r]);
      else
        outside_cone(next.data(), c.term->rows, next.data());
      next *= group.penalty;
      norms.complementarity = std::max(norms.complementarity,
                                       complementarity(*c.term, g, c.lower, c.upper, next.data()));
    }
  }
  return norms;
}

void AugmentedLagrangian::update() {
  multipliers_ = next_;
  for (Group& group : groups_) {
    // A constraint that held before has not had multipliers yet.
    const bool enough = group.violation <= 0.1 * tolerance_ || group.before <= tolerance_ ||
                        group.violation <= options_.sufficient_decrease * group.before;
    const bool at_limit = group.penalty >= options_.max_penalty;
    if (!enough)
      group.penalty = std::min(group.penalty * options_.penalty_factor, options_.max_penalty);
    const bool progress = group.violation <= kNoProgress * group.before;
    const bool violated = group.violation > std::max(10 * tolerance_, kContradiction);
    group.stalled = at_limit && !progress && violated ? group.stalled + 1 : 0;
    if (group.stalled >= kPatience && hopeless_.empty()) hopeless_ = group.name;
    group.before = group.violation;
    write(group);
  }
}

double AugmentedLagrangian::largest_penalty() const {
  double largest = 0;
  for (const Group& group : groups_) largest = std::max(largest, group.penalty);
  return largest;
}

}  // namespace conddp
