#include "ocp/problem/problem.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include "ocp/terms/constraint.hpp"

namespace conddp {
namespace {

bool has_fitting_sizes(const Phase& phase) {
  const std::size_t n = phase.dt.size();
  return phase.model && n > 0 && phase.cost_scale.size() == n &&
         phase.parameters.size() == n * phase.model->parameter_count();
}

void check(const Phase& phase) {
  if (!has_fitting_sizes(phase))
    throw std::invalid_argument("phase " + phase.name + ": sizes do not fit its model");
  if (phase.model->integrator() == Integrator::impulse &&
      std::any_of(phase.dt.begin(), phase.dt.end(), [](double dt) { return dt != 0; }))
    throw std::invalid_argument("phase " + phase.name + ": an impulse takes no time");
}

void check_terminal(const Phase& phase) {
  check(phase);
  if (phase.model->integrator() != Integrator::none || phase.knots() != 1)
    throw std::invalid_argument("the terminal phase is one node without dynamics");
}

/// Upper limit on the multipliers of a constraint at a node.
double limit_at(const KnotView& view, const ConstraintTerm& term) {
  return term.softness == Softness::l1 ? view.cost_scale * view.parameters[term.weight()]
                                       : std::numeric_limits<double>::infinity();
}

/// A constraint with its bounds and limit at a node.
NodeConstraint at_node(const KnotView& view, const ConstraintTerm& term, int node, int row) {
  NodeConstraint constraint{node, &term, row, nullptr, nullptr};
  if (term.has_bounds()) {
    constraint.lower = view.parameters + term.lower();
    constraint.upper = view.parameters + term.upper();
  }
  constraint.limit = limit_at(view, term);
  return constraint;
}

/// The value rounded to the decimal digits that a double preserves: steps are decimal numbers with
/// few digits, and so are their sums.
double to_decimal(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific,
                                 std::numeric_limits<double>::digits10 - 1)
                       .ptr;
  std::from_chars(text, end, value);
  return value;
}

/// A compensated sum of steps.
class TimeSum {
 public:
  /// Returns the time after one more step.
  double add(double step) {
    const double given = step + rest_;
    const double next = sum_ + given;
    rest_ = given - (next - sum_);
    sum_ = next;
    return to_decimal(sum_);
  }

 private:
  double sum_ = 0, rest_ = 0;  ///< `rest_`: rounding error of the sum
};

}  // namespace

std::vector<double> node_times(std::span<const double> steps) {
  std::vector<double> times{0};
  times.reserve(steps.size() + 1);
  TimeSum sum;
  for (const double step : steps) times.push_back(sum.add(step));
  return times;
}

ShootingProblem::ShootingProblem(std::vector<double> initial_state, std::vector<Phase> phases,
                                 Phase terminal)
    : initial_state_(std::move(initial_state)),
      phases_(std::move(phases)),
      terminal_(std::move(terminal)) {
  check_terminal(terminal_);
  std::vector<double> steps;
  for (int p = 0; p < static_cast<int>(phases_.size()); ++p) {
    const Phase& phase = phases_[p];
    add_knots(phase, p);
    for (const double dt : phase.dt) steps.push_back(phase.instant ? 0 : dt);
  }
  add_knots(terminal_, static_cast<int>(phases_.size()));
  times_ = node_times(steps);
  constraint_offset_.push_back(0);
  for (int k = 0; k <= knots(); ++k) {
    add_constraints(k);
    constraint_offset_.push_back(constraint_offset_.back() + views_[k].model->constraint_rows());
  }
  if (static_cast<int>(initial_state_.size()) != nx())
    throw std::invalid_argument("the initial state has the wrong size");
}

void ShootingProblem::add_knots(const Phase& phase, int index) {
  check(phase);
  if (phase.model->nx() != terminal_.model->nx() || phase.model->ndx() != terminal_.model->ndx())
    throw std::invalid_argument("phase " + phase.name + " has another state than the terminal");
  for (int k = 0; k < phase.knots(); ++k)
    views_.push_back({phase.model.get(),
                      phase.parameters.data() + k * phase.model->parameter_count(), phase.dt[k],
                      phase.cost_scale[k], index});
}

/// Adds the constraints of a node that are not switched off.
void ShootingProblem::add_constraints(int k) {
  const KnotView& view = views_[k];
  for (const ConstraintTerm& term : view.model->constraints()) {
    if (view.parameters[term.active()] == 0) continue;
    const NodeConstraint constraint = at_node(view, term, k, constraint_offset_.back() + term.row);
    if (term.softness != Softness::l2) constraints_.push_back(constraint);
    if (constraint.is_soft()) soft_constraints_.push_back(constraint);
  }
}

bool ShootingProblem::has_free_durations() const {
  return std::any_of(phases_.begin(), phases_.end(),
                     [](const Phase& phase) { return phase.model->step().duration().has_value(); });
}

