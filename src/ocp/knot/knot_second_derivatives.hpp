#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/knot/knot_batch.hpp"
#include "ocp/knot/runge_kutta_second_derivatives.hpp"
#include "systems/second_derivatives.hpp"

namespace conddp {

/// Exact Hessians of a knot's cost, augmentation and λᵀf from its parts: what is linear in z has
/// none, Gauss-Newton Hessians are exact but for the curvature of residuals, and that of the
/// dynamics comes from the system. A knot of a rigid-body model takes a small part of the time that
/// dual numbers through all of `differentiate` take.
class KnotSecondDerivatives {
 public:
  /// For a model's batches, which have to outlive it. Null where the system or the integrator have
  /// no second derivatives of their own, where the knot adds to the system's state, integrates
  /// costs or has units, or where a residual reads what they do not move.
  static std::unique_ptr<KnotSecondDerivatives> make(const KnotModel& model, KnotBatch<Lane>& at,
                                                     KnotBatch<Dual<Lane>>& moving);

  /// The Hessian (nz x nz by columns) at what `at` has loaded, with λ (ndx) the co-state of the
  /// next node; without dynamics λ is not read. Writes what `differentiate` writes.
  const AlignedVector<Lane>& compute(const Lane* costates);

 private:
  using D = Dual<Lane>;

  /// A cost or constraint whose residual is curved.
  struct Term {
    const Residual* residual;  ///< of a linear image what it is the image of
    const CostTerm* cost = nullptr;
    const ConstraintTerm* constraint = nullptr;
    int parameters = 0;
    const std::vector<RowBlock>* blocks = nullptr;  ///< of the Jacobian that is differentiated
    std::vector<bool> moves;                        ///< by column of z: whether it bends there
    AlignedVector<Lane> weights;  ///< slope of cost or augmentation by row; 0 where affine
    bool active = false;
  };

  KnotSecondDerivatives(const KnotModel& model, KnotBatch<Lane>& at, KnotBatch<D>& moving);
  /// False where a residual reads what is not moved.
  bool add_terms();
  bool add_term(Term term, const Residual& residual);
  void find_curvature(Term& term, const Residual& residual) const;
  bool moves_all_of(Reads reads) const;
  std::vector<bool> curved_columns(const std::vector<RowBlock>& blocks,
                                   std::optional<bool> all) const;
  void differentiate_along(int d, bool bends);
  void add_gauss_newton();
  /// Weights of the terms' rows at the point.
  void weigh_terms();
  void weigh_cost(Term& term);
  void weigh_constraint(Term& term);
  /// Slopes of the terms by the forces, into force_weights_.
  void weigh_forces();
  void add_weighted_slope(const Term& term, Lane& sum);
  /// Second derivatives of the dynamics; false where they have none of their own.
  bool add_dynamics();
  /// Weights of the system's answer from co-states, into system_weights_; of a rule with further
  /// stages with what these add to the Hessian.
  void weigh_system(const Lane* costates);
  void add_later_stages(const Lane* costates);
  /// Adds the derivative of the terms' gradients along d to a column.
  void differentiate_terms(int d, Lane* column);
  /// The Jacobian of a term's rows at the point that moves.
  const D* moving_jacobian(const Term& term);
  /// Adds the curvature of q ⊕ dt v⁺ in q and v⁺.
  void add_curved_steps(const Lane* costates);
  /// Derivatives of (Ad⁻ᵀ λ, dt Jᵀ λ) of a curved part by the step dt v⁺.
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

}  // namespace conddp
