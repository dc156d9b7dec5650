#pragma once

#include "robot/data.hpp"

namespace conddp {

/// A robot halfway through a step at constant velocity, for the midpoint rule of variational
/// mechanics (Marsden and West 2001). It has the momentum P = M(q) v and the load C = g(q) −
/// ∂T/∂q(q, v), less external wrenches, where T = ½ vᵀ M v. For robots with one-DoF joints.
template <class S>
struct HalfStep {
  explicit HalfStep(const RobotModel& robot);

  AlignedVector<S> position;                             ///< q, nq: point of evaluation
  AlignedVector<S> momentum, load;                       ///< nv
  AlignedVector<S> momentum_q, load_q;                   ///< nv x nv by columns
  const AlignedVector<S>& mass() const { return at.M; }  ///< its lower triangle: ∂P/∂v
  /// ∂C/∂v is −(∂P/∂q)ᵀ.
  S load_v(int row, int column) const { return -momentum_q[row * nv + column]; }

  int nv;
  RobotData<S> at;
  /// Along q + ε v: the derivatives by ε are those of P along the motion.
  RobotData<Dual<S>> along;
  AlignedVector<Dual<S>> q, v, rest;
};

/// Computes momentum and load at half.position and v, with their derivatives if `slopes` is true.
/// `free` is the robot without gravity and external wrenches.
template <class S>
void update_half_step(const RobotModel& robot, const RobotModel& free, const S* v, bool slopes,
                      HalfStep<S>& half);

}  // namespace conddp
