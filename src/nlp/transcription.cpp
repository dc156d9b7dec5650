#include "nlp/transcription.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

/// Weight that stands for none where the Lagrangian's Hessian is asked for without the cost.
constexpr double kNoWeight = 1e-30;

}  // namespace

Transcription::Transcription(const ShootingProblem& problem, Acts& acts, const Options& options)
    : problem_(problem),
      acts_(acts),
      options_(options),
      curved_(!problem.manifold().curved().empty()),
      charts_(problem.knots() + 1, StateChart(problem.manifold())),
      next_(charts_),
      rows_(problem.knots() + 1),
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
  if (!options.gauss_newton) acts.reserve_lagrangian_hessian();
  add_variables();
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
  return y;
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

/// The gaps in the charts of the next nodes, from those at the states.
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
  acts_.evaluate(trajectory_, evaluation_);
  read_charts(evaluation_.gap);
  evaluated_ = true;
}

void Transcription::differentiate() {
  if (differentiated_) return;
  acts_.differentiate(trajectory_, linearization_);
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
  return evaluation_.cost.sum();
}

void Transcription::gradient(double* out) {
  differentiate();
  for (int k = 0; k <= problem_.knots(); ++k) {
    auto z = z_.head(problem_.knot(k).model->nz());
    z = linearization_.knots[k].gradient;
    if (k > 0) charts_[k].pull(z.head(problem_.ndx()));
    for (int c = first_column(k); c < z.size(); ++c) out[base_[k] + c] = z[c];
  }
}

/// h of a cone at g, and its derivative (n numbers) where asked for.
double Transcription::cone_value(const double* g, int n, double* slope) const {
  const double e = options_.cone_smoothing;
  double square = e * e;
  for (int i = 0; i + 1 < n; ++i) square += g[i] * g[i];
  const double root = std::sqrt(square);
  if (slope != nullptr) {
    for (int i = 0; i + 1 < n; ++i) slope[i] = -g[i] / root;
    slope[n - 1] = 1;
  }
  return g[n - 1] - root + e;
}

