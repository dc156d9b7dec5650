#include "solvers/stages/value.hpp"

#include <cstring>

#include "solvers/linalg/curved_blocks.hpp"
#include "solvers/linalg/lane_copy.hpp"
#include "solvers/linalg/lane_gemm.hpp"
#include "solvers/stages/gap_transport.hpp"
#include "solvers/stages/narrow_stage.hpp"
#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

using StateBlock = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

/// Filled lanes are visited one by one if at most one of this many lanes is filled.
constexpr int kListedShare = 4;

/// Q += P, in the rows and columns of P.
void add_square(LaneMatrix& P, LaneMatrix& Q) {
  const int rows = P.rows(), cols = P.cols();
  for (int j = 0; j < cols; ++j)
    for (int row = 0; row < rows; row += kLaneWidth) {
      double* sum = Q.col(j) + row;
      store_lane(sum, load_lane(sum) + load_lane(P.col(j) + row));
    }
}

/// Q += P in the lower triangle, in the rows and columns of P.
void add_lower(LaneMatrix& P, LaneMatrix& Q) {
  for (int j = 0; j < P.cols(); ++j)
    for (int row = j / kLaneWidth * kLaneWidth; row < P.rows(); row += kLaneWidth) {
      double* sum = Q.col(j) + row;
      store_lane(sum, load_lane(sum) + load_lane(P.col(j) + row));
    }
}

/// Q += the Hessian in the lower triangle. Structural zeros are skipped if they predominate.
void add_lower(const KnotHessian& hessian, LaneMatrix& Q) {
  const Eigen::MatrixXd& H = hessian();
  const int n = static_cast<int>(H.rows());
  const int lanes = (n + kLaneWidth - 1) / kLaneWidth;
  const auto add = [&](int row, int column) {
    double* sum = Q.col(column) + row;
    store_lane(sum, load_lane(sum) + load_some(H.col(column).data() + row, n - row));
  };
  // Visiting filled lanes one by one pays only if they are a small part of all lanes.
  if (hessian.fill() == HessianFill::lasting &&
      kListedShare * static_cast<int>(hessian.lasting_lanes().size()) <= n * lanes) {
    for (const auto [row, column] : hessian.lasting_lanes()) add(row, column);
    return;
  }
  for (int j = 0; j < n; ++j)
    for (int row = j / kLaneWidth * kLaneWidth; row < n; row += kLaneWidth) add(row, j);
}

/// G B, with row-major G.
template <int n>
void multiply_block(const double* G, const StateBlock& B, StateBlock& product) {
  const Eigen::Map<const Eigen::Matrix<double, n, n, Eigen::RowMajor>> left(G);
  product.topLeftCorner<n, n>().noalias() = left * B.topLeftCorner<n, n>();
}

/// Rows of a block that acts on n coordinates, padded to lanes, minus the identity if requested.
template <int n>
struct PaddedRows {
  static constexpr int kLanes = (n + kLaneWidth - 1) / kLaneWidth;
  Lane at[n][kLanes];

  PaddedRows(const StateBlock& B, bool minus_identity) {
    for (int i = 0; i < n; ++i)
      for (int l = 0; l < kLanes; ++l)
        for (int r = 0; r < kLaneWidth; ++r) {
          const int j = l * kLaneWidth + r;
          at[i][l].set(r, j < n ? B(i, j) - (minus_identity && i == j ? 1 : 0) : 0);
        }
  }
  /// sum += Bᵀ x.
  void add(const double* x, Lane (&sum)[kLanes]) const {
    for (int i = 0; i < n; ++i)
      for (int l = 0; l < kLanes; ++l) sum[l] += at[i][l] * Lane(x[i]);
  }
};

/// Blocks of V_xx, column-major, from one row of the upper and lower blocks on.
struct ValueRows {
  const double *upper, *lower;
  int stride, nv, left;  ///< `left`: remaining rows

  Lane P11(int j) const { return load_some(upper + j * stride, left); }
  Lane P21(int j) const { return load_some(lower + j * stride, left); }
  Lane P12(int j) const { return load_some(upper + (nv + j) * stride, left); }
  Lane P22(int j) const { return load_some(lower + (nv + j) * stride, left); }
};

