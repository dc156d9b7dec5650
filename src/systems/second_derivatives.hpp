#pragma once

#include "spatial/dual.hpp"
#include "spatial/lane.hpp"

namespace conddp {

/// Second derivatives of a system's answer f(z), z = (tangent at x, u), weighted row by row, at one
/// point in each lane. Where f rests on forces λ(z) of contacts, which residuals see too, these
/// have weights as well. Made by System::second_derivatives for a workspace `at`, which holds the
/// point differentiated, and another one, `moving`, which it moves along directions of z for
/// residuals that need their own second derivatives.
///
/// The forces and accelerations y are those that make the residual of the equations of motion
/// r(z, y) vanish. With the adjoint w of these equations, the second derivative of the weighted sum
/// is that of −wᵀr along the graph of y(z), and wᵀr is linear in y: what is differentiated twice is
/// inverse dynamics, in O(nv) for each direction.
class SecondDerivatives {
 public:
  virtual ~SecondDerivatives() = default;

  /// How many forces there are.
  virtual int forces() const = 0;
  /// After `at` has been differentiated at (x, u); brings `moving` there.
  virtual void start(const Dual<Lane>* x, const Dual<Lane>* u) = 0;
  /// Whether `finish` adds everything, so that nothing needs to move for the system's sake.
  virtual bool at_once() const { return false; }
  /// Gives one of the forces of `moving` the derivative 1, and all others 0.
  virtual void move_force(int row) = 0;
  /// Weights of f (System::rows) and of the forces, for what follows.
  virtual void weigh(const Lane* of_f, const Lane* of_forces) = 0;
  /// Moves `moving` along direction d of z, kinematics and forces; x is the state with that
  /// derivative. Adds to column d of `gradients` (nz x nz by columns) the
  /// derivative of the weighted answer's gradient along d.
  virtual void move(const Dual<Lane>* x, int d, Lane* gradients) = 0;
  /// Adds to `gradients` what comes with the change of y, all of it symmetric.
  virtual void finish(Lane* gradients) = 0;
};

}  // namespace conddp
