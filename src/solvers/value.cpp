#include "solvers/value.hpp"

namespace conddp {
namespace {

/// The n rows of X at `at` ← Bᵀ times them (B has n ≤ 6 rows).
template <class Block, class Matrix>
void transform_rows(const Block& B, int at, int n, Matrix&& X) {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> column(n);
  for (int j = 0; j < X.cols(); ++j) {
    column = X.col(j).segment(at, n);
    X.col(j).segment(at, n).noalias() = B.topLeftCorner(n, n).transpose() * column;
  }
}

/// The n columns of X at `at` ← them times B.
template <class Block, class Matrix>
void transform_columns(const Block& B, int at, int n, Matrix&& X) {
  Eigen::Matrix<double, 1, Eigen::Dynamic, 1, 1, 6> row(n);
  for (int i = 0; i < X.rows(); ++i) {
    row = X.row(i).segment(at, n);
    X.row(i).segment(at, n).noalias() = row * B.topLeftCorner(n, n);
  }
}

}  // namespace

ActionValue::ActionValue(int ndx, int max_nu)
    : ndx_(ndx), nu_(max_nu), gradient_(ndx + max_nu), hessian_((ndx + max_nu) * (ndx + max_nu)) {}

ValuePropagation::ValuePropagation(int ndx, int max_nu)
    : ndx_(ndx),
      scratch_(ndx),
      pulled_(ndx + max_nu),
      PF_(ndx, ndx + max_nu),
      M_(ndx, ndx),
      HtP_(ndx, ndx),
      P22_(ndx, ndx),
      columns_(ndx, max_nu) {}

void ValuePropagation::propagate(const KnotLinearization& knot, const ValueFunction& next,
                                 ActionValue& q) {
  q.resize(knot.nu());
  auto pulled = pulled_.head(q.nz());
  knot.apply_transpose(next.Vx, pulled, scratch_);
  q.Qz() = knot.gradient + pulled;
  q.Qzz() = knot.hessian;
  if (knot.semi_implicit) {
    add_semi_implicit(knot, next.Vxx, q);
  } else {
    add_dense(knot, next.Vxx, q);
  }
  // Only the upper triangle was formed.
  double* Q = q.Qzz().data();
  const int nz = q.nz();
  for (int j = 0; j < nz; ++j) {
    for (int i = 0; i < j; ++i) Q[i * nz + j] = Q[j * nz + i];
  }
}

void ValuePropagation::add_dense(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx,
                                 ActionValue& q) {
  auto PF = PF_.leftCols(q.nz());
  PF.noalias() = Vxx * knot.F;
  q.Qzz().triangularView<Eigen::Upper>() += knot.F.transpose() * PF;
}

/// With M = dt P₁₁ H + P₁₂ the transformed blocks are P̃₁₁ = Aᵀ P₁₁ A, P̃₁₂ = Aᵀ M and
/// P̃₂₂ = P₂₂ + dt (Hᵀ M + (Hᵀ P₁₂)ᵀ); then Qzz gains E P̃₁₁ Eᵀ + E P̃₁₂ F + (E P̃₁₂ F)ᵀ + Fᵀ P̃₂₂ F,
/// where Eᵀ picks δq.
void ValuePropagation::add_semi_implicit(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx,
                                         ActionValue& q) {
  const int nv = static_cast<int>(knot.F.rows());
  const double dt = knot.dt;
  const auto P11 = Vxx.topLeftCorner(nv, nv);
  const auto P12 = Vxx.topRightCorner(nv, nv);
  auto M = M_.topLeftCorner(nv, nv);
  auto HtP12 = HtP_.topLeftCorner(nv, nv);
  auto P22 = P22_.topLeftCorner(nv, nv);
  auto PF = PF_.topLeftCorner(nv, q.nz());
  auto Qzz = q.Qzz();

  M = P11;
  HtP12 = P12;
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    transform_columns(knot.H[s], knot.curved[s].dx, knot.curved[s].n, M);
    transform_rows(knot.H[s], knot.curved[s].dx, knot.curved[s].n, HtP12);
  }
  M = dt * M + P12;
  P22 = Vxx.bottomRightCorner(nv, nv) + dt * HtP12.transpose();
  HtP12 = M;  // from here on Hᵀ M
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    transform_rows(knot.H[s], knot.curved[s].dx, knot.curved[s].n, HtP12);
    transform_rows(knot.A[s], knot.curved[s].dx, knot.curved[s].n, M);
  }
  P22 += dt * HtP12;

  PF.noalias() = P22 * knot.F;
  Qzz.triangularView<Eigen::Upper>() += knot.F.transpose() * PF;
  PF.noalias() = M * knot.F;  // P̃₁₂ F
  Qzz.topRows(nv) += PF;
  auto P11_tilde = P22;
  P11_tilde = P11;
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    transform_columns(knot.A[s], knot.curved[s].dx, knot.curved[s].n, P11_tilde);
    transform_rows(knot.A[s], knot.curved[s].dx, knot.curved[s].n, P11_tilde);
  }
  Qzz.topLeftCorner(nv, nv) += P11_tilde + PF.leftCols(nv).transpose();
}

void ValuePropagation::regularize_state(const KnotLinearization& knot, double mu,
                                        Eigen::Ref<Eigen::MatrixXd> columns) {
  const int nu = knot.nu();
  const auto Fu = knot.F.rightCols(nu);
  const int nv = static_cast<int>(knot.F.rows());
  auto work = columns_.topLeftCorner(nv, nu);
  if (!knot.semi_implicit) {
    work = mu * Fu;
    columns.noalias() += knot.F.transpose() * work;
    return;
  }
  // T_u = (dt H F_u; F_u) and T = (A Eᵀ + dt H F; F).
  work = (mu * knot.dt) * Fu;
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    const int at = knot.curved[s].dx, n = knot.curved[s].n;
    const Eigen::Matrix<double, 6, 6> Ht = knot.H[s].transpose();
    transform_rows(Ht, at, n, work);
  }
  auto upper = PF_.topLeftCorner(nv, nu);
  upper = work;  // μ dt H F_u
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    transform_rows(knot.A[s], knot.curved[s].dx, knot.curved[s].n, upper);
    transform_rows(knot.H[s], knot.curved[s].dx, knot.curved[s].n, work);
  }
  columns.topRows(nv) += upper;
  work = knot.dt * work + mu * Fu;
  columns.noalias() += knot.F.transpose() * work;
}

}  // namespace conddp
