#pragma once

#include "base/json/ordered_json.hpp"
#include "ocp/problem/trajectory.hpp"
#include "problem_file/spec/spec_robot.hpp"

namespace conddp {

/// A simple picture of a closed-form system along a trajectory, in the form of motion_scene(); null
/// for systems that have none (linear ones, double integrators of more than three dimensions).
OrderedJson closed_form_scene(const SystemSpec& system, const Trajectory& trajectory);

}  // namespace conddp
