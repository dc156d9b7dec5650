#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spatial/inertia.hpp"

namespace conddp {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// Revolute and prismatic joints have one coordinate (rad or m) about or along +z of the joint's
/// frame; a floating joint hangs on the world, has q = (position, quaternion x y z w) in the world
/// and v = (linear, angular) in its own frame.
///
/// A parameter is a number on which inertias depend (Load). It rests: to the kernels it is a slider
/// at the world's origin, with the rotor inertia 1 and no mass, on which nothing acts.
enum class JointType { revolute, prismatic, floating, parameter };

/// A joint together with the body that it moves: body i hangs on joint i.
struct Joint {
  std::string name;
  JointType type = JointType::revolute;
  int parent = -1;  ///< joint whose body this one sits on; −1: the world
  int q = 0;        ///< first index in the configuration
  int v = 0;        ///< first index in the velocity
  SE3<double> placement = SE3<double>::identity();    ///< at zero, in the parent's joint frame
  Inertia<double> inertia = Inertia<double>::zero();  ///< of all that moves rigidly with it
  double lower = -kUnlimited;                         ///< position limit, rad or m
  double upper = kUnlimited;                          ///< position limit, rad or m
  double max_velocity = kUnlimited;                   ///< rad/s or m/s
  double max_effort = kUnlimited;                     ///< Nm or N
  double damping = 0;                                 ///< Nm s/rad or N s/m, as the URDF states it
  double friction = 0;       ///< Coulomb friction, Nm or N, as the URDF states it
  double rotor_inertia = 0;  ///< reflected to the joint, kg m² or kg

  int nq() const { return type == JointType::floating ? 7 : 1; }
  int nv() const { return type == JointType::floating ? 6 : 1; }
};

enum class FrameKind { link, joint };

/// A named frame fixed to a joint's body (or to the world, joint −1).
struct Frame {
  std::string name;
  FrameKind kind = FrameKind::link;
  int joint = -1;
  SE3<double> placement = SE3<double>::identity();  ///< in the joint's frame
  double mass = 0;  ///< kg, of the link itself as its file states it; 0 of joints' frames
};

/// A constant wrench on the robot at a frame's origin, in world-aligned axes (N, Nm).
struct ExternalWrench {
  int frame = 0;
  Force<double> wrench = Force<double>::zero();
};

/// What a body carries besides its own inertia: `unit` times the position of a parameter.
struct Load {
  int parameter = 0;                               ///< joint of that type
  int body = 0;                                    ///< joint whose body carries it
  Inertia<double> unit = Inertia<double>::zero();  ///< in that joint's frame
};

/// A joint that follows another one: q = multiplier·q_leader + offset.
struct Mimic {
  int joint = 0;
  int leader = 0;
  double multiplier = 1;
  double offset = 0;
};

/// Trees of rigid bodies: immutable once built, shared by everything that evaluates it.
///
/// Joints stand depth first, children of a link in the order of their joint names, so that every
/// parent precedes its children and trajectories can be exchanged with Pinocchio. A tree's
/// *root frame* is the frame of its floating body, or the world for a tree bolted to it.
class RobotModel {
 public:
  std::string name;
  std::vector<Joint> joints;
  std::vector<Frame> frames;
  std::vector<ExternalWrench> wrenches;
  std::vector<Mimic> mimics;  ///< enforced ones only
  std::vector<Load> loads;
  Vector3<double> gravity{0, 0, -9.81};
  int nq = 0;
  int nv = 0;

  /// For each velocity index the next one towards the root, −1 at the root: the elimination tree
  /// of the joint-space inertia matrix.
  std::vector<int> parent_dof;
  /// For each velocity index the end of those that hang on it: its subtree is [i, subtree_end[i]).
  std::vector<int> subtree_end;
  /// For each joint the floating joint of its tree, −1 for a tree bolted to the world.
  std::vector<int> root;

  /// Numbers q and v and fills parent_dof, subtree_end and root from joints. Throws
  /// std::logic_error where the order of joints is not depth first or a floating joint does not
  /// hang on the world.
  void finalize();
  /// Appends a parameter behind all joints, and finalizes. Returns its joint.
  int add_parameter(const std::string& parameter_name);

  int joint_count() const { return static_cast<int>(joints.size()); }
  std::optional<int> find_joint(std::string_view joint_name) const;
  /// A link's frame wins over a joint's of the same name.
  std::optional<int> find_frame(std::string_view frame_name) const;
  /// Without loads.
  double total_mass() const;
  /// Zero angles, unit quaternions.
  std::vector<double> neutral_configuration() const;
};

}  // namespace conddp
