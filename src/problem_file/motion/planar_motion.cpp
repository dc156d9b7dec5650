#include "problem_file/motion/planar_motion.hpp"

#include <cmath>

namespace conddp {
namespace {

struct Point {
  double x, y;
};

Point turned(double angle, const Point& p) {
  if (angle == 0) return p;
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x - s * p.y, s * p.x + c * p.y};
}

bool is_planar(const PlantPart& part) { return part.spec->base == UrdfOptions::Base::planar; }

bool is_fixed(const Plant& plant, const PlantPart& part) {
  if (part.spec == nullptr || part.joint_count == 0) return true;
  return !is_planar(part) && plant.robot().joints[part.first_joint].type != JointType::floating;
}

/// Position of a base in the plane, and heading of its x axis.
struct Stand {
  Point position;
  double heading;
};

Stand stand_of(const Plant& plant, const PlantPart& part, const std::vector<double>& x) {
  const MultibodySystem& system = *plant.multibody();
  const int first = *system.position_index(part.first_joint);
  if (is_planar(part)) {
    const auto value = [&](int i) { return x[*system.position_index(part.first_joint + i)]; };
    return {{value(0), value(1)}, value(2)};
  }
  const double* q = x.data() + first + 3;
  // The base's x axis in the world.
  const double forward = 1 - 2 * (q[1] * q[1] + q[2] * q[2]);
  const double left = 2 * (q[0] * q[1] + q[2] * q[3]);
  return {{x[first], x[first + 1]}, std::atan2(left, forward)};
}

/// The plane of a base's motion, with its normal as z axis. A planar base may have any plane.
SE3<double> plane_of(const PlantPart& part) {
  SE3<double> plane = SE3<double>::identity();
  if (!is_planar(part) || !part.spec->placement) return plane;
  const PoseSpec& placement = *part.spec->placement;
  if (placement.position) plane.p = *placement.position;
  if (placement.orientation) plane.R = rotation_matrix(*placement.orientation);
  return plane;
}

/// The vertical in the axes of a base's plane.
Vector3<double> upward(const PlantPart& part) {
  return transpose_times(plane_of(part).R, Vector3<double>{0, 0, 1});
}

/// The horizontal direction in a base's plane, in its axes; empty if the plane is level.
std::optional<Point> level_direction(const PlantPart& part) {
  constexpr double kLevel = 1e-6;
  const Vector3<double> up = upward(part);
  const double slope = std::hypot(up.x, up.y);
  if (slope < kLevel) return std::nullopt;
  return Point{up.y / slope, -up.x / slope};
}

}  // namespace

PlanarMotion along_arc(const PlanarMotion& step, double time) {
  const double angle = step.yaw * time;
  // Chord over arc length, along the direction half-way.
  const double half = angle / 2;
  const double ratio = half == 0 ? 1 : std::sin(half) / half;
  const Point p = turned(half, {time * step.x, time * step.y});
  return {ratio * p.x, ratio * p.y, angle};
}

PlanarMotion followed_by(const PlanarMotion& first, const PlanarMotion& then) {
  const Point p = turned(first.yaw, {then.x, then.y});
  return {first.x + p.x, first.y + p.y, first.yaw + then.yaw};
}

bool displace_base(const Plant& plant, const PlantPart& part, const PlanarMotion& motion,
                   std::vector<double>& x) {
  if (is_fixed(plant, part)) return false;
  const MultibodySystem& system = *plant.multibody();
  const Stand stand = stand_of(plant, part, x);
  const Point shift = turned(stand.heading, {motion.x, motion.y});
  const int joint = part.first_joint, first = *system.position_index(joint);
  if (is_planar(part)) {
    const auto position = [&](int i) -> double& { return x[*system.position_index(joint + i)]; };
    const auto velocity = [&](int i) -> double& { return x[*system.velocity_index(joint + i)]; };
    const Vector3<double> up = upward(part);
    position(0) += shift.x + motion.rise * up.x;
    position(1) += shift.y + motion.rise * up.y;
    position(2) += motion.yaw;
    const Point v = turned(motion.yaw, {velocity(0), velocity(1)});
    velocity(0) = v.x;
    velocity(1) = v.y;
    return true;
  }
  x[first] += shift.x;
  x[first + 1] += shift.y;
  x[first + 2] += motion.rise;
  if (motion.yaw == 0) return true;
  double* q = x.data() + first + 3;
  const Quaternion<double> turn{0, 0, std::sin(motion.yaw / 2), std::cos(motion.yaw / 2)};
  const Quaternion<double> result = turn * Quaternion<double>{q[0], q[1], q[2], q[3]};
  q[0] = result.x, q[1] = result.y, q[2] = result.z, q[3] = result.w;
  return true;
}

void bring_base(const Plant& plant, const PlantPart& part, const std::vector<double>& to,
                std::vector<double>& x) {
  if (is_fixed(plant, part)) return;
  const Stand from = stand_of(plant, part, x), goal = stand_of(plant, part, to);
  Point way{goal.position.x - from.position.x, goal.position.y - from.position.y};
  double turn = goal.heading - from.heading;
  if (const auto level = level_direction(part)) {
    const double along = level->x * way.x + level->y * way.y;
    way = {along * level->x, along * level->y};
    turn = 0;
  }
  way = turned(-from.heading, way);
  displace_base(plant, part, {way.x, way.y, turn}, x);
}

std::optional<Vector3<double>> displaced_point(const Plant& plant, const PlantPart& part,
                                               const PlanarMotion& motion,
                                               const std::vector<double>& x,
                                               const Vector3<double>& point) {
  if (is_fixed(plant, part)) return std::nullopt;
  const Stand stand = stand_of(plant, part, x);
  const SE3<double> plane = plane_of(part);
  const Vector3<double> p = transpose_times(plane.R, point - plane.p);
  const Point shift = turned(stand.heading, {motion.x, motion.y});
  const Point arm = turned(motion.yaw, {p.x - stand.position.x, p.y - stand.position.y});
  return plane.R * Vector3<double>{stand.position.x + arm.x + shift.x,
                                   stand.position.y + arm.y + shift.y, p.z} +
         plane.p + Vector3<double>{0, 0, motion.rise};
}

}  // namespace conddp
