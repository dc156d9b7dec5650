#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ocp/residuals.hpp"
#include "problem_file/spec.hpp"
#include "systems/collocation_system.hpp"
#include "systems/stepping_system.hpp"

namespace conddp {

/// One robot's share of the model.
struct PlantPart {
  const RobotSpec* spec;
  std::string prefix;  ///< of its joints' and frames' names: "arm/", or empty
  int first_joint = 0;
  int joint_count = 0;
  std::string sha256 = {};  ///< of the URDF file
};

/// What moves: a closed-form system, or robots as one multibody system.
struct Plant {
  std::shared_ptr<const System> system;
  std::shared_ptr<const MultibodySystem> multibody;  ///< the same system, null if closed-form
  /// The same system, where steps find their own contacts; `multibody` is the robot in it.
  std::shared_ptr<const SteppingSystem> stepping;
  /// The same system, where the integrator collocates; around `multibody` if that is there.
  std::shared_ptr<const CollocationSystem> collocation;
  std::vector<PlantPart> parts;      ///< empty if closed-form
  std::optional<ChosenStart> start;  ///< where the first state is chosen

  const RobotModel& robot() const { return multibody->robot(); }
  /// The system whose controls are the actuators alone.
  const System& actuated() const {
    if (collocation) return *collocation->inside();
    return stepping ? *multibody : *system;
  }
};

/// Loads the robots or makes the closed-form system. Notes of the URDF files (what is ignored) are
/// reported as well. The spec must outlive the plant.
std::optional<Plant> build_plant(const ProblemSpec& spec, Diagnostics& out);

/// Whether a joint has a coordinate of its own: not a floating base, not a mimic joint.
bool is_independent(const RobotModel& robot, int joint);

/// The robot to which a joint belongs.
const PlantPart& part_of(const Plant& plant, int joint);

/// Names of all independent joints, and of all frames.
std::vector<std::string> joint_names(const RobotModel& robot);
std::vector<std::string> frame_names(const RobotModel& robot);

/// Where a frame is in a state of the system.
SE3<double> placement_in_state(const MultibodySystem& system, const std::vector<double>& x,
                               int frame);

/// The frame's index; an unknown name is reported at its place.
std::optional<int> find_frame(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out);
/// The index of an independent joint.
std::optional<int> find_joint(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out);
/// The independent joints that a name means, several where it has a `*`; none is reported.
std::vector<int> find_joints(const RobotModel& robot, const Name& name, const std::string& prefix,
                             Diagnostics& out);

}  // namespace conddp
