#include "problem_file/spec/residual_kind.hpp"

namespace conddp {
namespace {

using enum ResidualKind;

constexpr ResidualInfo kTable[] = {
    {"state", kState, "the state minus a reference, or the chosen columns of it", false, false,
     false, true, false, true},
    {"control", kControl, "the control minus a reference", false, false, false, true, true},
    {"control_rate", kControlRate, "the control minus the one before, in the control's unit", false,
     false, false, false, true},
    {"joint_position", kJointPosition, "joint positions minus a reference, rad or m", true, false,
     true, true, false},
    {"joint_velocity", kJointVelocity, "joint velocities minus a reference, rad/s or m/s", true,
     false, true, true, false},
    {"joint_acceleration", kJointAcceleration,
     "joint accelerations minus a reference, rad/s² or m/s²", true, false, true, true, true},
    {"frame_position", kFramePosition, "the origin of a frame minus a point of the world, m", true,
     true, false, true, false},
    {"frame_rotation", kFrameRotation, "rotation vector from a reference to a frame, rad", true,
     true, false, true, false},
    {"frame_placement", kFramePlacement,
     "logarithm of a frame's pose seen from a reference, m, rad", true, true, false, true, false},
    {"frame_velocity", kFrameVelocity, "velocity of a frame minus a reference, m/s and rad/s", true,
     true, false, true, false, false, true},
    {"com_position", kComPosition, "centre of mass minus a point of the world, m", true, false,
     false, true, false},
    {"control_gravity", kControlGravity,
     "actuated forces minus those that hold the robot against gravity, Nm or N", true, false, false,
     false, true},
    {"centroidal_momentum", kCentroidalMomentum,
     "momentum about the centre of mass minus a reference, kg m/s and kg m²/s", true, false, false,
     true, false},
    {"contact_force", kContactForce,
     "force on the robot at a contact (and torque, if a surface) minus a reference, N and Nm, "
     "world "
     "axes; Ns and Nms at an impulse",
     true, false, false, true, false, false, false, true},
    {"friction_cone", kFrictionCone, "what a contact's force lacks to lie in its friction cone, N",
     true, false, false, false, false, false, false, true, true},
    {"wrench_cone", kWrenchCone,
     "the same of a sole's force and torque: friction, centre of pressure, yaw torque, N and Nm",
     true, false, false, false, false, false, false, true, true},
    {"center_of_pressure", kCenterOfPressure, "the same of a sole's centre of pressure alone, Nm",
     true, false, false, false, false, false, false, true, true},
    {"distance", kDistance,
     "distances between spheres, capsules and half-spaces, m; negative where they overlap", true,
     false, false, false, false, false, false, false, false, true},
    {"contact_velocity", kContactVelocity,
     "velocity of a contact in the directions that it holds, in its axes, m/s and rad/s", true,
     false, false, false, false, false, false, true},
    {"cycle", kCycle,
     "the state minus the first one, which a phase 'choose' chooses, and minus an offset", false,
     false, false, false, false},
    {"combination", kCombination,
     "linear combinations of columns of the state and of the control, in their units", false, false,
     false, false, false},
};

}  // namespace

std::span<const ResidualInfo> residual_table() { return kTable; }

const ResidualInfo& residual_info(ResidualKind kind) {
  return kTable[static_cast<std::size_t>(kind)];
}

}  // namespace conddp
