#include "problem_file/first_problem/standing_pose.hpp"

#include <algorithm>
#include <cmath>

#include "problem_file/plant/posture.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"

namespace conddp {
namespace {

/// A leg at the zero configuration under an upright base.
class Leg {
 public:
  Leg(const RobotModel& robot, const RobotData<double>& zero, const Limb& limb)
      : joints_(limb.joints) {
    for (const int joint : joints_) {
      const SE3<double> pose = zero.root_pose(robot, joint) * zero.placement[joint];
      origins_.push_back(pose.p);
      axes_.push_back(pose.R * Vector3<double>{0, 0, 1});
    }
    origins_.push_back(frame_placement(robot, zero, limb.tip).p);
    find_knee();
  }

  /// True if the leg hangs down rather than sticks out.
  bool hangs() const {
    const Vector3<double> leg = tip() - origins_.front();
    return std::hypot(leg.x, leg.y) < std::abs(leg.z);
  }
  const Vector3<double>& tip() const { return origins_.back(); }
  /// Where the thigh begins.
  const Vector3<double>& hip() const { return origins_[std::max(thigh_, 0)]; }

  /// Bends a leg that is almost straight: by a radian at the knee, half of it at the joints before
  /// and behind. Then the foot comes up by an eighth of the leg and stays below the hip, if thigh
  /// and shank are equally long.
  void bend(const MultibodySystem& system, std::vector<double>& x) const {
    if (knee_ < 0 || thigh_ < 0) return;
    const double now = angle() + turn(system, x, knee_);
    constexpr double kBent = 0.6, kBend = 1.0;  // rad
    if (std::abs(now) > kBent) return;
    const auto limits = given_limits(system, joints_[knee_]);
    const double q = x[*system.position_index(joints_[knee_])];
    // Knees bend to the side with more room.
    const double side = limits.upper - q >= q - limits.lower - 1e-9 ? 1 : -1;
    move(system, x, knee_, side * kBend - now);
    move(system, x, thigh_, -side * kBend / 2);
    if (ankle_ >= 0) move(system, x, ankle_, -side * kBend / 2);
  }

 private:
  bool parallel(int a, int b) const { return std::abs(dot(axes_[a], axes_[b])) > 0.99; }

  /// The joint that divides the leg most evenly and has one with a parallel axis before it.
  void find_knee() {
    double best = 0;
    for (int joint = 1; joint < std::ssize(axes_); ++joint) {
      int before = joint - 1;
      while (before >= 0 && !parallel(before, joint)) --before;
      if (before < 0) continue;
      const double shorter = std::min(squared_norm(origins_[joint] - origins_[before]),
                                      squared_norm(tip() - origins_[joint]));
      if (shorter <= best) continue;
      best = shorter;
      thigh_ = before;
      knee_ = joint;
    }
    for (int joint = knee_ + 1; knee_ >= 0 && joint < std::ssize(axes_) && ankle_ < 0; ++joint)
      if (parallel(joint, knee_)) ankle_ = joint;
  }

  /// From the thigh to the shank about the knee at the zero configuration.
  double angle() const {
    const Vector3<double>& axis = axes_[knee_];
    const Vector3<double>& end = ankle_ >= 0 ? origins_[ankle_] : tip();
    const auto flat = [&](const Vector3<double>& a) { return a - dot(axis, a) * axis; };
    const Vector3<double> thigh = flat(origins_[knee_] - origins_[thigh_]);
    const Vector3<double> shank = flat(end - origins_[knee_]);
    return std::atan2(dot(axis, cross(thigh, shank)), dot(thigh, shank));
  }

  double turn(const MultibodySystem& system, const std::vector<double>& x, int joint) const {
    return x[*system.position_index(joints_[joint])];
  }

  /// Turns a joint about the axis of the knee, within its limits.
  void move(const MultibodySystem& system, std::vector<double>& x, int joint, double by) const {
    const auto limits = given_limits(system, joints_[joint]);
    double& q = x[*system.position_index(joints_[joint])];
    q += dot(axes_[joint], axes_[knee_]) > 0 ? by : -by;
    q = std::max(limits.lower, std::min(limits.upper, q));
  }

