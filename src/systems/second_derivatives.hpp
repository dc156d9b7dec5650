#pragma once

#include "spatial/dual.hpp"
#include "spatial/lane.hpp"

namespace conddp {

/// Second derivatives of a system's output f(z), z = (tangent at x, u), weighted row by row, at one
/// point in each lane. If f depends on contact forces λ(z), which residuals use too, these have
/// weights as well. System::second_derivatives creates the object for two workspaces: `at` holds
/// the linearization point, and `moving` is moved along directions of z for residuals that need
/// their own second derivatives.
///
/// The forces and accelerations y solve the equations of motion r(z, y) = 0. With the adjoint w of
/// these equations, the second derivative of the weighted sum is that of −wᵀr along the graph of
/// y(z). Since wᵀr is linear in y, we differentiate inverse dynamics twice, at O(nv) per direction.
class SecondDerivatives {
 public:
  virtual ~SecondDerivatives() = default;

  /// The number of forces.
  virtual int forces() const = 0;
  /// Brings `moving` to (x, u), after `at` has been differentiated there.
  virtual void start(const Dual<Lane>* x, const Dual<Lane>* u) = 0;
  /// True if `finish` adds everything, so that `move` is not needed for the system itself.
  virtual bool at_once() const { return false; }
  /// Sets the derivative of one force of `moving` to 1 and all others to 0.
  virtual void move_force(int row) = 0;
  /// Sets the weights of f (System::rows) and of the forces for subsequent calls.
  virtual void weigh(const Lane* of_f, const Lane* of_forces) = 0;
  /// Moves the kinematics and forces of `moving` along direction d of z; x is the state with that
  /// derivative. Adds the derivative along d of the weighted output's gradient to column d of
  /// `gradients` (nz x nz by columns).
  virtual void move(const Dual<Lane>* x, int d, Lane* gradients) = 0;
  /// Adds the terms due to the change of y to `gradients`; they are symmetric.
  virtual void finish(Lane* gradients) = 0;
};

}  // namespace conddp
