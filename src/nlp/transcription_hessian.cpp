#include "nlp/transcription.hpp"

namespace conddp {
namespace {

/// Weight that stands for none where the Lagrangian's Hessian is asked for without the cost.
constexpr double kNoWeight = 1e-30;

}  // namespace

/// weight Cᵀ ∇²h C of pairs.
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
  if (gauss_newton_ && exact_in_place_) {
    differentiated_ = false;
    differentiate();
  }
  if (!gauss_newton_) {
    exact_in_place_ = true;
    // The evaluator has the cost with weight one.
    if (weight == 0) weight = kNoWeight;
    lagrangian_.multiplier /= weight;
    costates_ /= weight;
    evaluator_.lagrangian_hessian(trajectory_, costates_, linearization_, &lagrangian_);
    lagrangian_.multiplier *= weight;
    costates_ *= weight;
  }
  for (int k = 0; k <= problem_.knots(); ++k) {
    const KnotLinearization& knot = linearization_.knots[k];
    const int nz = static_cast<int>(knot.gradient.size());
    Eigen::MatrixXd& H = block_;
    H = weight * knot.hessian();
    int row_index = k == 0 ? 0 : gap_row_[k - 1] + ndx;
    for (const Row& row : rows_[k]) {
      const double multiplier = multipliers[row_index++];
      if (has_pairs(row)) add_pair_curvature(row, multiplier, H);
      if (row.radius > 0 && (!gauss_newton_ || multiplier > 0)) {
        const auto C = knot.C.row(row.first - problem_.constraint_offset(k));
        H.noalias() += (multiplier / row.radius) * C.transpose() * C;
      }
      if (!is_cone(row)) continue;
      // Convex where the multiplier has the sign that it has at a solution.
      if (!gauss_newton_ || multiplier < 0)
        cone_row(row).add_curvature(
            linearization_.constraint.segment(row.first, row.count),
            knot.C.middleRows(row.first - problem_.constraint_offset(k), row.count), multiplier, H);
    }
    if (curved_) {
      if (!gauss_newton_) {
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
    if (is_penalty())
      for (const Pair& pair : pairs_)
        if (pair.node == k) {
          const int z = pair.z - base_[k], s = pair.s - base_[k];
          H(z, s) += weight / epsilon_;
          H(s, z) += weight / epsilon_;
        }
    for (const auto& [r, c] : hessian_entries_[k]) *out++ = H(r, c);
  }
}

}  // namespace conddp
