#include <stdexcept>

#include "ocp/knot/knot_model.hpp"

namespace conddp {

void KnotModel::set_units(VariableUnits units) {
  if (semi_implicit() || nx() != ndx())
    throw std::invalid_argument("units of states need a flat state space and dense dynamics");
  if (static_cast<int>(units.state.size()) != nx() ||
      static_cast<int>(units.control.size()) != nu())
    throw std::invalid_argument("units need one number per state and per control");
  units_ = std::move(units);
}

template <class S>
KnotInput<S> KnotModel::in_own_units(const KnotInput<S>& given, KnotWorkspace<S>& work) const {
  KnotInput<S> own = given;
  for (int i = 0; i < nx(); ++i) work.own_x_[i] = given.x[i] * S(units_.state[i]);
  for (int i = 0; i < nu(); ++i) work.own_u_[i] = given.u[i] * S(units_.control[i]);
  own.x = work.own_x_.data();
  if (nu() > 0) own.u = work.own_u_.data();
  return own;
}

template <class S>
void KnotModel::give_values_in_units(KnotWorkspace<S>& work) const {
  for (int i = 0; i < nx(); ++i)
    work.given_next_[i] = work.step_.next()[i] * S(1 / units_.state[i]);
}

template <class S>
void KnotModel::give_derivatives_in_units(KnotWorkspace<S>& work, bool hessian) const {
  const auto unit = [&](int column) {
    return S(column < ndx() ? units_.state[column] : units_.control[column - ndx()]);
  };
  for (int c = 0; c < nz(); ++c) work.gradient[c] *= unit(c);
  if (hessian)
    for (std::size_t i = 0; i < pattern_.size(); ++i)
      work.hessian[i] *= unit(pattern_[i].first) * unit(pattern_[i].second);
  for (std::size_t i = 0; i < constraint_pattern_.size(); ++i)
    work.constraint_jacobian[i] *= unit(constraint_pattern_[i].second);
  const int rows = jacobian_rows();
  for (int c = 0; c < nz(); ++c)
    for (int r = 0; r < rows; ++r)
      work.given_F_[c * rows + r] = work.step_.F()[c * rows + r] * unit(c) * S(1 / units_.state[r]);
}

#define CONDDP_INSTANTIATE(S)                                                                  \
  template KnotInput<S> KnotModel::in_own_units(const KnotInput<S>&, KnotWorkspace<S>&) const; \
  template void KnotModel::give_values_in_units(KnotWorkspace<S>&) const;                      \
  template void KnotModel::give_derivatives_in_units(KnotWorkspace<S>&, bool) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
