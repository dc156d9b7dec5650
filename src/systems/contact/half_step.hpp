#pragma once

#include "robot/data.hpp"

namespace conddp {

/// A robot halfway through a step at constant velocity, as the midpoint rule of variational
/// mechanics sees it (Marsden and West 2001): momentum P = M(q) v, and load
/// C = g(q) − ∂T/∂q(q, v), less external wrenches, where T = ½ vᵀ M v. For robots of one-DoF
/// joints.
template <class S>
struct HalfStep {
  explicit HalfStep(const RobotModel& robot);

  AlignedVector<S> position;                             ///< q, nq: where it is evaluated
  AlignedVector<S> momentum, load;                       ///< nv
  AlignedVector<S> momentum_q, load_q;                   ///< nv x nv by columns
  const AlignedVector<S>& mass() const { return at.M; }  ///< its lower triangle: ∂P/∂v
  /// ∂C/∂v is −(∂P/∂q)ᵀ.
  S load_v(int row, int column) const { return -momentum_q[row * nv + column]; }

  int nv;
  RobotData<S> at;
  /// Along q + ε v: its derivatives by ε are those of P along the motion.
  RobotData<Dual<S>> along;
  AlignedVector<Dual<S>> q, v, rest;
};

/// Momentum and load at half.position and v, with their derivatives if asked for. `free` is the
/// robot without gravity and external wrenches.
template <class S>
void update_half_step(const RobotModel& robot, const RobotModel& free, const S* v, bool slopes,
                      HalfStep<S>& half);

}  // namespace conddp
