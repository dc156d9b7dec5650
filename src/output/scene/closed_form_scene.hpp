#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/model/spec_robot.hpp"

namespace conddp {

/// A simple picture of a closed-form system along a trajectory, in the form of motion_scene(). Null
/// for systems that cannot be drawn (linear systems, double integrators with more than three
/// dimensions).
OrderedJson closed_form_scene(const SystemSpec& system, const Trajectory& trajectory);

}  // namespace conddp
