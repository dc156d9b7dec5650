#include "solvers/value.hpp"

#include "solvers/curved_blocks.hpp"
#include "solvers/lane_gemm.hpp"

namespace conddp {
namespace {

using StateBlock = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

CurvedBlock block(const StateBlock& B, int n) { return {B.data(), n, 6}; }

}  // namespace

ActionValue::ActionValue(int ndx, int max_nu)
    : ndx_(ndx), nu_(max_nu), gradient_(ndx + max_nu), hessian_(ndx + max_nu, ndx + max_nu) {}

ValuePropagation::ValuePropagation(int ndx, int max_nu)
    : scratch_(ndx),
      pulled_(ndx + max_nu),
      Ft_(ndx + max_nu, ndx),
      FtP_(ndx + max_nu, ndx),
      M_(ndx, ndx),
      T_(ndx, ndx),
      P11_(ndx, ndx),
      P22_(ndx, ndx),
      columns_(ndx, max_nu),
      columns2_(ndx, max_nu) {}

void ValuePropagation::propagate(const KnotLinearization& knot, const ValueFunction& next,
                                 ActionValue& q) {
  q.resize(knot.nu());
  auto pulled = pulled_.head(q.nz());
  knot.apply_transpose(next.Vx, pulled, scratch_);
  q.Qz() = knot.gradient + pulled;
  q.Qzz() = knot.hessian;
  const int rows = static_cast<int>(knot.F.rows());
  Ft_.resize(q.nz(), rows);
  FtP_.resize(q.nz(), rows);
  transpose(knot.F.data(), rows, rows, q.nz(), Ft_.data(), Ft_.stride());
  if (knot.semi_implicit) {
    add_semi_implicit(knot, next.Vxx, q);
  } else {
    multiply(Store::set, FtP_.block(), Ft_.block(), Factor::of_eigen(next.Vxx));
    multiply_lower(Store::add, q.Qzz_lanes().block(), Ft_.block(), Factor::transposed(FtP_));
  }
  mirror_lower(q.Qzz_lanes().block());
}

/// With M = dt P₁₁ H + P₁₂ the transformed blocks are P̃₁₁ = Aᵀ P₁₁ A, P̃₁₂ = Aᵀ M and
/// P̃₂₂ = P₂₂ + dt (Hᵀ M + P₂₁ H); then Qzz gains E P̃₁₁ Eᵀ + E P̃₁₂ F + (E P̃₁₂ F)ᵀ + Fᵀ P̃₂₂ F,
/// where Eᵀ picks δq. Of that the lower triangle is formed: its columns δq are
/// Fᵀ (F P̃₂₂ + P̃₂₁) and, where the rows are δq too, P̃₁₁ + P̃₁₂ F.
void ValuePropagation::add_semi_implicit(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx,
                                         ActionValue& q) {
  const int nv = static_cast<int>(knot.F.rows());
  const double dt = knot.dt;
  for (LaneMatrix* X : {&M_, &T_, &P11_, &P22_}) X->resize(nv, nv);
  auto M = M_.flat(), T = T_.flat(), P11 = P11_.flat(), P22 = P22_.flat();
  const auto rows = [&](const std::vector<StateBlock>& B, LaneMatrix& X) {
    for (std::size_t s = 0; s < knot.curved.size(); ++s) {
      const int at = knot.curved[s].dx;
      transform_rows(block(B[s], knot.curved[s].n), X.data() + at, X.stride(), nv);
    }
  };
  const auto columns = [&](const std::vector<StateBlock>& B, LaneMatrix& X) {
    for (std::size_t s = 0; s < knot.curved.size(); ++s) {
      const int at = knot.curved[s].dx;
      transform_columns(block(B[s], knot.curved[s].n), X.col(at), X.stride(), nv);
    }
  };

  P11_.view() = Vxx.topLeftCorner(nv, nv);
  P22_.view() = Vxx.bottomRightCorner(nv, nv);
  M = P11;
  columns(knot.H, M_);
  T_.view() = Vxx.topRightCorner(nv, nv);
  M = dt * M + T;
  T_.view() = Vxx.bottomLeftCorner(nv, nv);
  columns(knot.H, T_);
  P22 += dt * T;
  T = M;
  rows(knot.H, T_);
  P22 += dt * T;
  rows(knot.A, M_);  // P̃₁₂
  columns(knot.A, P11_);
  rows(knot.A, P11_);  // P̃₁₁

  LaneMatrix& Q = q.Qzz_lanes();
  Q.view().topLeftCorner(nv, nv) += P11_.view();
  multiply_lower(Store::add, Q.block(nv, 0, nv), M_.block(), Factor::of_eigen(knot.F));
  multiply(Store::set, FtP_.block(), Ft_.block(), Factor::of(P22_));
  FtP_.view().topRows(nv) += M_.view();
  multiply_lower(Store::add, Q.block(), Ft_.block(), Factor::transposed(FtP_));
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
  const int stride = static_cast<int>(columns_.rows());
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    const int at = knot.curved[s].dx, n = knot.curved[s].n;
    const StateBlock Ht = knot.H[s].transpose();
    transform_rows(block(Ht, n), columns_.data() + at, stride, nu);
  }
  auto upper = columns2_.topLeftCorner(nv, nu);
  upper = work;  // μ dt H F_u
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    const int at = knot.curved[s].dx, n = knot.curved[s].n;
    transform_rows(block(knot.A[s], n), columns2_.data() + at, stride, nu);
    transform_rows(block(knot.H[s], n), columns_.data() + at, stride, nu);
  }
  columns.topRows(nv) += upper;
  work = knot.dt * work + mu * Fu;
  columns.noalias() += knot.F.transpose() * work;
}

}  // namespace conddp
