#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Forward dynamics by articulated bodies in O(n) (Featherstone 2008, chapter 7), in root-frame
/// coordinates. Writes data.acceleration from generalised forces tau (nv; null means zero).
/// The factorisation of M is what trajectories use, since derivatives need it anyway; this is the
/// cheaper way for accelerations alone on long chains, and an independent check.
template <class S>
void articulated_body_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                               RobotData<S>& data);

}  // namespace conddp
