#include "solvers/stages/narrow_stage.hpp"

#include <array>
#include <utility>

#include "solvers/linalg/lane_copy.hpp"

namespace conddp {
namespace {

template <int ndx>
void pull(const KnotLinearization& knot, const Eigen::MatrixXd& Vxx, ActionValue& q) {
  const int nz = q.nz();
  LaneSquare Ft;
  load_columns(Ft, knot.F.data(), ndx, ndx, nz);
  transpose_lanes<ndx>(Ft);
  double FtV[ndx][kLaneWidth];
  const double* V = Vxx.data();
#pragma GCC unroll 8
  for (int c = 0; c < ndx; ++c, V += ndx) {
    Lane sum(0.0);
#pragma GCC unroll 8
    for (int i = 0; i < ndx; ++i) sum += Ft[i] * Lane(V[i]);
    store_lane(FtV[c], sum);
  }
  LaneSquare Q;
  load_columns(Q, knot.hessian().data(), nz, nz, nz);
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) {
    if (c > ndx && c >= nz) break;
    Lane sum(0.0);
#pragma GCC unroll 8
    for (int i = 0; i < ndx; ++i) sum += Ft[i] * Lane(FtV[i][c]);
    Q[c] = sum + Q[c];
  }
  mirror_square(Q);
  LaneMatrix& to = q.Qzz_lanes();
  store_columns(Q, to.data(), to.stride(), kLaneWidth, nz);
}

template <int ndx>
bool form_value(const ActionValue& q, const LaneBlock& Kt, const double* w, const double* k,
                ValueFunction& value) {
  const ConstStridedView Q = q.Qzz();
  const int stride = static_cast<int>(Q.outerStride());
  const double* Qxu = Q.data() + ndx * stride;
  // The gains have no entries below the states, so all sums stay zero there.
  Lane change[ndx], by_w(0.0), by_k(0.0);
#pragma GCC unroll 8
  for (int c = 0; c < ndx; ++c) change[c] = Lane(0.0);
  for (int j = 0; j < q.nu(); ++j, Qxu += stride) {
    const Lane K = load_part(Kt.data + j * Kt.stride, ndx);
#pragma GCC unroll 8
    for (int c = 0; c < ndx; ++c) change[c] += K * Lane(Qxu[c]);
    by_w += K * Lane(w[j]);
    by_k += load_part(Qxu, ndx) * Lane(k[j]);
  }
  LaneSquare V;
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c)
    V[c] = c < ndx ? load_part(Q.data() + c * stride, ndx) + change[c] : Lane(0.0);
  const Lane Vx = load_part(q.Qz().data(), ndx) + by_w + by_k;
  mirror_square(V);
  store_part(value.Vx.data(), Vx, ndx);
  store_columns(V, value.Vxx.data(), ndx, ndx, ndx);
  const Lane zeros = (sum_of_columns(V) + Vx) * Lane(0.0);
  return !any(!(zeros == Lane(0.0)));
}

template <int... kIndex>
constexpr std::array<NarrowStage, sizeof...(kIndex)> all_stages(
    std::integer_sequence<int, kIndex...>) {
  return {NarrowStage{pull<kIndex + 1>, form_value<kIndex + 1>}...};
}

/// Indexed by states − 1; at least one control remains.
constexpr auto kStages = all_stages(std::make_integer_sequence<int, kLaneWidth - 1>());

}  // namespace

const NarrowStage* narrow_stage(int ndx, int nu) {
  return ndx > 0 && nu > 0 && ndx + nu <= kLaneWidth ? &kStages[ndx - 1] : nullptr;
}

}  // namespace conddp
