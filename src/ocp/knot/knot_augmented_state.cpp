#include <algorithm>

#include "ocp/knot/knot_model.hpp"

namespace conddp {
namespace {

/// From the step dt v⁺ to the tangent at q⁺, in the curved parts of a column.
template <class S>
void turn_steps(const StateManifold& manifold, const S* step, S* out) {
  for (const auto& segment : manifold.curved()) {
    const int m = segment.n;
    S turned[6];
    for (int i = 0; i < m; ++i) {
      turned[i] = S(0.0);
      for (int j = 0; j < m; ++j) turned[i] += step[i * m + j] * out[segment.dx + j];
    }
    for (int i = 0; i < m; ++i) out[segment.dx + i] = turned[i];
    step += StateManifold::kBlockSize;
  }
}

/// A column of F with all rows of the system's next state, from those that the integrator gives.
template <class S>
void fill_column(const StateManifold& manifold, const IntegratorWorkspace<S>& base, const S& dt,
                 int column, int base_rows, S* out) {
  const int top = manifold.ndx() - base_rows;
  for (int i = 0; i < base_rows; ++i) out[top + i] = base.F[column * base_rows + i];
  if (top == 0) return;
  for (int i = 0; i < top; ++i) out[i] = dt * out[top + i];
  turn_steps(manifold, base.step_blocks.data(), out);
  if (column < top) add_state_column(manifold, base.state_blocks.data(), column, out);
}

}  // namespace

template <class S>
void KnotModel::append_augmented_state(const KnotInput<S>& in, KnotWorkspace<S>& work,
                                       bool derivatives) const {
  const IntegratorWorkspace<S>& base = work.integrator_;
  std::copy(base.next.begin(), base.next.end(), work.next_.begin());
  const S* kept = held_ ? in.x + system_->nx() : in.u;
  for (int i = 0; i < augmented_; ++i) work.next_[system_->nx() + i] = kept[i];
  if (derivatives) differentiate_memory(in.dt, work);
}

/// F with the rows and columns of the memory: of the next state nothing depends on it but a memory
/// that is held.
template <class S>
void KnotModel::differentiate_memory(const S& dt, KnotWorkspace<S>& work) const {
  const int n = system_->ndx(), rows = ndx();
  const int base_rows = is_structured(integrator_) ? system_->nv() : n;
  const auto fill = [&](int column, int base_column) {
    S* out = &work.F_[column * rows];
    fill_column(system_->manifold(), work.integrator_, dt, base_column, base_rows, out);
    std::fill_n(out + n, augmented_, S(0.0));
  };
  for (int c = 0; c < n; ++c) fill(c, c);
  for (int c = rows; c < nz(); ++c) fill(c, c - augmented_);
  const int kept = held_ ? n : rows;  // the first column of what is remembered
  for (int i = 0; i < augmented_; ++i) work.F_[(kept + i) * rows + n + i] = S(1.0);
}

/// What a knot is given, with the time step and the costs' scale of its free duration.
template <class S>
KnotInput<S> KnotModel::at_its_duration(const KnotInput<S>& given) const {
  KnotInput<S> in = given;
  if (!duration_) return in;
  in.dt = step(given.dt, given.x);
  if (duration_->scales_cost) in.cost_scale = given.cost_scale * duration_share(given.x);
  return in;
}

/// The column of the free duration T: ∂x⁺/∂T, of which the integrator gives ∂/∂dt, and the slope of
/// costs that grow with T.
template <class S>
void KnotModel::append_duration(const KnotInput<S>& given, KnotWorkspace<S>& work) const {
  const IntegratorWorkspace<S>& base = work.integrator_;
  const int n = system_->ndx(), rows = ndx(), column = n + duration_->choice;
  const int base_rows = is_structured(integrator_) ? system_->nv() : n;
  const int top = n - base_rows;
  const S* by_step = &base.F[(n + nu()) * base_rows];
  S* out = &work.F_[column * rows];
  for (int i = 0; i < base_rows; ++i) out[top + i] = by_step[i];
  // q⁺ = q ⊕ dt v⁺
  const S dt = step(given.dt, given.x);
  for (int i = 0; i < top; ++i) out[i] = base.next[system_->nq() + i] + dt * by_step[i];
  if (top > 0) turn_steps(system_->manifold(), base.step_blocks.data(), out);
  const S share = given.dt * S(1 / duration_->written);
  for (int i = 0; i < n; ++i) out[i] *= share;
  if (duration_->scales_cost)
    work.gradient[column] += work.cost / given.x[system_->nx() + duration_->choice];
}

#define CONDDP_INSTANTIATE(S)                                                                   \
  template void KnotModel::append_augmented_state(const KnotInput<S>&, KnotWorkspace<S>&, bool) \
      const;                                                                                    \
  template KnotInput<S> KnotModel::at_its_duration(const KnotInput<S>&) const;                  \
  template void KnotModel::append_duration(const KnotInput<S>&, KnotWorkspace<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
