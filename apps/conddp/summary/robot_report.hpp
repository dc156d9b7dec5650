#pragma once

#include <string>

#include "base/json/json_text.hpp"
#include "robot/urdf/urdf.hpp"

namespace conddp {

/// What conddp sees in a robot's file, for people: tree, joints with limits, links with masses,
/// frames, and what is ignored. The result has a model.
std::string robot_text(const UrdfResult& robot);

/// The same for machines, as schemas/inspect.schema.json describes it.
OrderedJson robot_json(const UrdfResult& robot);

}  // namespace conddp