/// Transforms the columns of one curved segment in a lane of rows: P₁₁ ← P₁₁ A, M = dt P₁₁ H + P₁₂
/// and P₂₂ ← P₂₂ + dt (P₂₁ H + M).
template <int n>
void transform_columns_of(const ValueRows& V, const StateBlock& A, const StateBlock& H, Lane dt,
                          int first, double* P11, double* M, double* P22, int stride) {
  Lane a[n], c[n];
  for (int k = 0; k < n; ++k) a[k] = V.P11(first + k), c[k] = V.P21(first + k);
  for (int j = 0; j < n; ++j) {
    Lane aA = a[0] * Lane(A(0, j)), aH = a[0] * Lane(H(0, j)), cH = c[0] * Lane(H(0, j));
    for (int k = 1; k < n; ++k) {
      aA += a[k] * Lane(A(k, j));
      aH += a[k] * Lane(H(k, j));
      cH += c[k] * Lane(H(k, j));
    }
    const Lane m = dt * aH + V.P12(first + j);
    store_lane(P11 + j * stride, aA);
    store_lane(M + j * stride, m);
    store_lane(P22 + j * stride, V.P22(first + j) + dt * (cH + m));
  }
}

/// Transforms the rows of one curved segment in all columns: P₂₂ += dt (H − I)ᵀ M, then M ← Aᵀ M
/// and P₁₁ ← Aᵀ P₁₁.
template <int n>
void transform_rows_of(const StateBlock& A, const StateBlock& H, Lane dt, int cols, double* P11,
                       double* M, double* P22, int stride) {
  const PaddedRows<n> by_A(A, false), by_H(H, true);
  constexpr int kLanes = PaddedRows<n>::kLanes;
  for (int j = 0; j < cols; ++j, P11 += stride, M += stride, P22 += stride) {
    Lane aP[kLanes], aM[kLanes], hM[kLanes];
    for (int l = 0; l < kLanes; ++l) aP[l] = aM[l] = hM[l] = Lane(0.0);
    by_A.add(P11, aP);
    by_A.add(M, aM);
    by_H.add(M, hM);
    double sum[kLanes * kLaneWidth];
    for (int l = 0; l < kLanes; ++l) store_lane(sum + l * kLaneWidth, dt * hM[l]);
    std::memcpy(P11, aP, n * sizeof(double));
    std::memcpy(M, aM, n * sizeof(double));
    for (int i = 0; i < n; ++i) P22[i] += sum[i];
  }
}

}  // namespace

ValuePropagation::ValuePropagation(int ndx, int max_nu)
    : scratch_(ndx),
      pulled_(ndx + max_nu),
      moved_(ndx),
      GA_(ndx / 3),
      GH_(GA_.size()),
      Ft_(ndx + max_nu, ndx),
      FtP_(ndx + max_nu, ndx),
      P11_(ndx, ndx),
      P12_(ndx, ndx),
      P22_(ndx, ndx) {}

/// Moves the next value across the gap. On curved spaces, semi-implicit dynamics apply G to their
/// few blocks (G A and G H) instead of V_xx.
inline ValuePropagation::NextValue ValuePropagation::over_gap(const GapTransport* gap,
                                                              const KnotLinearization& knot,
                                                              const ValueFunction& next) {
  if (gap == nullptr || gap->closed()) return {next.Vx, next.Vxx, false};
  if (!gap->flat() && !knot.semi_implicit) {
    moved_ = next;
    gap->pull(moved_);
    return {moved_.Vx, moved_.Vxx, false};
  }
  gap->pull_gradient(next, moved_.Vx);
  return {moved_.Vx, next.Vxx, !gap->flat()};
}

/// Adds E P̃₁₁ Eᵀ + E P̃₁₂ F + (E P̃₁₂ F)ᵀ + Fᵀ P̃₂₂ F to Qzz, where Eᵀ selects δq. Only the lower
/// triangle is formed: Fᵀ (P̃₂₂ F + P̃₂₁ Eᵀ), plus P̃₁₁ + P̃₁₂ F in the block of δq. FtP_ ← the
/// transpose of the factor in parentheses.
inline void ValuePropagation::pull_semi_implicit(const KnotLinearization& knot,
                                                 const NextValue& next, const GapTransport* gap) {
  if (next.turn_blocks) turn_blocks(*gap, knot);
  transform(knot, next.turn_blocks ? GA_ : knot.A, next.turn_blocks ? GH_ : knot.H, next.Vxx);
  multiply(Store::set, FtP_.block(), Ft_.block(), Factor::of(P22_));
  add_square(P12_, FtP_);
}

