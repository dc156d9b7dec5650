#pragma once

#include "ocp/knot_model.hpp"

namespace conddp {

/// (∂f/∂z)ᵀ λ of a knot's dynamics, from its workspace after `differentiate`: λ has ndx entries,
/// out nz; mu is room for as many as F has rows.
template <class S>
void transposed_dynamics(const KnotModel& model, const KnotWorkspace<S>& work, const S& dt,
                         const S* lambda, S* mu, S* out) {
  const int n = model.ndx(), nz = model.nz(), rows = model.jacobian_rows();
  const AlignedVector<S>& F = work.F();
  if (!model.semi_implicit()) {
    for (int c = 0; c < nz; ++c) {
      out[c] = S(0.0);
      for (int i = 0; i < rows; ++i) out[c] += F[c * rows + i] * lambda[i];
    }
    return;
  }
  for (int i = 0; i < rows; ++i) mu[i] = lambda[rows + i] + dt * lambda[i];
  const S* step = work.step_blocks().data();
  for (const auto& s : model.manifold().curved()) {
    for (int j = 0; j < s.n; ++j) {
      S sum(0.0);
      for (int i = 0; i < s.n; ++i) sum += step[i * s.n + j] * lambda[s.dx + i];
      mu[s.dx + j] = lambda[rows + s.dx + j] + dt * sum;
    }
    step += StateManifold::kBlockSize;
  }
  for (int c = 0; c < nz; ++c) {
    out[c] = S(0.0);
    for (int i = 0; i < rows; ++i) out[c] += F[c * rows + i] * mu[i];
  }
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
