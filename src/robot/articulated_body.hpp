#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Forward dynamics by the articulated-body algorithm in O(n) (Featherstone 2008, chapter 7), in
/// root-frame coordinates. Writes data.acceleration from generalized forces tau (nv; null means
/// zero). Trajectory optimization factors M instead, because derivatives need the factors anyway.
/// This algorithm is cheaper for accelerations only on long chains, and is an independent check.
template <class S>
void articulated_body_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                               RobotData<S>& data);

}  // namespace conddp
