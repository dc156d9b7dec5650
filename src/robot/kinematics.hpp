#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Writes root, placement and axis from a configuration q (nq).
template <class S>
void update_placements(const RobotModel& model, const S* q, RobotData<S>& data);

/// Writes v and psi_dot from generalized velocities (nv); placements must be current.
template <class S>
void update_velocities(const RobotModel& model, const S* velocity, RobotData<S>& data);

/// Writes a (acceleration minus gravity) from generalized accelerations (nv; null means zero);
/// velocities must be current. `velocity` is that of update_velocities.
template <class S>
void update_accelerations(const RobotModel& model, const S* velocity, const S* acceleration,
                          RobotData<S>& data);

/// Writes psi_ddot and axis_rate for derivatives of velocities, accelerations and forces.
/// Accelerations must be current.
template <class S>
void update_derivative_columns(const RobotModel& model, RobotData<S>& data);

/// Writes body, composite, and column; placements must be current.
template <class S>
void update_composite_inertias(const RobotModel& model, RobotData<S>& data);

}  // namespace conddp
