#pragma once

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Pulls the co-states λ (ndx) of a semi-implicit Euler knot back to its next velocity v⁺, since x⁺
/// = (q ⊕ dt v⁺, v⁺). Writes μ (nv numbers), from the workspace after `differentiate`.
template <class S>
void pull_back_to_velocity(const KnotModel& model, const KnotWorkspace<S>& work, const S& dt,
                           const S* lambda, S* mu) {
  const int n = model.system().nv();
  for (int i = 0; i < n; ++i) mu[i] = lambda[n + i] + dt * lambda[i];
  const S* step = work.step_blocks().data();
  for (const auto& s : model.manifold().curved()) {
    for (int j = 0; j < s.n; ++j) {
      S sum(0.0);
      for (int i = 0; i < s.n; ++i) sum += step[i * s.n + j] * lambda[s.dx + i];
      mu[s.dx + j] = lambda[n + s.dx + j] + dt * sum;
    }
    step += StateManifold::kBlockSize;
  }
}

namespace detail {

/// out ← Fᵀ x, with F by columns.
template <class S>
void multiply_transposed(const AlignedVector<S>& F, int rows, int columns, const S* x, S* out) {
  for (int c = 0; c < columns; ++c) {
    out[c] = S(0.0);
    for (int i = 0; i < rows; ++i) out[c] += F[c * rows + i] * x[i];
  }
}

}  // namespace detail

/// (∂f/∂z)ᵀ λ of a knot's dynamics, from its workspace after `differentiate`. λ has ndx entries and
/// out has nz; mu is scratch of as many numbers as F has rows.
template <class S>
void transposed_dynamics(const KnotModel& model, const KnotWorkspace<S>& work, const S& dt,
                         const S* lambda, S* mu, S* out) {
  const int n = model.ndx(), nz = model.nz(), rows = model.jacobian_rows();
  const AlignedVector<S>& F = work.F();
  if (!model.semi_implicit()) return detail::multiply_transposed(F, rows, nz, lambda, out);
  pull_back_to_velocity(model, work, dt, lambda, mu);
  detail::multiply_transposed(F, rows, nz, mu, out);
  for (int c = 0; c < n - rows; ++c) out[c] += lambda[c];
  const S* state = work.state_blocks().data();
  for (const auto& s : model.manifold().curved()) {
    for (int j = 0; j < s.n; ++j) {
      out[s.dx + j] -= lambda[s.dx + j];
      for (int i = 0; i < s.n; ++i) out[s.dx + j] += state[i * s.n + j] * lambda[s.dx + i];
    }
    state += StateManifold::kBlockSize;
  }
}

}  // namespace conddp
