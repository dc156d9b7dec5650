#pragma once

#include <span>
#include <string_view>

namespace conddp {

/// The residuals that a problem file can name.
enum class ResidualKind {
  kState,
  kControl,
  kControlRate,
  kJointPosition,
  kJointVelocity,
  kJointAcceleration,
  kFramePosition,
  kFrameRotation,
  kFramePlacement,
  kFrameVelocity,
  kComPosition,
  kControlGravity,
  kCentroidalMomentum,
  kContactForce,
  kFrictionCone,
  kWrenchCone,
  kCenterOfPressure,
  kDistance,
  kContactVelocity,
  kCycle,
  kCombination,
};

/// What the reader has to know about a residual.
struct ResidualInfo {
  std::string_view name;
  ResidualKind kind;
  std::string_view description;  ///< one line with units
  bool needs_robot;
  bool needs_frame;
  bool takes_joints;
  bool takes_reference;
  bool needs_control;
  bool takes_columns = false;
  bool takes_axes = false;
  bool of_contacts = false;  ///< one for each contact, where the contact is held
  bool is_cone = false;      ///< comes with its own bounds, for a barrier
  bool of_shapes = false;    ///< between pairs of shapes; by default a barrier at a margin
};

std::span<const ResidualInfo> residual_table();
const ResidualInfo& residual_info(ResidualKind kind);

}  // namespace conddp
