#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ocp/residuals/residuals.hpp"
#include "problem_file/model/components.hpp"
#include "problem_file/model/spec.hpp"
#include "problem_file/plant/posture.hpp"
#include "systems/collocation_system.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// Part of the model that belongs to one robot.
struct PlantPart {
  std::shared_ptr<const RobotSpec> spec;
  std::string prefix;  ///< of its joints' and frames' names: "arm/", or empty
  int first_joint = 0;
  int joint_count = 0;      ///< without parameters, which follow all parts
  std::string sha256 = {};  ///< of the URDF file
};

/// A system of the phases that share its states and controls.
struct SystemVariant {
  std::string name;  ///< of the first system with these columns
  std::shared_ptr<const System> system;
};

/// Goals that every posture of inverse kinematics meets.
struct KeptGoals {
  std::shared_ptr<const MultibodySystem> system;  ///< the robots; holds the loops
  std::vector<PostureGoal> goals;                 ///< distances
};

/// The system that moves: a closed-form system, or robots as one multibody system.
struct Plant {
  std::shared_ptr<const System> system;
  std::vector<PlantPart> parts;  ///< empty if closed-form
  /// Default state; empty: the neutral state.
  std::vector<double> usual_state;
  std::optional<ChosenStart> start;  ///< if the initial state is optimized
  KeptGoals kept = {};               ///< of robots
  /// The system of each phase, if they differ. All have the same state columns.
  std::vector<std::shared_ptr<const System>> systems = {};
  /// The variants, if phases differ in states or controls: the systems, the index of the variant at
  /// the beginning of each phase and at the last node, and all controls. Otherwise empty.
  std::vector<SystemVariant> variants = {};
  std::vector<std::size_t> variant_at = {};
  std::vector<Column> controls = {};
  std::string name = {};  ///< name of the system, in a plant from variant()

  const std::shared_ptr<const System>& system_in(std::size_t phase) const {
    return systems.empty() ? system : systems[phase];
  }
  /// The plant with a variant as its system, without the states and controls of other variants.
  Plant variant(std::size_t index) const {
    Plant plant = *this;
    plant.system = variants[index].system;
    plant.name = variants[index].name;
    return plant;
  }
  /// The plants of all variants; without variants the plant itself.
  std::vector<Plant> all_variants() const {
    std::vector<Plant> plants;
    for (std::size_t i = 0; i < variants.size(); ++i) plants.push_back(variant(i));
    if (plants.empty()) plants.push_back(*this);
    return plants;
  }
  /// The plant in a phase, or at the last node, whose index is the number of phases.
  Plant in_phase(std::size_t phase) const {
    return variants.empty() ? *this : variant(variant_at[phase]);
  }
  Plant at_last_node() const { return variants.empty() ? *this : variant(variant_at.back()); }

  /// Views of the system, which share it: the robot inside, the contact-implicit system, the
  /// collocation system. Null if the system is of another kind.
  std::shared_ptr<const MultibodySystem> multibody() const {
    return {system, system->robot_inside()};
  }
  std::shared_ptr<const SteppingSystem> stepping() const { return {system, system->as_stepping()}; }
  std::shared_ptr<const CollocationSystem> collocation() const {
    return {system, system->as_collocation()};
  }

  const RobotModel& robot() const { return system->robot_inside()->robot(); }
  /// All controls of a problem.
  const std::vector<Column>& all_controls() const {
    return variants.empty() ? actuated().control_columns() : controls;
  }
  /// The system whose controls are only the actuators.
  const System& actuated() const {
    if (const auto* collocation = system->as_collocation()) return *collocation->inside();
    return system->as_stepping() ? *system->robot_inside() : *system;
  }
};

/// Prefix, before the phase name, of states that are free durations and of controls that choose
/// them.
inline constexpr std::string_view kDurationColumn = "duration/";

/// The controls of the plant's actuators. For a variant, controls of other phases are `elsewhere`.
ComponentNames control_names(const Plant& plant);

/// True if a joint has its own coordinate. False for floating bases, mimic joints and parameters.
bool is_independent(const RobotModel& robot, int joint);

/// The robot to which a joint belongs.
const PlantPart& part_of(const Plant& plant, int joint);

/// Names of all independent joints, and of all frames.
std::vector<std::string> joint_names(const RobotModel& robot);
std::vector<std::string> frame_names(const RobotModel& robot);

/// Placement of a frame in a state of the system.
SE3<double> placement_in_state(const MultibodySystem& system, const std::vector<double>& x,
                               int frame);

/// The robot's data with the placements and velocities of its bodies in a state of the system.
RobotData<double> data_in_state(const MultibodySystem& system, const std::vector<double>& x);

/// Index of a frame; an unknown name is reported at its place.
std::optional<int> find_frame(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out);
/// Index of an independent joint.
std::optional<int> find_joint(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out);
/// The independent joints that fit a name, several if it has a `*`. A name that fits no joint is
/// reported.
std::vector<int> find_joints(const RobotModel& robot, const Name& name, const std::string& prefix,
                             Diagnostics& out);

}  // namespace conddp
