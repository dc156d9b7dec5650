#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/knot/knot_model.hpp"
#include "ocp/knot/runge_kutta_second_derivatives.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Exact Hessians of a knot's cost, augmentation and λᵀf, assembled from parts. Parts linear in z
/// add nothing. Gauss-Newton Hessians lack only the curvature of residuals, which is added. The
/// curvature of the dynamics comes from the system. For a rigid-body model this takes a small
/// fraction of the time of dual numbers through all of `differentiate`.
class KnotSecondDerivatives {
 public:
  /// Makes the object for a model and its batches, which must outlive it. Null if the system or the
  /// integrator lacks second derivatives, or if a residual reads data that `moving` does not
  /// differentiate. Also null if the knot integrates costs, has units, or augments the state of a
  /// system whose step is not linear.
  static std::unique_ptr<KnotSecondDerivatives> make(const KnotModel& model, KnotBatch<Lane>& at,
                                                     KnotBatch<Dual<Lane>>& moving);

  /// The Hessian (nz x nz by columns) at the point loaded in `at`; `costates` is the co-state λ
  /// (ndx) of the next node, not read without dynamics. Also writes the outputs of `differentiate`.
  const AlignedVector<Lane>& compute(const Lane* costates);

 private:
  using D = Dual<Lane>;

  /// A cost or constraint whose residual is curved.
  struct Term {
    const Residual* residual;  ///< for a linear image, the residual inside it
    const CostTerm* cost = nullptr;
    const ConstraintTerm* constraint = nullptr;
    int parameters = 0;
    const std::vector<RowBlock>* blocks = nullptr;  ///< of the differentiated Jacobian
    std::vector<bool> moves;                        ///< by column of z: true if curved along it
    AlignedVector<Lane> weights;  ///< slope of cost or augmentation by row; 0 for affine rows
    bool active = false;
  };

  KnotSecondDerivatives(const KnotModel& model, KnotBatch<Lane>& at, KnotBatch<D>& moving);
  /// False if a residual reads data that `moving` does not differentiate.
  bool add_terms();
  bool add_term(Term term, const Residual& residual);
  void find_curvature(Term& term, const Residual& residual) const;
  bool moves_all_of(Reads reads) const;
  std::vector<bool> curved_columns(const std::vector<RowBlock>& blocks,
                                   std::optional<bool> all) const;
  void differentiate_along(int d, bool bends);
  void add_gauss_newton();
  /// Computes the weights of the terms' rows at the point.
  void weigh_terms();
  void weigh_cost(Term& term);
  void weigh_constraint(Term& term);
  /// Writes the slopes of the terms with respect to the forces to force_weights_.
  void weigh_forces();
  void add_weighted_slope(const Term& term, Lane& sum);
  /// Sets up the second derivatives of the dynamics; false if these are not available.
  bool add_dynamics();
  /// Writes the weights of the system's output to system_weights_, from co-states. For a
  /// multi-stage rule, also adds the Hessian terms of the later stages.
  void weigh_system(const Lane* costates);
  void add_later_stages(const Lane* costates);
  /// Adds the derivative of the terms' gradients along d to a column.
  void differentiate_terms(int d, Lane* column);
  /// Jacobian of a term's rows at the moving point.
  const D* moving_jacobian(const Term& term);
  /// Adds the curvature of q ⊕ dt v⁺ in q and v⁺.
  void add_curved_steps(const Lane* costates);
  /// Derivatives of (Ad⁻ᵀ λ, dt Jᵀ λ) of a curved segment with respect to the step dt v⁺.
  struct StepCurvature {
    Lane of_state[6][6], of_velocity[6][6];
  };
  void bend_step(const StateManifold::Segment& s, int offset, const Lane* costates,
                 StepCurvature& out);
  void add_curved_step(const StateManifold::Segment& s, const StepCurvature& curvature, int d);
  void start_system();
  void differentiate_gradients();
  void symmetrize();
  ResidualInput<D> moving_input(const Term& term);

  const KnotModel& model_;
  KnotBatch<Lane>& at_;
  KnotBatch<D>& moving_;
  std::unique_ptr<SecondDerivatives> system_;  ///< null at a node without dynamics
  std::optional<RungeKuttaSecondDerivatives> stages_;
  bool reads_forces_ = false;
  int nz_;
  std::vector<Term> terms_;
  AlignedVector<Lane> system_weights_, force_weights_;
  AlignedVector<Lane> gradients_;  ///< nz x nz by columns: derivatives of the gradient
  AlignedVector<D> moving_residual_, moving_value_, moving_jacobian_, formed_jacobian_;
  AlignedVector<D> step_, state_blocks_, step_blocks_;
};

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