  std::vector<int> joints_;
  std::vector<Vector3<double>> origins_, axes_;  ///< origins of the joints and of the tip
  int thigh_ = -1, knee_ = -1, ankle_ = -1;
};

Vector3<double> center_of(const MultibodySystem& system, const std::vector<double>& x) {
  RobotData<double> data = data_in_state(system, x);
  update_composite_inertias(system.robot(), data);
  return center_of_mass(system.robot(), data);
}

/// Bends the legs and places the feet by inverse kinematics; the base is at the origin.
void place_feet(RobotSurvey& survey) {
  const std::shared_ptr<const MultibodySystem> system = survey.plant.kept.system;
  std::vector<double> zero = survey.x;
  for (const int joint : movable_joints(*system, 0, system->robot().joint_count()))
    zero[*system->position_index(joint)] = 0;
  const RobotData<double> at_zero = data_in_state(*system, zero);
  std::vector<Leg> legs;
  std::vector<int> joints;
  for (const Limb& foot : survey.feet) {
    legs.emplace_back(system->robot(), at_zero, foot);
    legs.back().bend(*system, survey.x);
    joints.insert(joints.end(), foot.joints.begin(), foot.joints.end());
  }
  std::vector<Vector3<double>> places;
  double height = -kUnlimited;  // that all legs reach
  for (const SE3<double>& placement : placements_of_feet(survey)) {
    places.push_back(placement.p);
    height = std::max(height, placement.p.z);
  }
  Vector3<double> middle = Vector3<double>::zero();
  for (std::size_t i = 0; i < legs.size(); ++i) {
    if (legs[i].hangs()) places[i] = {legs[i].hip().x, legs[i].tip().y, 0};
    middle += (1.0 / static_cast<double>(legs.size())) * places[i];
  }
  // The center of mass moves with the legs: a few rounds bring two feet under it.
  std::vector<double> best = survey.x;
  for (int round = 0; round < (legs.size() == 2 ? 4 : 1); ++round) {
    Vector3<double> shift = Vector3<double>::zero();
    if (legs.size() == 2) shift = center_of(*system, best) - middle;
    std::vector<PostureGoal> goals;
    for (std::size_t i = 0; i < legs.size(); ++i) {
      const int frame = survey.feet[i].tip;
      const Vector3<double> p{places[i].x + shift.x, places[i].y, height};
      const Quaternion<double> r = quaternion(placement_in_state(*system, zero, frame).R);
      if (is_sole(survey.feet[i]))
        goals.push_back(
            {frame_placement_residual(system, frame), {p.x, p.y, p.z, r.x, r.y, r.z, r.w}});
      else
        goals.push_back({frame_position_residual(system, frame), {p.x, p.y, p.z}});
    }
    const Posture posture = find_posture(*system, goals, joints, survey.x);
    if (!posture.found()) break;
    best = posture.x;
  }
  survey.x = best;
}

}  // namespace

double rounded(double number) {
  const double result = std::round(number * 1e4) / 1e4;
  return result == 0 ? 0 : result;  // no −0
}

std::vector<SE3<double>> placements_of_feet(const RobotSurvey& survey) {
  std::vector<SE3<double>> placements;
  for (const Limb& foot : survey.feet)
    placements.push_back(placement_in_state(*survey.plant.multibody(), survey.x, foot.tip));
  return placements;
}

void stand_up(RobotSurvey& survey) {
  const MultibodySystem& system = *survey.plant.multibody();
  if (survey.posture.empty()) {
    std::copy_n(system.robot().neutral_configuration().begin(), 3, survey.x.begin());
    place_feet(survey);
  }
  for (const int joint : movable_joints(system, 0, system.robot().joint_count()))
    survey.x[*system.position_index(joint)] = rounded(survey.x[*system.position_index(joint)]);
  std::fill_n(survey.x.begin(), 3, 0.0);
  double height = 0;
  for (const SE3<double>& placement : placements_of_feet(survey))
    height += placement.p.z / static_cast<double>(survey.feet.size());
  survey.x[2] = rounded(-height);
}

}  // namespace conddp