void ValuePropagation::propagate(const KnotLinearization& knot, const ValueFunction& next,
                                 ActionValue& q, const GapTransport* gap) {
  q.resize(knot.nu());
  const int rows = static_cast<int>(knot.F.rows()), nz = q.nz();
  const NextValue seen = over_gap(gap, knot, next);
  auto pulled = pulled_.head(nz);
  knot.apply_transpose(seen.Vx, pulled, scratch_);
  q.Qz() = knot.gradient + pulled;
  if (!knot.semi_implicit)
    if (const NarrowStage* narrow = narrow_stage(q.ndx(), q.nu()))
      return narrow->pull(knot, seen.Vxx, q);
  Ft_.resize(nz, rows);
  FtP_.resize(nz, rows);
  transpose(knot.F.data(), rows, rows, nz, Ft_.data(), Ft_.stride());
  LaneMatrix& Q = q.Qzz_lanes();
  if (knot.semi_implicit) {
    pull_semi_implicit(knot, seen, gap);
  } else {
    multiply(Store::set, FtP_.block(), Ft_.block(), Factor::of_eigen(seen.Vxx));
  }
  // The product over the whole lower triangle comes first, so that it can overwrite Q.
  multiply_lower(Store::set, Q.block(), Ft_.block(), Factor::transposed(FtP_));
  if (knot.semi_implicit) {
    multiply_lower(Store::add, Q.block(rows, 0, rows), P12_.block(), Factor::of_eigen(knot.F));
    add_lower(P11_, Q);
  }
  add_lower(knot.hessian, Q);
  mirror_lower(Q.block(), q.ndx());
}

/// GA_ ← G A and GH_ ← G H.
void ValuePropagation::turn_blocks(const GapTransport& gap, const KnotLinearization& knot) {
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    const auto multiply = knot.curved[s].n == 6 ? multiply_block<6> : multiply_block<3>;
    multiply(gap.block(s), knot.A[s], GA_[s]);
    multiply(gap.block(s), knot.H[s], GH_[s]);
  }
}

/// With M = dt P₁₁ H + P₁₂, the blocks of V_xx in (δq, δv⁺) are P̃₁₁ = Aᵀ P₁₁ A, P̃₁₂ = Aᵀ M and
/// P̃₂₂ = P₂₂ + dt (Hᵀ M + P₂₁ H). A and H are the identity except for their blocks. A first pass
/// forms all entries as if the blocks did not act on rows; a second pass corrects the rows of the
/// blocks.
void ValuePropagation::transform(const KnotLinearization& knot, const StateBlocks& A,
                                 const StateBlocks& H, const Eigen::MatrixXd& Vxx) {
  const int nv = static_cast<int>(knot.F.rows()), v_stride = static_cast<int>(Vxx.outerStride());
  const Lane dt(knot.dt);
  for (LaneMatrix* X : {&P11_, &P12_, &P22_}) X->resize(nv, nv);
  const int stride = P11_.stride();
  for (int row = 0; row < nv; row += kLaneWidth) {
    const ValueRows V{Vxx.data() + row, Vxx.data() + nv + row, v_stride, nv, nv - row};
    const auto flat = [&](int begin, int end) {
      for (int j = begin; j < end; ++j) {
        const Lane a = V.P11(j), m = dt * a + V.P12(j);
        store_lane(P11_.col(j) + row, a);
        store_lane(P12_.col(j) + row, m);
        store_lane(P22_.col(j) + row, V.P22(j) + dt * (V.P21(j) + m));
      }
    };
    int done = 0;
    for (std::size_t s = 0; s < knot.curved.size(); ++s) {
      const int at = knot.curved[s].dx, n = knot.curved[s].n;
      flat(done, at);
      (n == 6 ? transform_columns_of<6>
              : transform_columns_of<3>)(V, A[s], H[s], dt, at, P11_.col(at) + row,
                                         P12_.col(at) + row, P22_.col(at) + row, stride);
      done = at + n;
    }
    flat(done, nv);
  }
  for (std::size_t s = 0; s < knot.curved.size(); ++s) {
    const int at = knot.curved[s].dx;
    (knot.curved[s].n == 6 ? transform_rows_of<6>
                           : transform_rows_of<3>)(A[s], H[s], dt, nv, P11_.data() + at,
                                                   P12_.data() + at, P22_.data() + at, stride);
  }
}

}  // namespace conddp