void Transcription::constraints(double* out) {
  evaluate();
  for (int k = 0; k <= problem_.knots(); ++k) {
    for (const Row& row : rows_[k]) {
      const double* g = evaluation_.constraint.data() + row.first;
      *out++ = is_cone(row) ? cone_value(g, row.count, nullptr) : *g;
    }
    if (k == problem_.knots()) break;
    for (int i = 0; i < problem_.ndx(); ++i) *out++ = gap_rows_(i, k);
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
  const int ndx = problem_.ndx();
  for (int k = 0; k <= problem_.knots(); ++k) {
    const KnotLinearization& knot = linearization_.knots[k];
    const int nz = static_cast<int>(knot.gradient.size());
    for (const Row& row : rows_[k]) {
      const auto C = knot.C.middleRows(row.first - problem_.constraint_offset(k), row.count);
      auto z = z_.head(nz);
      if (is_cone(row)) {
        cone_value(linearization_.constraint.data() + row.first, row.count, slope_.data());
        z.noalias() = C.transpose() * slope_.head(row.count);
      } else {
        z = C.row(0);
      }
      if (k > 0) charts_[k].pull(z.head(ndx));
      for (const int c : row.columns) *out++ = z[c];
    }
    if (k == problem_.knots()) break;
    fill_dynamics(knot);
    if (curved_) {
      next_[k + 1].push_rows(matrix_);
      if (k > 0) charts_[k].pull_columns(matrix_);
    }
    for (int c = first_column(k); c < nz; ++c)
      for (int i = 0; i < ndx; ++i) *out++ = matrix_(i, c);
    for (int i = 0; i < ndx; ++i) *out++ = -1;
  }
}

/// Fills mu_, costates_ and the multipliers of lagrangian_ from those of the rows.
void Transcription::spread(const double* rows) {
  differentiate();
  costates_.col(0).setZero();
  lagrangian_.multiplier.setZero();
  for (int k = 0; k <= problem_.knots(); ++k) {
    for (const Row& row : rows_[k]) {
      const double multiplier = *rows++;
      double* nu = lagrangian_.multiplier.data() + row.first;
      if (!is_cone(row)) {
        *nu = multiplier;
        continue;
      }
      cone_value(linearization_.constraint.data() + row.first, row.count, nu);
      for (int i = 0; i < row.count; ++i) nu[i] *= multiplier;
    }
    if (k == problem_.knots()) break;
    for (int i = 0; i < problem_.ndx(); ++i) mu_(i, k) = *rows++;
    costates_.col(k + 1) = mu_.col(k);
    if (curved_) next_[k + 1].push_transposed(costates_.col(k + 1));
  }
}

void Transcription::read_multipliers(const double* rows, Eigen::MatrixXd& costates,
                                     Eigen::VectorXd& nu) {
  spread(rows);
  costates = costates_;
  nu = lagrangian_.multiplier;
}

void Transcription::recenter_multipliers(double* rows) {
  spread(rows);
  for (int k = 0; k < problem_.knots(); ++k)
    for (int i = 0; i < problem_.ndx(); ++i) rows[gap_row_[k] + i] = costates_(i, k + 1);
}

/// weight Cᵀ ∇²h C of a cone.
void Transcription::add_cone_curvature(const Row& row, double weight,
                                       Eigen::Ref<Eigen::MatrixXd> hessian) {
  const int k = row.constraint->node, n = row.count - 1;
  const auto C = linearization_.knots[k].C.middleRows(row.first - problem_.constraint_offset(k), n);
  const auto v = linearization_.constraint.segment(row.first, n);
  const double root = std::sqrt(v.squaredNorm() + std::pow(options_.cone_smoothing, 2));
  auto along = z_.head(C.cols());
  along.noalias() = C.transpose() * v;
  hessian.noalias() -= (weight / root) * (C.transpose() * C);
  hessian.noalias() += (weight / (root * root * root)) * along * along.transpose();
}

/// The curvature of the next node's chart, where the dynamics lead into it.
void Transcription::add_gap_curvature(int k, Eigen::Ref<Eigen::MatrixXd> hessian) {
  const auto& curved = problem_.manifold().curved();
  for (std::size_t i = 0; i < curved.size(); ++i) {
    const StateManifold::Segment& s = curved[i];
    const auto T = matrix_.middleRows(s.dx, s.n);
    const auto& E = next_[k + 1].coordinate_curvature(static_cast<int>(i), mu_.col(k));
    jacobian_rows_.noalias() = E.topLeftCorner(s.n, s.n) * T;
    hessian.noalias() += T.transpose() * jacobian_rows_;
  }
}

void Transcription::hessian(double weight, const double* multipliers, double* out) {
  spread(multipliers);
  const int ndx = problem_.ndx();
  if (!options_.gauss_newton) {
    // Acts have the cost with weight one.
    if (weight == 0) weight = kNoWeight;
    lagrangian_.multiplier /= weight;
    costates_ /= weight;
    acts_.lagrangian_hessian(trajectory_, costates_, linearization_, &lagrangian_);
    lagrangian_.multiplier *= weight;
    costates_ *= weight;
  }
  for (int k = 0; k <= problem_.knots(); ++k) {
    const KnotLinearization& knot = linearization_.knots[k];
    const int nz = static_cast<int>(knot.gradient.size());
    Eigen::MatrixXd& H = block_;
    H = weight * knot.hessian;
    int row_index = k == 0 ? 0 : gap_row_[k - 1] + ndx;
    for (const Row& row : rows_[k]) {
      const double multiplier = multipliers[row_index++];
      if (!is_cone(row)) continue;
      // Convex where the multiplier has the sign that it has at a solution.
      if (!options_.gauss_newton || multiplier < 0) add_cone_curvature(row, multiplier, H);
    }
    if (curved_) {
      if (!options_.gauss_newton) {
        auto gradient = z_scratch_.head(nz);
        gradient.setZero();
        if (k < problem_.knots()) {
          fill_dynamics(knot);
          add_gap_curvature(k, H);
          gradient.noalias() += matrix_.transpose() * costates_.col(k + 1);
        }
        gradient += weight * knot.gradient;
        const int offset = problem_.constraint_offset(k);
        gradient.noalias() +=
            knot.C.transpose() * lagrangian_.multiplier.segment(offset, knot.C.rows());
        if (k > 0) {
          charts_[k].pull_hessian(H);
          charts_[k].add_curvature(gradient.head(ndx), H);
        }
      } else if (k > 0) {
        charts_[k].pull_hessian(H);
      }
    }
    for (const auto& [r, c] : hessian_entries_[k]) *out++ = H(r, c);
  }
}

}  // namespace conddp
