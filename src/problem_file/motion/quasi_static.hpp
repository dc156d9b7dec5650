#pragma once

#include <Eigen/Core>

#include "systems/system.hpp"

namespace conddp {

/// Controls that hold the system at rest in a state, in the sense of least squares: with the forces
/// of its contacts against gravity and external wrenches if it is a robot, else those that make the
/// acceleration smallest.
Eigen::VectorXd quasi_static_control(const System& system, const double* x);

}  // namespace conddp
