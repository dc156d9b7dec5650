#include "problem_file/plant/plant_builder.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "problem_file/plant/closed_form_builder.hpp"
#include "problem_file/plant/collocation_builder.hpp"
#include "problem_file/plant/kept_goals.hpp"
#include "problem_file/plant/plant_robot.hpp"
#include "problem_file/plant/stepping_builder.hpp"
#include "problem_file/plant/systems_of_phases.hpp"
#include "robot/model.hpp"

namespace conddp {
namespace {

/// Checks that some position satisfies the limits of a joint and of its mimic joints; the error
/// names both joints.
bool check_mimic_limits(const Plant& plant, Diagnostics& out) {
  const RobotModel& robot = plant.robot();
  bool possible = true;
  for (const Mimic& mimic : robot.mimics) {
    const Joint& leader = robot.joints[mimic.leader];
    const Joint& follower = robot.joints[mimic.joint];
    const auto limits = plant.multibody()->limits(mimic.leader);
    if (limits.lower <= limits.upper) continue;
    out.error(
        part_of(plant, mimic.leader).spec->place,
        fmt::format("no position of the joint '{}' (limits {} to {}) satisfies the limits {} to "
                    "{} of the joint '{}', which mimics it with multiplier {} and offset {}",
                    leader.name, leader.lower, leader.upper, follower.lower, follower.upper,
                    follower.name, mimic.multiplier, mimic.offset),
        "correct the limits in the URDF, or write 'mimic: ignore'");
    possible = false;
  }
  return possible;
}

/// A closed-form system, a system of expressions, or the first of several.
std::optional<Plant> build_system(const ProblemSpec& spec, Diagnostics& out) {
  Plant plant;
  plant.system = make_system(*spec.system, spec, out);
  if (!plant.system) return std::nullopt;
  if (const auto* text = std::get_if<ExpressionSystemSpec>(&spec.system->parameters))
    plant.usual_state = text->parsed.usual_state;
  else if (std::holds_alternative<LibrarySystemSpec>(spec.system->parameters))
    plant.usual_state = usual_library_state(*plant.system);
  if (!add_systems_of_phases(spec, plant, out) || !collocate(spec, plant, out)) return std::nullopt;
  return plant;
}

/// All robots as a single model, each with its part of the plant.
std::shared_ptr<RobotModel> load_robots(const ProblemSpec& spec, Plant& plant, Diagnostics& out) {
  std::vector<RobotModel> trees;
  int joints = 0;
  for (const RobotSpec& robot : spec.robots) {
    const std::string prefix = robot.name.value.empty() ? "" : robot.name.value + "/";
    std::string hash;
    auto tree = load_robot(robot, prefix, spec.gravity, hash, out);
    if (!tree) continue;
    plant.parts.push_back({std::make_shared<const RobotSpec>(robot), prefix, joints,
                           tree->joint_count(), std::move(hash)});
    joints += tree->joint_count();
    trees.push_back(std::move(*tree));
  }
  if (trees.size() != spec.robots.size()) return nullptr;
  return std::make_shared<RobotModel>(combine(std::move(trees)));
}

/// Makes the system of a plant whose parts are set. It stays null only with an error.
void make_multibody(const std::shared_ptr<RobotModel>& model, Plant& plant, Diagnostics& out) {
  add_external_wrenches(plant.parts, *model, out);
  const int errors = out.error_count();
  const std::vector<double> starts = add_parameters(plant.parts, *model, out);
  if (out.error_count() > errors) return;
  const auto actuation = make_actuation(plant.parts, *model, out);
  const auto passive = make_passive_forces(plant.parts, *model, out);
  if (!actuation || !passive) return;
  try {
    const auto system = std::make_shared<MultibodySystem>(model, *actuation, *passive);
    plant.system = system;
    if (starts.empty()) return;
    plant.usual_state = system->manifold().neutral();
    const int first = model->joint_count() - static_cast<int>(starts.size());
    for (std::size_t i = 0; i < starts.size(); ++i)
      plant.usual_state[*system->position_index(first + static_cast<int>(i))] = starts[i];
  } catch (const std::invalid_argument& e) {  // unresolvable chains of mimic joints
    out.error(plant.parts.front().spec->place, e.what());
  }
}

}  // namespace

std::optional<Plant> build_plant(const ProblemSpec& spec, Diagnostics& out) {
  if (spec.system) return build_system(spec, out);
  Plant plant;
  const auto model = load_robots(spec, plant, out);
  if (!model) return std::nullopt;
  make_multibody(model, plant, out);
  if (!plant.system || !check_mimic_limits(plant, out)) return std::nullopt;
  plant.kept = kept_goals(spec, plant);
  if (spec.stepping)
    plant.system = build_stepping(spec, plant, out);
  else if (!collocate(spec, plant, out))
    plant.system = nullptr;
  return plant.system ? std::optional(std::move(plant)) : std::nullopt;
}

}  // namespace conddp
