#pragma once

#include <urdf_model/model.h>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// Model of a checked URDF tree. Fixed and locked joints are merged, and every joint's axis is
/// rotated to +z. Anything that cannot be built is an error in the report; the model must then not
/// be used.
RobotModel build_model(const urdf::ModelInterface& tree, const UrdfOptions& options,
                       UrdfReport& report);

}  // namespace conddp
