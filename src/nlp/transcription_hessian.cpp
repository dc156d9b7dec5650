#include "nlp/transcription.hpp"

namespace conddp {
namespace {

/// Stands for weight 0 if the Lagrangian's Hessian is evaluated without the cost.
constexpr double kNoWeight = 1e-30;

}  // namespace

/// Adds weight Cᵀ ∇²h C of pairs.
void Transcription::add_pair_curvature(const Row& row, double weight,
                                       Eigen::Ref<Eigen::MatrixXd> hessian) {
  const std::vector<RowBlock>& blocks = row.constraint->term->blocks;
  for (int i = 0; i < row.count; i += 2) {
    const double* g = linearization_.constraint.data() + row.first + i;
    const int at = row.first - row.constraint->row + i;
    const int z = blocks[at].columns[0], s = blocks[at + 1].columns[0];
    const Eigen::Vector3d h = weight * pair_curvature(options_.relaxation, g[0], g[1], epsilon_);
    hessian(z, z) += h[0];
    hessian(s, s) += h[2];
    hessian(z, s) += h[1];
    hessian(s, z) += h[1];
  }
}

/// Adds the curvature of the next node's chart, seen through the dynamics.
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
  // The evaluator weights the cost with one; the multipliers are divided by `weight` instead.
  if (!gauss_newton_ && weight == 0) weight = kNoWeight;
  evaluate_hessians(weight);
  for (int k = 0; k <= problem_.knots(); ++k) {
    Eigen::MatrixXd& H = block_;
    H = weight * linearization_.knots[k].hessian();
    add_row_curvature(k, multipliers, H);
    if (curved_) pull_to_chart(k, weight, H);
    if (is_penalty()) add_penalty_curvature(k, weight, H);
    for (const auto& [r, c] : hessian_entries_[k]) *out++ = H(r, c);
    multipliers += rows_[k].size();
    if (k < problem_.knots()) multipliers += problem_.ndx();
  }
  if (spare_ >= 0) *out = weight;
}

/// Evaluates the Hessians of the linearization: Gauss-Newton, or exact for cost + (λᵀf + νᵀg) /
/// weight.
void Transcription::evaluate_hessians(double weight) {
  if (gauss_newton_) {
    if (exact_in_place_) {
      differentiated_ = false;
      differentiate();
    }
    return;
  }
  exact_in_place_ = true;
  lagrangian_.multiplier /= weight;
  costates_ /= weight;
  evaluator_.lagrangian_hessian(trajectory_, costates_, linearization_, &lagrangian_);
  lagrangian_.multiplier *= weight;
  costates_ *= weight;
}

/// Adds the curvature of a node's rows in excess of their constraint rows' curvature, with the
/// multipliers of the rows.
void Transcription::add_row_curvature(int k, const double* multipliers, Eigen::MatrixXd& H) {
  for (const Row& row : rows_[k]) add_row_curvature(row, *multipliers++, H);
}

/// Keeps Gauss-Newton Hessians convex: norms and cones contribute only if the multiplier has its
/// sign at a solution.
void Transcription::add_row_curvature(const Row& row, double multiplier, Eigen::MatrixXd& H) {
  const int k = row.constraint->node;
  const auto C =
      linearization_.knots[k].C.middleRows(row.first - problem_.constraint_offset(k), row.count);
  if (has_pairs(row)) add_pair_curvature(row, multiplier, H);
  if (row.radius > 0 && (!gauss_newton_ || multiplier > 0))
    H.noalias() += (multiplier / row.radius) * C.row(0).transpose() * C.row(0);
  if (is_cone(row) && (!gauss_newton_ || multiplier < 0))
    cone_row(row).add_curvature(linearization_.constraint.segment(row.first, row.count), C,
                                multiplier, H);
}

/// Converts a Hessian from tangent vectors at a node's state to coordinates of its chart.
void Transcription::pull_to_chart(int k, double weight, Eigen::MatrixXd& H) {
  if (gauss_newton_) {
    if (k > 0) charts_[k].pull_hessian(H);
    return;
  }
  const KnotLinearization& knot = linearization_.knots[k];
  auto gradient = z_scratch_.head(knot.gradient.size());
  gradient.setZero();
  if (k < problem_.knots()) {
    fill_dynamics(knot);
    add_gap_curvature(k, H);
    gradient.noalias() += matrix_.transpose() * costates_.col(k + 1);
  }
  gradient += weight * knot.gradient;
  const int offset = problem_.constraint_offset(k);
  gradient.noalias() += knot.C.transpose() * lagrangian_.multiplier.segment(offset, knot.C.rows());
  if (k == 0) return;
  charts_[k].pull_hessian(H);
  charts_[k].add_curvature(gradient.head(problem_.ndx()), H);
}

/// Adds the curvature of z s/ε in the objective.
void Transcription::add_penalty_curvature(int k, double weight, Eigen::MatrixXd& H) const {
  for (const Pair& pair : pairs_) {
    if (pair.node != k) continue;
    const int z = pair.z - base_[k], s = pair.s - base_[k];
    H(z, s) += weight / epsilon_;
    H(s, z) += weight / epsilon_;
  }
}

}  // namespace conddp
