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
  S* next = work.next_.data() + system_->nx();
  next = std::copy_n(in.x + system_->nx(), carried_, next);
  std::copy_n(in.u, remembered_controls(), next);
  if (derivatives) differentiate_memory(in.dt, work);
}

/// F with the rows and columns of the memory. Of the next state only what is remembered depends on
/// what is handed on.
template <class S>
void KnotModel::differentiate_memory(const S& dt, KnotWorkspace<S>& work) const {
  const int n = system_->ndx(), rows = ndx();
  const int base_rows = is_structured(integrator_) ? system_->nv() : n;
  for (int c = 0; c < nz(); ++c) {
    const int base_column = integrated_column(c);
    if (base_column < 0) continue;
    S* out = &work.F_[c * rows];
    fill_column(system_->manifold(), work.integrator_, dt, base_column, base_rows, out);
    std::fill_n(out + n, augmented_, S(0.0));
  }
  for (int i = 0; i < carried_; ++i) work.F_[(n + i) * rows + n + i] = S(1.0);
  for (int i = 0; i < remembered_controls(); ++i)
    work.F_[(rows + i) * rows + n + carried_ + i] = S(1.0);
}

/// The column of the integrator's Jacobian that belongs to a column of z; −1 where the system's
/// next state does not depend on it.
int KnotModel::integrated_column(int column) const {
  const int n = system_->ndx();
  if (column < n) return column;
  if (column < ndx()) {  // the memory
    const int control = column - n - carried_;
    return has_linear_controls() && control >= 0 ? n + control : -1;
  }
  const int control = column - ndx();
  if (!has_linear_controls()) return n + control;
  if (info_of(integrator_).kind == StepKind::runge_kutta) return n + system_->nu() + control;
  return control < remembered_controls() ? -1 : n + control;  // the end counts through the slopes
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
  const S* by_step = &base.F[base.variables * base_rows];
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
