#include "problem_file/motion/placed_frames.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

PostureGoal goal_of(const PoseSpec& pose, int frame,
                    const std::shared_ptr<const MultibodySystem>& system) {
  const Vector3<double> p = pose.position.value_or(Vector3<double>::zero());
  const Quaternion<double> q = pose.orientation.value_or(Quaternion<double>{0, 0, 0, 1});
  if (!pose.orientation) return {frame_position_residual(system, frame), {p.x, p.y, p.z}};
  if (!pose.position) return {frame_rotation_residual(system, frame), {q.x, q.y, q.z, q.w}};
  return {frame_placement_residual(system, frame), {p.x, p.y, p.z, q.x, q.y, q.z, q.w}};
}

/// The joints that may move; a planar base is its robot's first three.
std::vector<int> joints_of(const Plant& plant) {
  std::vector<int> joints;
  for (const PlantPart& part : plant.parts) {
    const int base = part.spec->base == UrdfOptions::Base::planar ? 3 : 0;
    for (const int joint :
         movable_joints(*plant.kept.system, part.first_joint + base, part.joint_count - base))
      joints.push_back(joint);
  }
  return joints;
}

/// How far a frame stays from its placement.
std::string distance_text(const PoseSpec& pose, int frame, const MultibodySystem& system,
                          const std::vector<double>& x) {
  const SE3<double> is = placement_in_state(system, x, frame), asked = pose.placement();
  std::string text;
  if (pose.position) text = fmt::format("{:.3g} m", std::sqrt(squared_norm(is.p - asked.p)));
  if (pose.orientation)
    text += fmt::format("{}{:.3g} rad", text.empty() ? "" : " and ",
                        std::sqrt(squared_norm(log_so3(quaternion(transpose(asked.R) * is.R)))));
  return text;
}

/// Open loops and shapes that are too near, in a posture that misses one of these frames.
std::string other_gaps(const Posture& posture, const MultibodySystem& system, std::size_t frames) {
  std::string text;
  const std::vector<Contact>& loops = system.contacts().contacts();
  for (std::size_t i = 0; i < loops.size(); ++i)
    if (posture.gaps[i] > Posture::kMet)
      text += fmt::format(", and the loop '{}' open by {:.3g} m", loops[i].name, posture.gaps[i]);
  double nearness = 0;
  for (std::size_t i = loops.size() + frames; i < posture.gaps.size(); ++i)
    nearness = std::max(nearness, posture.gaps[i]);
  if (nearness > Posture::kMet) text += fmt::format(", and shapes too near by {:.3g} m", nearness);
  return text;
}

}  // namespace

std::vector<WantedFrame> wanted_frames(const StateSpec& state, const PlantPart& part,
                                       const Plant& plant) {
  std::vector<WantedFrame> wanted;
  const auto add = [&](WantedFrame frame) {
    std::erase_if(wanted, [&](const WantedFrame& other) {
      return other.prefix + other.placed.name.value == frame.prefix + frame.placed.name.value;
    });
    wanted.push_back(std::move(frame));
  };
  const auto add_all = [&](const StateSpec& inner, const PlantPart& robot) {
    for (WantedFrame& frame : wanted_frames(inner, robot, plant)) add(std::move(frame));
  };
  for (const PlantPart& robot : plant.parts) {
    if (part.spec != nullptr && robot.spec != part.spec) continue;
    const std::string prefix = part.spec != nullptr ? "" : robot.prefix;
    for (const auto& [name, inner] : robot.spec->configurations)
      if (state.configuration && prefix + name.value == state.configuration->value)
        add_all(inner, robot);
  }
  for (const NamedState& inner : state.robots)
    for (const PlantPart& robot : plant.parts)
      if (robot.spec->name.value == inner.name.value) add_all(inner.state, robot);
  for (const PlacedFrame& frame : state.frames) add({frame, part.prefix});
  return wanted;
}

void place_frames(const std::vector<WantedFrame>& frames, const Plant& plant,
                  std::vector<double>& x, Diagnostics& out) {
  const std::shared_ptr<const MultibodySystem> system = plant.kept.system;
  std::vector<PostureGoal> goals;
  std::vector<int> indices;
  for (const auto& [placed, prefix] : frames) {
    const auto frame = find_frame(plant.robot(), placed.name, prefix, out);
    if (!frame) return;
    indices.push_back(*frame);
    goals.push_back(goal_of(placed.pose, *frame, system));
  }
  goals.insert(goals.end(), plant.kept.goals.begin(), plant.kept.goals.end());
  const Posture posture = find_posture(*system, goals, joints_of(plant), x);
  if (posture.found()) {
    x = posture.x;
    return;
  }
  const auto of_frames = posture.gaps.begin() + system->contacts().count();
  const std::size_t worst = std::max_element(of_frames, of_frames + std::ssize(frames)) - of_frames;
  const PlacedFrame& frame = frames[worst].placed;
  out.error(
      frame.name.place,
      fmt::format("no joint positions were found that put '{}' there: it stays {} away{}",
                  frame.name.value, distance_text(frame.pose, indices[worst], *system, posture.x),
                  other_gaps(posture, *system, frames.size())),
      "joints move within their limits, bases stay, loops close, and shapes of 'distance' "
      "keep apart; places are in the world, in m");
}

}  // namespace conddp
