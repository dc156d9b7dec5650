#pragma once

#include <vector>

#include "ocp/step/integrator_table.hpp"

namespace conddp {

/// Memory of an integrator for one knot of a system.
template <class S>
struct IntegratorWorkspace {
  /// `by_step`: with the derivative by dt, a further column of F. Not of impulses and discrete
  /// systems, which know no dt. `linear`: for controls that are linear in time.
  IntegratorWorkspace(const System& system, Integrator integrator, bool by_step = false,
                      bool linear = false);

  AlignedVector<S> next;          ///< nx
  AlignedVector<S> F;             ///< rows x columns by columns, see integrate_derivatives
  int variables;                  ///< ndx + nu; of linear controls of explicit rules ndx + 2 nu
  int columns;                    ///< variables, or one more with the derivative by dt
  AlignedVector<S> state_blocks;  ///< structured rules: ∂q⁺/∂q per curved segment (by rows)
  AlignedVector<S> step_blocks;   ///< structured rules: ∂q⁺/∂(dt v⁺) per curved segment

  AlignedVector<S> tangent;   ///< ndx
  AlignedVector<S> controls;  ///< nu: linear ones at a stage
  struct Stage {
    AlignedVector<S> theta, x, rate, k;  ///< displacement from the knot, state there, ẋ, θ̇
    AlignedVector<S> Theta, X, K;        ///< derivatives of theta, x, k, ndx x columns
  };
  std::vector<Stage> stages;
  AlignedVector<S> wrt_x, wrt_dx, inverse;  ///< blocks per curved segment
  AlignedVector<Dual<S>> dual_theta, dual_inverse;
};

/// A stage of a step, while the system's data are those there.
template <class S>
struct StageView {
  int stage;
  double passed;  ///< when it is, as a share of the step
  const S* x;
  const S* u;
  const S* X;  ///< ∂x/∂z, ndx x columns; where the step is differentiated
  SystemData<S>& data;
};

/// What looks at the stages of a step one after the other.
template <class S>
class StageVisitor {
 public:
  virtual void visit(const StageView<S>& stage) = 0;

 protected:
  ~StageVisitor() = default;
};

/// One step: writes work.next. The system's data must have been evaluated at (x, u) already; rules
/// with further stages evaluate it elsewhere afterwards. Controls are constant, or go straight from
/// u to `end` where that is given; then the unknowns of implicit rules stand behind `end`, and the
/// rule has to have stages after the beginning (follows_controls). The visitor sees the stages of
/// explicit Runge-Kutta rules.
template <class S>
void integrate(const System& system, Integrator integrator, const S* x, const S* u, const S& dt,
               SystemData<S>& data, IntegratorWorkspace<S>& work, const S* end = nullptr,
               StageVisitor<S>* visitor = nullptr);

/// The same with the derivative of the step with respect to z = (tangent at x, u) in work.F: for
/// structured rules the nv rows of the next velocity (the blocks tell the rest), else all ndx
/// rows. The system's data must have been differentiated at (x, u). The column by dt follows where
/// the workspace has one: of structured rules that of the next velocity, too. Of linear controls,
/// explicit rules have the columns of u and then those of `end`, implicit ones those of u and then
/// those of their unknowns.
template <class S>
void integrate_derivatives(const System& system, Integrator integrator, const S* x, const S* u,
                           const S& dt, SystemData<S>& data, IntegratorWorkspace<S>& work,
                           const S* end = nullptr, StageVisitor<S>* visitor = nullptr);

/// column += column c of ∂(x ⊕ δ)/∂x: of its blocks on curved parts, of the identity elsewhere.
template <class S>
void add_state_column(const StateManifold& manifold, const S* blocks, int c, S* column) {
  for (const auto& segment : manifold.curved()) {
    const int n = segment.n;
    if (c >= segment.dx && c < segment.dx + n) {
      for (int i = 0; i < n; ++i) column[segment.dx + i] += blocks[i * n + c - segment.dx];
      return;
    }
    blocks += StateManifold::kBlockSize;
  }
  column[c] += S(1.0);
}

}  // namespace conddp
