#pragma once

#include <algorithm>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/knot/knot_model.hpp"

namespace conddp {

namespace detail {

/// Loads the knot's own data, identical for all lanes.
template <class S>
void load_knot(const ShootingProblem& problem, int k, const Augmentation* augmentation,
               KnotBatch<S>& batch) {
  const KnotView& view = problem.knot(k);
  const KnotModel& model = *view.model;
  for (int i = 0; i < model.parameter_count(); ++i) batch.parameters[i] = view.parameters[i];
  batch.dt = view.dt;
  batch.cost_scale = view.cost_scale;
  batch.augmented = augmentation != nullptr;
  if (!batch.augmented) return;
  const int first = problem.constraint_offset(k);
  for (int i = 0; i < model.constraint_rows(); ++i) {
    batch.penalty[i] = augmentation->penalty[first + i];
    batch.shift[i] = augmentation->shift[first + i];
    batch.multiplier[i] = augmentation->multiplier[first + i];
  }
}

/// u ← ū + α k + K (x ⊖ x̄) of a knot, clamped to its bounds if requested.
template <class S>
void follow(const ShootingProblem& problem, int k, const Trajectory& reference,
            const Feedback& feedback, const S& alpha, bool clamp, const S* x, KnotBatch<S>& batch,
            S* u) {
  const KnotModel& model = *problem.knot(k).model;
  const int nx = problem.nx(), n = problem.ndx(), nu = model.nu();
  for (int i = 0; i < nx; ++i) batch.x[i] = reference.x(k)[i];
  problem.manifold().difference(batch.x.data(), x, batch.tangent.data());
  const auto ubar = reference.u(k);
  for (int i = 0; i < nu; ++i) u[i] = S(ubar[i]) + alpha * S(feedback.k[k][i]);
  const double* K = feedback.K[k].data();
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < nu; ++i) u[i] += S(K[j * nu + i]) * batch.tangent[j];
  if (!clamp) return;
  for (int i = 0; i < nu; ++i)
    u[i] = max(S(model.control_lower()[i]), min(S(model.control_upper()[i]), u[i]));
}

/// x⁺ ← f ⊕ (α − 1) gap, which leaves the share 1 − α of the reference's gap.
template <class S>
void contract_gap(const ShootingProblem& problem, int k, const Eigen::MatrixXd& gap, const S& alpha,
                  KnotBatch<S>& batch, S* after) {
  const int n = problem.ndx();
  for (int i = 0; i < n; ++i) batch.tangent[i] = (alpha - S(1.0)) * S(gap(i, k));
  problem.manifold().integrate(batch.work.next().data(), batch.tangent.data(), after);
}

}  // namespace detail

/// Rolls out u = ū + α k + K (x ⊖ x̄) from the problem's initial state, knot by knot. S = double
/// gives one trajectory; S = Lane gives one per lane, each with its own α. `batch_of(k)` is a
/// workspace of knot k's model. `x` receives (N + 1) x nx numbers, `u` the concatenated controls
/// and `cost` the sum. `goes_on(k, check)` is called after each knot; `check` is finite only if all
/// values up to this knot are finite. The rollout ends if it returns false.
template <class S, class BatchOf, class GoesOn>
void roll_out(const ShootingProblem& problem, const Trajectory& reference,
              const Eigen::MatrixXd& gap, const Feedback& feedback, S alpha,
              const RolloutOptions& options, BatchOf batch_of, S* x, S* u, S& cost,
              GoesOn goes_on) {
  const int nx = problem.nx(), N = problem.knots();
  for (int i = 0; i < nx; ++i) x[i] = S(problem.initial_state()[i]);
  cost = S(0.0);
  for (int k = 0; k <= N; ++k, x += nx) {
    const KnotModel& model = *problem.knot(k).model;
    KnotBatch<S>& batch = batch_of(k);
    detail::load_knot(problem, k, options.augmentation, batch);
    if (k < N)
      detail::follow(problem, k, reference, feedback, alpha, options.clamp_controls, x, batch, u);
    model.evaluate(batch.at(x, u), batch.work);
    cost += batch.work.cost;
    cost += batch.work.augmentation;
    S check = cost;
    if (k < N) {
      S* after = x + nx;
      if (options.contract_gaps)
        detail::contract_gap(problem, k, gap, alpha, batch, after);
      else
        std::copy(batch.work.next().begin(), batch.work.next().end(), after);
      for (int i = 0; i < nx; ++i) check += after[i];
      u += model.nu();
    }
    if (!goes_on(k, check)) return;
  }
}

}  // namespace conddp
