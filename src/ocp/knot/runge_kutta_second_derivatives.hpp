#pragma once

#include <vector>

#include "ocp/step/integrator.hpp"

namespace conddp {

/// Hessian of λᵀf for an explicit Runge-Kutta step f = x ⊕ θ, from the system's second derivatives
/// at the stages. A backward pass through the stages yields the weights w of each stage's rate, and
/// wᵀẋ is differentiated twice at the stage.
///
/// Stage i lies at x_i = x ⊕ θ_i and has k_i = G(θ_i) ẋ(x_i, u), where G is the inverse right
/// Jacobian of exp. Let A(θ) and H(θ) be the derivatives of x ⊕ θ with respect to x and θ. Along a
/// direction z, the velocity of x_i is A δx + H θ_i'. Differentiating both once more yields the
/// terms of curved spaces: the changes of A, H and G with θ.
class RungeKuttaSecondDerivatives {
 public:
  /// `of_system` must outlive the object.
  RungeKuttaSecondDerivatives(const System& system, const RungeKuttaRule& rule,
                              SecondDerivatives& of_system);

  /// A differentiated step in lanes.
  struct Step {
    const Lane* u;
    Lane dt;
    const IntegratorWorkspace<Lane>& work;
    SystemData<Lane>& data;  ///< overwritten at other states
  };
  /// Adds to `hessian` (nz x nz by columns; only its symmetric part is meaningful) all terms except
  /// those of the system's output at the first stage, which is the knot itself. `weights` receives
  /// the weights of that output (System::rows).
  void add_later_stages(const Step& step, const Lane* costates, Lane* weights, Lane* hessian);

 private:
  using D = Dual<Lane>;
  using Stage = IntegratorWorkspace<Lane>::Stage;
  using Segment = StateManifold::Segment;

  void add_displacement(const Stage& stage, const Lane* pull, Lane* hessian);
  void bend_displacement(const Stage& stage, const Segment& segment, int offset, int d,
                         const Lane* pull, Lane* hessian);
  void distribute(const double* row, int count, const Lane& dt);
  void turn_back(const Stage& stage, const Lane* weight, const SystemData<Lane>& data,
                 Lane* hessian);
  /// First and second derivatives of wᵀG(θ) of one segment along θ, the second times the rate.
  struct Turn {
    Lane slope[6][6], curvature[6][6];
  };
  void differentiate_turns(const Stage& stage, const Lane* weight);
  void differentiate_turn(const Stage& stage, const Segment& segment, const Dual<D>* inverse,
                          const Lane* weight, int j, int k, Turn& turn);
  void add_turn(const Stage& stage, const Segment& segment, const Turn& turn,
                const SystemData<Lane>& data, Lane* hessian);
  Lane rate_slope(const Stage& stage, const SystemData<Lane>& data, int row, int column) const;
  void add_outer(const Stage& stage, int row, Lane* hessian) const;
  void add_system(const Step& step, const Stage& stage, Lane* hessian);
  void differentiate_system(const Step& step, const Stage& stage);
  void find_curved_columns();
  void add_system_along(const Stage& stage, Lane* hessian);
  void pull_through_system(const SystemData<Lane>& data);

  const System& system_;
  const RungeKuttaRule& rule_;
  SecondDerivatives& of_system_;
  int n_, nz_, top_;  ///< ndx, ndx + nu, and rows of the rate above the system's output
  std::vector<AlignedVector<Lane>> weights_;  ///< of each stage's k
  AlignedVector<Lane> slope_;                 ///< of λᵀf with respect to a displacement
  AlignedVector<Lane> turned_, pulled_;       ///< weights of a rate and of a stage's state
  AlignedVector<Lane> row_;                   ///< nz
  AlignedVector<Lane> no_forces_;
  AlignedVector<D> x_, moved_, u_, step_, displacement_, wrt_x_, wrt_dx_;
  AlignedVector<Dual<D>> twice_, inverse_;
  std::vector<Turn> turns_;           ///< one per curved segment
  AlignedVector<Lane> of_stage_;      ///< nz x nz: the system's Hessian at a stage
  std::vector<int> curved_;           ///< nonzero columns of of_stage_
  AlignedVector<Lane> along_, half_;  ///< rows curved_ of ∂(x_i, u)/∂z; of_stage_ times these
};

}  // namespace conddp
