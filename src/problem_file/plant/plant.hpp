#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ocp/residuals/residuals.hpp"
#include "problem_file/spec/components.hpp"
#include "problem_file/spec/spec.hpp"
#include "systems/collocation_system.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// One robot's share of the model.
struct PlantPart {
  std::shared_ptr<const RobotSpec> spec;
  std::string prefix;  ///< of its joints' and frames' names: "arm/", or empty
  int first_joint = 0;
  int joint_count = 0;      ///< parameters do not count: they stand behind all parts
  std::string sha256 = {};  ///< of the URDF file
};

/// One of the systems of phases that have different states or controls.
struct SystemVariant {
  std::string name;  ///< of the first system with these
  std::shared_ptr<const System> system;
};

/// What moves: a closed-form system, or robots as one multibody system.
struct Plant {
  std::shared_ptr<const System> system;
  std::vector<PlantPart> parts;  ///< empty if closed-form
  /// What states have where nothing else is said; empty: the neutral state.
  std::vector<double> usual_state;
  std::optional<ChosenStart> start;  ///< where the first state is chosen
  /// Of each phase, where they differ. All have the same columns of the state.
  std::vector<std::shared_ptr<const System>> systems = {};
  /// Where phases have different states or controls: which there are, which of them has the state
  /// at the beginning of each phase and at the last node, and all controls. Else empty.
  std::vector<SystemVariant> variants = {};
  std::vector<std::size_t> variant_at = {};
  std::vector<Column> controls = {};
  std::string name = {};  ///< that of the system, of a plant that variant() gave

  const std::shared_ptr<const System>& system_in(std::size_t phase) const {
    return systems.empty() ? system : systems[phase];
  }
  /// The plant with a variant as its system, which lacks the others' states and controls.
  Plant variant(std::size_t index) const {
    Plant plant = *this;
    plant.system = variants[index].system;
    plant.name = variants[index].name;
    return plant;
  }
  /// All of them; of a plant without variants itself.
  std::vector<Plant> all_variants() const {
    std::vector<Plant> plants;
    for (std::size_t i = 0; i < variants.size(); ++i) plants.push_back(variant(i));
    if (plants.empty()) plants.push_back(*this);
    return plants;
  }
  /// The plant as it is in a phase, or at the last node, whose number is that of the phases.
  Plant in_phase(std::size_t phase) const {
    return variants.empty() ? *this : variant(variant_at[phase]);
  }
  Plant at_last_node() const { return variants.empty() ? *this : variant(variant_at.back()); }

  /// The robot in the system, or the system as what it is: where steps are contact-implicit, or
  /// where the integrator collocates. Null if it is none of that; they share the system.
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
  /// The system whose controls are the actuators alone.
  const System& actuated() const {
    if (const auto* collocation = system->as_collocation()) return *collocation->inside();
    return system->as_stepping() ? *system->robot_inside() : *system;
  }
};

/// How states are called that are a free duration, and controls that choose it, before the name of
/// the phase.
inline constexpr std::string_view kDurationColumn = "duration/";

/// The controls of the plant's actuators; of a variant's, other phases have the others.
ComponentNames control_names(const Plant& plant);

/// Whether a joint has a coordinate of its own: not a floating base, not a mimic joint, not a
/// parameter.
bool is_independent(const RobotModel& robot, int joint);

/// The robot to which a joint belongs.
const PlantPart& part_of(const Plant& plant, int joint);

/// Names of all independent joints, and of all frames.
std::vector<std::string> joint_names(const RobotModel& robot);
std::vector<std::string> frame_names(const RobotModel& robot);

/// Where a frame is in a state of the system.
SE3<double> placement_in_state(const MultibodySystem& system, const std::vector<double>& x,
                               int frame);

/// The robot's data with the placements and velocities of its bodies in a state of the system.
RobotData<double> data_in_state(const MultibodySystem& system, const std::vector<double>& x);

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
