#pragma once

#include <Eigen/Core>

#include "systems/system.hpp"

namespace conddp {

/// Controls that hold the system at rest in a state, in the least-squares sense. For a robot,
/// contact forces act with them against gravity and external wrenches; for other systems they
/// minimize the acceleration.
Eigen::VectorXd quasi_static_control(const System& system, const double* x);

}  // namespace conddp
