#pragma once

#include <string>

#include "base/json/json_text.hpp"
#include "robot/urdf/urdf.hpp"

namespace conddp {

/// The contents of a robot's file as text: tree, joints with limits, links with masses, frames, and
/// ignored parts. The result must contain a model.
std::string robot_text(const UrdfResult& robot);

/// The contents as JSON (schemas/inspect.schema.json).
OrderedJson robot_json(const UrdfResult& robot);

}  // namespace conddp
