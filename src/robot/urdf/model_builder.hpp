#pragma once

#include <urdf_model/model.h>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// The bodies of a checked URDF tree as a model: fixed and locked joints merged, every joint's axis
/// turned to +z. What cannot be built is an error in the report; the model is then of no use.
RobotModel build_model(const urdf::ModelInterface& tree, const UrdfOptions& options,
                       UrdfReport& report);

}  // namespace conddp
