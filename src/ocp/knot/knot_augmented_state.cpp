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
  std::copy_n(in.x + system_->nx(), augmented_, work.next_.data() + system_->nx());
  remember(in.u, work.next_.data());
  for (std::size_t i = 0; i < integrals_.size(); ++i)
    work.next_[system_->nx() + integrals_[i].number] += in.dt * work.integral_rates_[i];
  if (!derivatives) return;
  differentiate_memory(in.dt, work);
  differentiate_integrals(in.dt, work);
}

/// Rates of integrals, before the system's data are those of later stages of the integrator.
template <class S>
void KnotModel::evaluate_integrals(const KnotInput<S>& in, KnotWorkspace<S>& work,
                                   bool derivatives) const {
  for (std::size_t i = 0; i < integrals_.size(); ++i) {
    const IntegralTerm& term = integrals_[i];
    const ResidualInput<S> input = residual_input(term.parameters, in, *work.system_);
    S* rate = work.integral_rates_.data() + i;
    if (derivatives)
      term.residual->differentiate(input, rate, work.integral_jacobians_.data() + term.jacobian);
    else
      term.residual->evaluate(input, rate);
  }
}

/// Rows of integrals in F, which may depend on whatever there is.
template <class S>
void KnotModel::differentiate_integrals(const S& dt, KnotWorkspace<S>& work) const {
  const int rows = ndx();
  for (const IntegralTerm& term : integrals_) {
    const S* derivative = work.integral_jacobians_.data() + term.jacobian;
    const int row = system_->ndx() + term.number;
    for (int column = 0; column < nz(); ++column)
      work.F_[column * rows + row] = S(column == row ? 1.0 : 0.0);
    for (const int column : term.residual->blocks().front().columns)
      work.F_[column * rows + row] += dt * *derivative++;
  }
}

/// F with the rows and columns of the memory. Of the next state only what is remembered or chosen
/// depends on controls besides the system's.
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
  const int behind = rows - handed_on_.count;
  const int from = handed_on_.chosen ? rows + nu() - handed_on_.count : behind;
  for (int i = 0; i < handed_on_.count; ++i) work.F_[(from + i) * rows + behind + i] = S(1.0);
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

/// Input of the knot with the time step of its free duration.
template <class S>
KnotInput<S> KnotModel::at_its_duration(const KnotInput<S>& given) const {
  KnotInput<S> in = given;
  if (!duration_) return in;
  in.dt = step(given.dt, given.x);
  return in;
}

/// Column of the free duration T: ∂x⁺/∂T from the integrator's ∂x⁺/∂dt.
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
  for (std::size_t i = 0; i < integrals_.size(); ++i)
    out[n + integrals_[i].number] += share * work.integral_rates_[i];
}

#define CONDDP_INSTANTIATE(S)                                                                      \
  template void KnotModel::append_augmented_state(const KnotInput<S>&, KnotWorkspace<S>&, bool)    \
      const;                                                                                       \
  template void KnotModel::evaluate_integrals(const KnotInput<S>&, KnotWorkspace<S>&, bool) const; \
  template KnotInput<S> KnotModel::at_its_duration(const KnotInput<S>&) const;                     \
  template void KnotModel::append_duration(const KnotInput<S>&, KnotWorkspace<S>&) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
