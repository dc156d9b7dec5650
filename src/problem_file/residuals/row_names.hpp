#pragma once

#include <string>
#include <vector>

namespace conddp {

/// Rows of residuals on positions: m.
inline const std::vector<std::string> kPositionNames = {"x", "y", "z"};
/// Rows of residuals on velocities of frames and contacts: m/s, rad/s.
inline const std::vector<std::string> kTwistNames = {"vx", "vy", "vz", "wx", "wy", "wz"};

}  // namespace conddp
