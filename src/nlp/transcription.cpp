#include "nlp/transcription.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

namespace conddp {
namespace {

/// Up to this value, the larger variable of a pair may be at zero as well; a barrier leaves less.
constexpr double kAtZero = 1e-5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

Transcription::Transcription(const ShootingProblem& problem, Evaluator& evaluator,
                             const Options& options)
    : problem_(problem),
      evaluator_(evaluator),
      options_(options),
      gauss_newton_(options.gauss_newton),
      curved_(!problem.manifold().curved().empty()),
      charts_(problem.knots() + 1, StateChart(problem.manifold())),
      next_(charts_),
      rows_(problem.knots() + 1),
      epsilon_(options.epsilon),
      trajectory_(problem.create_trajectory()),
      evaluation_(problem),
      linearization_(problem),
      coordinates_(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      gap_rows_(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots())),
      mu_(gap_rows_),
      costates_(coordinates_),
      lagrangian_(problem),
      image_(problem.nx()),
      image_coordinates_(problem.ndx()),
      slope_(std::max(1, problem.constraint_rows())) {
  if (!options.gauss_newton) evaluator.reserve_lagrangian_hessian();
  add_variables();
  find_given_columns();
  add_rows();
  index_hessian();
  y_ = Eigen::VectorXd::Constant(variables(), std::numeric_limits<double>::quiet_NaN());
  int largest = 0;
  for (int k = 0; k <= problem.knots(); ++k)
    largest = std::max(largest, problem.knot(k).model->nz());
  z_.resize(largest);
  z_scratch_.resize(largest);
}

void Transcription::set_center(const Trajectory& trajectory) {
  for (int k = 0; k <= problem_.knots(); ++k) {
    charts_[k].set_center(trajectory.x(k));
    next_[k].set_center(trajectory.x(k));
  }
  y_.setConstant(std::numeric_limits<double>::quiet_NaN());
}

Eigen::VectorXd Transcription::point_of(const Trajectory& trajectory) const {
  Eigen::VectorXd y(variables());
  for (int k = 0; k <= problem_.knots(); ++k) {
    if (k > 0) charts_[k].coordinates(trajectory.x(k), y.segment(base_[k], problem_.ndx()));
    if (k < problem_.knots())
      y.segment(base_[k] + problem_.ndx(), problem_.nu(k)) = trajectory.u(k);
  }
  if (!slacks_.empty()) set_slacks(trajectory, y);
  if (spare_ >= 0) y[spare_] = 0;
  return y;
}

/// Sets slacks to the violations of the rows at a trajectory.
void Transcription::set_slacks(const Trajectory& trajectory, Eigen::VectorXd& y) const {
  Evaluation here(problem_);
  evaluator_.evaluate(trajectory, here);
  auto lower = row_lower_.begin(), upper = row_upper_.begin();
  for (int k = 0; k <= problem_.knots(); ++k) {
    for (const Row& row : rows_[k]) {
      const double value = row_value(row, here.constraint.data() + row.first, nullptr);
      for (int s = row.first_slack; s < row.first_slack + row.slacks; ++s)
        y[slacks_[s].variable] =
            std::max(0.0, slacks_[s].sign > 0 ? *lower - value : value - *upper);
      ++lower, ++upper;
    }
    if (k == problem_.knots()) break;
    lower += problem_.ndx();
    upper += problem_.ndx();
  }
}

void Transcription::set_point(const double* y) {
  const Eigen::Map<const Eigen::VectorXd> point(y, variables());
  if (point == y_) return;
  y_ = point;
  evaluated_ = differentiated_ = false;
  const int ndx = problem_.ndx();
  for (int k = 0; k <= problem_.knots(); ++k) {
    if (k == 0) {
      trajectory_.x(0) =
          Eigen::Map<const Eigen::VectorXd>(problem_.initial_state().data(), problem_.nx());
    } else {
      coordinates_.col(k) = point.segment(base_[k], ndx);
      charts_[k].state(coordinates_.col(k).data(), trajectory_.x(k));
    }
  }
  read_controls(y, trajectory_);
}

void Transcription::read_controls(const double* variables, Trajectory& trajectory) const {
  for (int k = 0; k < problem_.knots(); ++k)
    trajectory.u(k) =
        Eigen::Map<const Eigen::VectorXd>(variables + base_[k] + problem_.ndx(), problem_.nu(k));
}

double Transcription::chart_angle() const {
  double largest = 0;
  for (int k = 1; k <= problem_.knots(); ++k)
    largest = std::max(largest, charts_[k].angle(coordinates_.col(k)));
  return largest;
}

/// Converts gaps at the states to gaps in the charts of the next nodes.
void Transcription::read_charts(const Eigen::MatrixXd& gap) {
  gap_rows_ = gap;
  if (!curved_) return;
  for (int k = 1; k <= problem_.knots(); ++k) {
    problem_.manifold().integrate(trajectory_.x(k).data(), gap.col(k - 1).data(), image_.data());
    charts_[k].set_point(coordinates_.col(k));
    charts_[k].coordinates(image_, image_coordinates_);
    next_[k].set_point(image_coordinates_);
    for (const StateManifold::Segment& s : problem_.manifold().curved())
      gap_rows_.col(k - 1).segment(s.dx, s.n) =
          (image_coordinates_ - coordinates_.col(k)).segment(s.dx, s.n);
  }
}

void Transcription::evaluate() {
  if (evaluated_) return;
  evaluator_.evaluate(trajectory_, evaluation_);
  read_charts(evaluation_.gap);
  evaluated_ = true;
}

bool Transcription::has_mixed_rows() const {
  const auto is_control = [this](int column) { return column >= problem_.ndx(); };
  for (const std::vector<Row>& rows : rows_)
    for (const Row& row : rows) {
      const auto controls = std::count_if(row.columns.begin(), row.columns.end(), is_control);
      if (controls > 0 && controls < std::ssize(row.columns)) return true;
    }
  return false;
}

void Transcription::differentiate() {
  if (differentiated_) return;
  if (exact_in_place_) {
    for (KnotLinearization& knot : linearization_.knots) knot.hessian.change().setZero();
    exact_in_place_ = false;
  }
  evaluator_.differentiate(trajectory_, linearization_);
  read_charts(linearization_.gap);
  evaluation_.gap = linearization_.gap;
  evaluation_.cost = linearization_.cost;
  evaluation_.constraint = linearization_.constraint;
  evaluated_ = differentiated_ = true;
}

const Evaluation& Transcription::evaluation() {
  evaluate();
  return evaluation_;
}

double Transcription::objective() {
  evaluate();
  double sum = evaluation_.cost.sum() + penalty_value(y_.data());
  for (const Slack& slack : slacks_) sum += slack.price * y_[slack.variable];
  if (spare_ >= 0) sum += 0.5 * y_[spare_] * y_[spare_];
  return sum;
}

void Transcription::gradient(double* out) {
  differentiate();
  for (int k = 0; k <= problem_.knots(); ++k) {
    auto z = z_.head(problem_.knot(k).model->nz());
    z = linearization_.knots[k].gradient;
    if (k > 0) charts_[k].pull(z.head(problem_.ndx()));
    for (int c = first_column(k); c < z.size(); ++c) out[base_[k] + c] = z[c];
  }
  for (const Slack& slack : slacks_) out[slack.variable] = slack.price;
  if (spare_ >= 0) out[spare_] = y_[spare_];
  if (is_penalty()) add_penalty_gradient(out);
}

/// Gradient of z s/ε.
void Transcription::add_penalty_gradient(double* out) const {
  for (const Pair& pair : pairs_) {
    out[pair.z] += penalty_slope(pair.s);
    out[pair.s] += penalty_slope(pair.z);
  }
}

ConeRow Transcription::cone_row(const Row& row) const {
  return {row.constraint->is_soft() ? ConeRow::Form::distance : ConeRow::Form::surface,
          options_.cone_smoothing};
}

double Transcription::row_value(const Row& row, const double* g, double* slope) const {
  if (is_cone(row)) return cone_row(row).value(g, row.count, slope);
  if (has_pairs(row)) return pair_value(options_.relaxation, g, row.count, epsilon_, slope);
  if (slope != nullptr) *slope = row.radius > 0 ? *g / row.radius : 1;
  return row.radius > 0 ? 0.5 * *g * *g / row.radius : *g;
}

void Transcription::constraints(double* out) {
  evaluate();
  for (int k = 0; k <= problem_.knots(); ++k) {
    for (const Row& row : rows_[k]) {
      double value = row_value(row, evaluation_.constraint.data() + row.first, nullptr);
      for (int s = row.first_slack; s < row.first_slack + row.slacks; ++s)
        value += slacks_[s].sign * y_[slacks_[s].variable];
      *out++ = value;
    }
    if (k == problem_.knots()) break;
    Eigen::Map<Eigen::VectorXd> gap(out, problem_.ndx());
    gap = gap_rows_.col(k);
    for (const int i : kinematic_rows_[k])
      gap[i] -= problem_.knot(k).dt * gap[problem_.ndx() / 2 + i];
    out += problem_.ndx();
  }
}

/// matrix_ = ∂f/∂z, ndx x nz.
void Transcription::fill_dynamics(const KnotLinearization& knot) {
  const int nz = static_cast<int>(knot.gradient.size());
  matrix_.resize(problem_.ndx(), nz);
  for (int c = 0; c < nz; ++c) {
    auto unit = z_.head(nz);
    unit.setZero();
    unit[c] = 1;
    knot.apply(unit, matrix_.col(c));
  }
}

void Transcription::jacobian(double* out) {
  differentiate();
  for (int k = 0; k <= problem_.knots(); ++k) {
    out = write_row_entries(k, out);
    if (k < problem_.knots()) out = write_gap_entries(k, out);
  }
}

/// Writes the entries of a node's constraint rows. Returns the position after them.
double* Transcription::write_row_entries(int k, double* out) {
  const KnotLinearization& knot = linearization_.knots[k];
  for (const Row& row : rows_[k]) {
    const auto C = knot.C.middleRows(row.first - problem_.constraint_offset(k), row.count);
    auto z = z_.head(knot.gradient.size());
    row_value(row, linearization_.constraint.data() + row.first, slope_.data());
    z.noalias() = C.transpose() * slope_.head(row.count);
    if (k > 0) charts_[k].pull(z.head(problem_.ndx()));
    for (const int c : row.columns) *out++ = z[c];
    for (int s = row.first_slack; s < row.first_slack + row.slacks; ++s) *out++ = slacks_[s].sign;
  }
  return out;
}

/// Writes the entries of a knot's gap rows. Returns the position after them.
double* Transcription::write_gap_entries(int k, double* out) {
  const KnotLinearization& knot = linearization_.knots[k];
  fill_dynamics(knot);
  if (curved_) {
    next_[k + 1].push_rows(matrix_);
    if (k > 0) charts_[k].pull_columns(matrix_);
  }
  for (const int i : kinematic_rows_[k]) matrix_(i, i) = 1;
  for (const auto& [i, c] : gap_entries_[k]) *out++ = matrix_(i, c);
  out = std::fill_n(out, problem_.ndx(), -1.0);
  return std::fill_n(out, kinematic_rows_[k].size(), knot.dt);
}

/// Fills mu_, costates_ and the multipliers of lagrangian_ from the multipliers of the rows.
void Transcription::spread(const double* rows) {
  differentiate();
  costates_.col(0).setZero();
  lagrangian_.multiplier.setZero();
  for (int k = 0; k <= problem_.knots(); ++k) {
    rows = spread_constraints(k, rows);
    if (k == problem_.knots()) break;
    for (int i = 0; i < problem_.ndx(); ++i) mu_(i, k) = *rows++;
    for (const int i : kinematic_rows_[k])
      mu_(problem_.ndx() / 2 + i, k) -= problem_.knot(k).dt * mu_(i, k);
    costates_.col(k + 1) = mu_.col(k);
    if (curved_) next_[k + 1].push_transposed(costates_.col(k + 1));
  }
}

/// Reads the multipliers of a node's constraints. Returns the position of the next rows.
const double* Transcription::spread_constraints(int k, const double* rows) {
  for (const Row& row : rows_[k]) {
    const double multiplier = *rows++;
    double* nu = lagrangian_.multiplier.data() + row.first;
    row_value(row, linearization_.constraint.data() + row.first, nu);
    for (int i = 0; i < row.count; ++i) nu[i] *= multiplier;
  }
  return rows;
}

void Transcription::read_multipliers(const double* rows, Eigen::MatrixXd& costates,
                                     Eigen::VectorXd& nu) {
  spread(rows);
  costates = costates_;
  nu = lagrangian_.multiplier;
  if (pairs_.empty()) return;
  const Eigen::VectorXd slope = slope_without_pairs(rows);
  for (const Pair& pair : pairs_) read_pair(pair, slope, nu);
}

/// Gradient of the Lagrangian without the rows of pairs.
Eigen::VectorXd Transcription::slope_without_pairs(const double* rows) {
  Eigen::VectorXd slope(variables()), entries(jacobian_.size());
  gradient(slope.data());
  jacobian(entries.data());
  std::vector<bool> is_pair(this->rows(), false);
  for (const auto& list : rows_)
    for (const Row& row : list) is_pair[row.index] = has_pairs(row);
  for (int e = 0; e < jacobian_.size(); ++e)
    if (!is_pair[jacobian_.rows[e]])
      slope[jacobian_.columns[e]] += rows[jacobian_.rows[e]] * entries[e];
  return slope;
}

void Transcription::read_pair(const Pair& pair, const Eigen::VectorXd& slope,
                              Eigen::VectorXd& nu) const {
  int smaller = pair.z, larger = pair.s, row = pair.row, other_row = pair.row + 1;
  if (!(y_[smaller] <= y_[larger])) {
    std::swap(smaller, larger);
    std::swap(row, other_row);
  }
  nu[row] = -slope[smaller] + penalty_slope(larger);
  // The larger variable has a multiplier only if it is at zero as well.
  const double rest = slope[larger] - penalty_slope(smaller);
  nu[other_row] = std::abs(y_[larger]) <= kAtZero ? -std::max(0.0, rest) : 0;
}

double Transcription::penalty_value(const double* y) const {
  if (!is_penalty()) return 0;
  double sum = 0;
  for (const Pair& pair : pairs_) sum += y[pair.z] * y[pair.s];
  return sum / epsilon_;
}

void Transcription::relax(double epsilon) {
  epsilon_ = epsilon;
  for (const Pair& pair : pairs_) {
    const auto& bounds = problem_.knot(pair.node).model->control_upper();
    const int first = base_[pair.node] + problem_.ndx();
    for (const int v : {pair.z, pair.s}) upper_[v] = bounds[v - first];
  }
  if (options_.relaxation == PairRelaxation::fischer_burmeister)
    bound_pair_rows(0, 0);
  else
    bound_pair_rows(-kInfinity, epsilon);
}

void Transcription::bound_pair_rows(double lower, double upper) {
  for (const auto& rows : rows_)
    for (const Row& row : rows) {
      if (!has_pairs(row)) continue;
      row_lower_[row.index] = lower;
      row_upper_[row.index] = upper;
    }
}

void Transcription::fix_pairs(const double* y) {
  for (const Pair& pair : pairs_) upper_[y[pair.z] <= y[pair.s] ? pair.z : pair.s] = 0;
  bound_pair_rows(-kInfinity, kInfinity);
}

double Transcription::pair_distance(const double* y) const {
  double largest = 0;
  for (const Pair& pair : pairs_)
    largest = std::max(largest, std::abs(std::min(y[pair.z], y[pair.s])));
  return largest;
}

void Transcription::push_gap_multipliers(int node, double* gap_rows) const {
  for (const int i : kinematic_rows_[node])
    gap_rows[problem_.ndx() / 2 + i] += problem_.knot(node).dt * gap_rows[i];
}

void Transcription::write_multipliers(const Eigen::MatrixXd& costates, const Eigen::VectorXd& nu,
                                      const std::vector<Eigen::VectorXd>& control_gradient,
                                      Eigen::VectorXd& rows, Eigen::VectorXd& lower,
                                      Eigen::VectorXd& upper) const {
  rows = Eigen::VectorXd::Zero(this->rows());
  lower = upper = Eigen::VectorXd::Zero(variables());
  int index = 0;
  for (int k = 0; k <= problem_.knots(); ++k) {
    for (const Row& row : rows_[k]) {
      // Where its multiplier is nonzero, a squared norm is as steep as the norm.
      const double multiplier =
          is_cone(row) ? cone_row(row).multiplier(nu.data() + row.first, row.count) : nu[row.first];
      rows[index++] = multiplier;
      for (int s = row.first_slack; s < row.first_slack + row.slacks; ++s)
        lower[slacks_[s].variable] = std::max(0.0, slacks_[s].price + slacks_[s].sign * multiplier);
    }
    if (k == problem_.knots()) break;
    rows.segment(index, problem_.ndx()) = costates.col(k + 1);
    push_gap_multipliers(k, rows.data() + index);
    index += problem_.ndx();
    write_bound_multipliers(k, control_gradient[k], lower, upper);
  }
}

/// Bound multipliers of a knot's control, from ∇_u of the Lagrangian without its bounds.
void Transcription::write_bound_multipliers(int k, const Eigen::VectorXd& gradient,
                                            Eigen::VectorXd& lower, Eigen::VectorXd& upper) const {
  for (int i = 0; i < problem_.nu(k); ++i) {
    const int variable = base_[k] + problem_.ndx() + i;
    if (std::isfinite(lower_[variable])) lower[variable] = std::max(0.0, gradient[i]);
    if (std::isfinite(upper_[variable])) upper[variable] = std::max(0.0, -gradient[i]);
  }
}

Eigen::VectorXd Transcription::weights_of_cost_states(double weight) {
  const Sparsity& structure = jacobian_structure();
  Eigen::VectorXd slope(variables()), values(structure.size());
  gradient(slope.data());
  jacobian(values.data());
  Eigen::VectorXi readers = Eigen::VectorXi::Zero(variables());
  for (int e = 0; e < structure.size(); ++e)
    if (values[e] != 0) ++readers[structure.columns[e]];
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(variables());
  Eigen::VectorXd curvature(hessian_structure().size());
  for (int i = 0; i < problem_.ndx(); ++i) {
    bool adds_up = slope[base_[problem_.knots()] + i] != 0;
    Eigen::VectorXd own_rows = Eigen::VectorXd::Zero(rows());
    for (int k = 1; k <= problem_.knots(); ++k) {
      adds_up = adds_up && readers[base_[k] + i] <= 2;
      own_rows[gap_row_[k - 1] + i] = 1;
    }
    if (!adds_up) continue;
    hessian(0, own_rows.data(), curvature.data());
    if (curvature.cwiseAbs().maxCoeff() == 0) continue;
    for (int k = 1; k <= problem_.knots(); ++k) weights[base_[k] + i] = weight;
  }
  return weights;
}

void Transcription::recenter_multipliers(double* rows) {
  spread(rows);
  for (int k = 0; k < problem_.knots(); ++k) {
    std::copy_n(costates_.col(k + 1).data(), problem_.ndx(), rows + gap_row_[k]);
    push_gap_multipliers(k, rows + gap_row_[k]);
  }
}

}  // namespace conddp
