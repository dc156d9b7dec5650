#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// Motion of a first problem.
struct FirstMotion {
  /// `by_kind`: robots with feet stand, others reach, bodies with rotors hover.
  enum class Kind { by_kind, stand, gait, reach } kind = Kind::by_kind;
  std::string gait = {};   ///< type of the key `gait`
  std::string frame = {};  ///< that reaches; empty: the tip of the arm
};

/// The text of a problem file for a robot that solves as it is: contacts at its feet, a standing
/// posture, weights in proportion to its mass and torque limits, and comments. Paths are
/// relative to `folder`. Reports robots and motions that do not fit.
std::optional<std::string> first_problem(const std::filesystem::path& urdf,
                                         const FirstMotion& motion,
                                         const std::filesystem::path& folder, Diagnostics& out);

}  // namespace conddp
