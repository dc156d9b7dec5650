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
/// frame. A floating joint has the world as its parent, q = (position, quaternion x y z w) in the
/// world, and v = (linear, angular) in its own frame.
///
/// A parameter is a constant number that inertias depend on (Load). The kernels treat it as a
/// slider at the world's origin, without mass, with the rotor inertia 1, and without forces.
enum class JointType { revolute, prismatic, floating, parameter };

/// A joint and the body that it moves: body i is attached to joint i.
struct Joint {
  std::string name;
  JointType type = JointType::revolute;
  int parent = -1;  ///< joint that moves the parent body; −1: the world
  int q = 0;        ///< first index in the configuration
  int v = 0;        ///< first index in the velocity
  SE3<double> placement = SE3<double>::identity();    ///< at zero, in the parent's joint frame
  Inertia<double> inertia = Inertia<double>::zero();  ///< of everything that moves rigidly with it
  double lower = -kUnlimited;                         ///< position limit, rad or m
  double upper = kUnlimited;                          ///< position limit, rad or m
  double max_velocity = kUnlimited;                   ///< rad/s or m/s
  double max_effort = kUnlimited;                     ///< Nm or N
  double damping = 0;                                 ///< Nm s/rad or N s/m, from the URDF
  double friction = 0;                                ///< Coulomb friction, Nm or N, from the URDF
  double rotor_inertia = 0;                           ///< reflected to the joint, kg m² or kg

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
  double mass = 0;  ///< kg, of the link itself, from its file; 0 for joint frames
};

/// A constant wrench on the robot at a frame's origin, in world-aligned axes (N, Nm).
struct ExternalWrench {
  int frame = 0;
  Force<double> wrench = Force<double>::zero();
};

/// An inertia that a body carries besides its own: `unit` times the position of a parameter.
struct Load {
  int parameter = 0;                               ///< index of a joint of type parameter
  int body = 0;                                    ///< joint whose body carries it
  Inertia<double> unit = Inertia<double>::zero();  ///< in that joint's frame
};

/// A joint that mimics another one: q = multiplier·q_leader + offset.
struct Mimic {
  int joint = 0;
  int leader = 0;
  double multiplier = 1;
  double offset = 0;
};

/// Trees of rigid bodies: immutable once built, and shared by all evaluators.
///
/// Joints are in depth-first order, children of a link in the order of their joint names. So every
/// parent precedes its children, and trajectories can be exchanged with Pinocchio. A tree's *root
/// frame* is the frame of its floating body, or the world for a fixed-base tree.
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

  /// For each velocity index the next one towards the root, −1 at the root: the elimination tree of
  /// the joint-space inertia matrix.
  std::vector<int> parent_dof;
  /// For each velocity index the end of its subtree [i, subtree_end[i]).
  std::vector<int> subtree_end;
  /// For each joint the floating joint of its tree; −1 for a fixed-base tree.
  std::vector<int> root;

  /// Assigns indices in q and v, and fills parent_dof, subtree_end and root from joints. Throws
  /// std::logic_error if the joints are not in depth-first order or the parent of a floating joint
  /// is not the world.
  void finalize();
  /// Appends a parameter after all joints, and finalizes. Returns its joint.
  int add_parameter(const std::string& parameter_name);

  int joint_count() const { return static_cast<int>(joints.size()); }
  std::optional<int> find_joint(std::string_view joint_name) const;
  /// A link's frame takes precedence over a joint's frame of the same name.
  std::optional<int> find_frame(std::string_view frame_name) const;
  /// The mass without loads.
  double total_mass() const;
  /// Zero joint positions, unit quaternions.
  std::vector<double> neutral_configuration() const;
};

/// Combines several trees into one model and concatenates their coordinates in the given order.
///
/// If a tree shares a joint or frame name with an earlier tree, all its names are prefixed by the
/// name of its robot and a slash ("arm/wrist"), with a number if that is taken too ("arm_2/wrist").
/// Trees loaded with a prefix of their own do not clash. Throws std::logic_error if there are no
/// trees or if gravity differs.
RobotModel combine(std::vector<RobotModel> trees);

}  // namespace conddp
