#pragma once

#include "problem_file/model/spec.hpp"

namespace conddp {

/// Reads the SRDF files of robots. Group states become configurations, unless the file has one of
/// that name; those of one name in several groups become one. Joints that are fixed or locked are
/// left out, and seven values of a joint that the URDF lacks place a floating base. Pairs of links
/// that do not collide go to CollisionSpec::disabled.
void read_srdf(ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
