#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// The end of a branch of a robot: the joints that move it alone, innermost first, and the frame at
/// its tip.
struct Limb {
  std::vector<int> joints;
  int tip = 0;  ///< frame
};

/// Facts about a robot that a first problem depends on. Lengths are in m, in world axes.
struct RobotSurvey {
  std::filesystem::path urdf, srdf;  ///< `srdf`: empty if there is none beside the URDF
  UrdfOptions::Base base = UrdfOptions::Base::fixed;
  NamedNumbers locked;      ///< joints without inertia, and others at ends, with positions
  std::string posture;      ///< group state of the SRDF that `x` has, or empty
  Plant plant;              ///< the robot, actuated at all joints
  std::vector<double> x;    ///< posture at rest within the limits
  std::vector<Limb> feet;   ///< at least two, or none
  Limb arm;                 ///< the longest chain
  std::vector<int> rotors;  ///< frames of rotors and thrusters on the base
};

/// Reads a robot and guesses its kind. Feet are the lowest tips under the root link, which then
/// floats. Fingers, wheels and rotors are locked. Reports files that cannot be read.
std::optional<RobotSurvey> survey_robot(const std::filesystem::path& urdf, Diagnostics& out);

/// True if the foot's limb also turns it: such a foot is a sole, others are points.
bool is_sole(const Limb& foot);

/// True if the axis z points up, within 8 degrees.
bool is_upright(const SE3<double>& pose);

/// Limits of a joint. Equal ones, as in files that leave limits out, do not count.
MultibodySystem::JointLimits given_limits(const MultibodySystem& system, int joint);

/// A name as YAML: in quotes where YAML would read something else.
std::string yaml_name(const std::string& name);

}  // namespace conddp