std::vector<double> ShootingProblem::times(const Trajectory& trajectory) const {
  if (!has_free_durations()) return times_;
  std::vector<double> times{0};
  for (int k = 0; k < knots(); ++k) {
    const KnotView& view = views_[k];
    const double step = phases_[view.phase].instant
                            ? 0
                            : view.model->step().time_step(view.dt, trajectory.x(k).data());
    times.push_back(times.back() + step);
  }
  return times;
}

bool ShootingProblem::has_control_bounds() const {
  for (const Phase& phase : phases_)
    if (phase.model->has_control_bounds()) return true;
  return false;
}

void ShootingProblem::set_initial_state(std::span<const double> x) {
  if (x.size() != initial_state_.size())
    throw std::invalid_argument("the initial state has the wrong number of entries");
  std::copy(x.begin(), x.end(), initial_state_.begin());
}

void ShootingProblem::set_numbers(Phase& phase, int first, std::span<const KnotNumbers> nodes) {
  const int count = phase.model->parameter_count();
  for (int i = 0; i < phase.knots(); ++i) {
    const KnotNumbers& node = nodes[first + i];
    KnotView& view = views_[first + i];
    view.dt = phase.dt[i] = node.dt;
    view.cost_scale = phase.cost_scale[i] = node.cost_scale;
    std::copy_n(node.parameters, count, phase.parameters.begin() + i * count);
  }
}

void ShootingProblem::set_numbers(std::span<const KnotNumbers> nodes) {
  if (nodes.size() != views_.size())
    throw std::invalid_argument("as many nodes as the problem has need numbers");
  int first = 0;
  for (Phase& phase : phases_) {
    set_numbers(phase, first, nodes);
    first += phase.knots();
  }
  set_numbers(terminal_, first, nodes);
  TimeSum sum;
  for (int k = 0; k < knots(); ++k)
    times_[k + 1] = sum.add(phases_[views_[k].phase].instant ? 0 : nodes[k].dt);
  for (auto* constraints : {&constraints_, &soft_constraints_})
    for (NodeConstraint& c : *constraints) c.limit = limit_at(views_[c.node], *c.term);
}

Trajectory ShootingProblem::create_trajectory() const {
  std::vector<int> sizes(knots());
  for (int k = 0; k < knots(); ++k) sizes[k] = nu(k);
  Trajectory trajectory(nx(), sizes);
  const Eigen::Map<const Eigen::VectorXd> x0(initial_state_.data(), nx());
  for (int k = 0; k <= knots(); ++k) trajectory.x(k) = x0;
  return trajectory;
}

void next_multipliers(const NodeConstraint& c, const double* s, double penalty, double* next) {
  const int n = c.term->rows;
  const double limit = c.limit / penalty;
  if (c.term->has_bounds()) {
    for (int i = 0; i < n; ++i)
      next[i] = limit_outside(outside_bounds(s[i], c.lower[i], c.upper[i]), limit);
  } else {
    outside_cone(s, n, next);
    if (c.is_soft()) limit_cone(n, limit, next);
  }
  for (int i = 0; i < n; ++i) next[i] *= penalty;
}

double violation(const NodeConstraint& c, const double* g) {
  return c.is_soft() ? 0 : distance_to_set(*c.term, g, c.lower, c.upper);
}

namespace {

/// Complementarity of a row with bounds: outside its bounds, the multiplier must equal the limit;
/// it never exceeds the limit.
double row_complementarity(const NodeConstraint& c, int i, double value, double multiplier) {
  const double outside = outside_bounds(value, c.lower[i], c.upper[i]);
  const double lacks = c.limit - (outside > 0 ? multiplier : -multiplier);
  return std::max({std::abs(outside) * std::abs(lacks), std::abs(multiplier) - c.limit,
                   bound_complementarity(value, c.lower[i], c.upper[i], multiplier)});
}

}  // namespace

double complementarity(const NodeConstraint& c, const double* g, const double* multipliers) {
  const int n = c.term->rows;
  if (!c.is_soft()) return complementarity(*c.term, g, c.lower, c.upper, multipliers);
  if (c.term->has_bounds()) {
    double largest = 0;
    for (int i = 0; i < n; ++i)
      largest = std::max(largest, row_complementarity(c, i, g[i], multipliers[i]));
    return largest;
  }
  // At a solution, νᵀg equals the cost of the cone's distance: the multipliers are at their limit.
  const double paid = c.limit * distance_to_set(*c.term, g, c.lower, c.upper);
  double product = -paid, square = 0;
  for (int i = 0; i < n; ++i) product += multipliers[i] * g[i];
  for (int i = 0; i + 1 < n; ++i) square += multipliers[i] * multipliers[i];
  return std::max({std::abs(product), distance_to_polar_cone(multipliers, n),
                   std::hypot(std::sqrt(square), multipliers[n - 1]) - c.limit});
}

double linear_soft_cost(const ShootingProblem& problem, const Eigen::VectorXd& values) {
  double sum = 0;
  for (const NodeConstraint& c : problem.constraints())
    if (c.is_soft())
      sum += c.limit * soft_distance(*c.term, values.data() + c.row, c.lower, c.upper, 1);
  return sum;
}

}  // namespace conddp
