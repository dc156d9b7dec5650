#pragma once

#include <array>

#include "problem_file/model/spec_values.hpp"
#include "robot/contact.hpp"

namespace conddp {

/// A frame that can touch the world, or another frame, with its force limits.
struct ContactSpec {
  Name name;
  Name frame;
  std::optional<Name> to;  ///< the frame that is touched; absent: the world
  ContactKind kind = ContactKind::point;
  FrameAxes axes = FrameAxes::world_aligned;
  Vector3<double> normal{0, 0, 1};         ///< unit vector, in `axes`
  std::optional<Vector3<double>> tangent;  ///< unit vector of a planar contact, in `axes`
  double kp = 0;                           ///< 1/s²
  double kd = 20;                          ///< 1/s
  Place baumgarte_place;
  std::optional<PoseSpec> placement;  ///< reference of kp; absent: the initial one
  double friction = 0.7;
  double min_normal_force = 0;                     ///< N
  double max_normal_force = kUnlimited;            ///< N
  std::optional<std::array<double, 2>> half_size;  ///< of a sole along its x and y, m
};

/// Two frames that are always together: a contact that every phase holds.
struct LoopSpec {
  Name name;
  ContactSpec contact{.kp = 100};  ///< with kd critically damped
};

}  // namespace conddp
