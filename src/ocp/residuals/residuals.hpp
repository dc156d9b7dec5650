#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "ocp/terms/residual.hpp"
#include "robot/frames.hpp"
#include "spatial/vector3.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// Linear inequalities lower ≤ A f ≤ upper on a contact's force (3 columns) or wrench (6 columns:
/// force; torque).
struct LinearCone {
  Eigen::MatrixXd A;
  std::vector<double> lower, upper;  ///< −∞ and +∞ if unbounded
};

/// Limits on the force of one contact.
struct FrictionLimits {
  double friction = 0.7;  ///< coefficient μ, including a safety factor
  double min_normal = 0;  ///< N
  double max_normal = std::numeric_limits<double>::infinity();  ///< N
};

/// Friction cone ‖f_t‖ ≤ μ f_n as a pyramid with `faces` ≥ 3 about a unit normal in the axes of f.
/// Outer pyramids circumscribe the cone, inner ones are inscribed in it. The last row is f_n. The
/// smallest rotation from +z to the normal orients the faces. Throws std::invalid_argument if faces
/// < 3, μ ≤ 0 or the limits contradict each other.
LinearCone friction_pyramid(const FrictionLimits& limits, int faces, bool inner,
                            const Vector3<double>& normal);

/// Center of pressure inside the rectangle |x| ≤ half_x, |y| ≤ half_y (m) of a sole with normal +z:
/// |τ_x| ≤ half_y f_z, |τ_y| ≤ half_x f_z. Four rows.
LinearCone center_of_pressure_cone(double half_x, double half_y);

/// Contact wrench cone of a rectangular sole with normal +z (Caron, Pham, Nakamura 2015, eq. 26 to
/// 29): four-sided friction, unilateral normal force, center of pressure, yaw torque. It has 17
/// rows; the last one is f_z. If `inner`, μ / √2 inscribes the friction pyramid in the cone.
LinearCone wrench_cone(const FrictionLimits& limits, double half_x, double half_y, bool inner);

/// The rotation from +z to a unit vector, about their common normal.
Matrix3<double> rotation_to_normal(const Vector3<double>& normal);

/// Factories for the residuals of problems. Each knot provides a reference marked *parameter* (that
/// many numbers). Frames are indices into the robot's frames.

/// x ⊖ reference, all ndx rows. Parameter: a state (nx of the manifold). Coordinates `left_out`
/// (ascending indices into the state, rotations and poses only as a whole) have neither a row nor a
/// reference number.
std::shared_ptr<const Residual> state_residual(const StateManifold& manifold,
                                               const std::vector<int>& left_out = {});
/// The manifold of these references.
StateManifold without_coordinates(const StateManifold& manifold, const std::vector<int>& left_out);
/// Selected coordinates of flat parts and of the positions of poses: x[i] − reference, one row per
/// index into the state. Used for joint positions and velocities. The four indices of a rotation,
/// in order, select it as a whole: three rows, log(reference⁻¹ q). Parameter: one number per index.
std::shared_ptr<const Residual> coordinate_residual(const StateManifold& manifold,
                                                    std::vector<int> state_indices);
/// u − reference. Parameter: nu numbers.
std::shared_ptr<const Residual> control_residual(int ndx, int nu);
/// (u − previous u) per step: the difference, in control units. Needs a model whose states end with
/// the previous control, preceded by `carried` free quantities. No parameters.
std::shared_ptr<const Residual> control_rate_residual(const System& system, int carried = 0);
/// A free initial state x₀ ⊕ S m, set by a knot without duration. `state` is x₀; m moves the
/// tangent coordinates `coordinates`. The states of all later nodes contain m, after `before`
/// numbers that follow the system's state.
struct ChosenStart {
  std::vector<double> state;
  std::vector<int> coordinates;
  int before = 0;
};
/// x ⊖ ((x₀ ⊕ S m) + offset), all ndx rows of the system's state: the difference from the initial
/// state. The offset is added to the numbers of the state, including positions of poses; it is zero
/// for quaternions. Tangent coordinates of flat parts that are left out have no row. `last` further
/// rows are the numbers at the end of the state minus the free initial numbers before them. Needs a
/// model whose states carry m and, with `ndx` tangent coordinates, these numbers. No parameters.
std::shared_ptr<const Residual> cycle_residual(const StateManifold& manifold,
                                               const ChosenStart& start, std::vector<double> offset,
                                               const std::vector<int>& left_out = {}, int last = 0,
                                               int ndx = 0);
/// A row of a linear combination: a constant plus factors times numbers of the state's flat parts
/// and of the control.
struct LinearCombination {
  struct Term {
    double factor;
    bool of_control;
    int index;    ///< into the state or the control
    int tangent;  ///< of the state: index into tangent vectors
  };
  std::vector<Term> terms;  ///< each coordinate at most once
  double constant = 0;
};
/// One row per combination. No parameters. ndx belongs to the knot model.
std::shared_ptr<const Residual> combination_residual(int ndx, std::vector<LinearCombination> rows);
/// Accelerations of a second-order system at selected velocity indices minus reference (parameter:
/// one number per index).
std::shared_ptr<const Residual> acceleration_residual(const System& system, int ndx,
                                                      std::vector<int> velocity_indices);
/// Residuals of a frame as seen from its base, by default the world.
/// Position of the frame's origin minus reference, m, in axes of the base. Parameter: 3 numbers.
std::shared_ptr<const Residual> frame_position_residual(
    const std::shared_ptr<const MultibodySystem>& system, const FramePair& frame);
/// log(R_refᵀ R), rad, in the frame's axes. Parameter: quaternion x y z w of the reference.
std::shared_ptr<const Residual> frame_rotation_residual(
    const std::shared_ptr<const MultibodySystem>& system, const FramePair& frame);
/// log(M_ref⁻¹ M): (m, rad). Parameter: position and quaternion, 7 numbers.
std::shared_ptr<const Residual> frame_placement_residual(
    const std::shared_ptr<const MultibodySystem>& system, const FramePair& frame);
/// Velocity (linear; angular) minus reference, m/s and rad/s, in axes of the frame, or of the base
/// (world_aligned). Parameter: 6 numbers.
std::shared_ptr<const Residual> frame_velocity_residual(
    const std::shared_ptr<const MultibodySystem>& system, const FramePair& frame, FrameAxes axes);
/// Velocity of a contact's frame relative to its base in its constrained directions (linear;
/// angular for a surface), in the contact's axes, m/s and rad/s. The system need not hold the
/// contact. No parameters.
std::shared_ptr<const Residual> contact_velocity_residual(
    const std::shared_ptr<const MultibodySystem>& system, const Contact& contact);
/// Center of mass in the world minus reference, m. Parameter: 3 numbers.
std::shared_ptr<const Residual> com_position_residual(
    const std::shared_ptr<const MultibodySystem>& system);
/// Actuated generalized forces minus gravity torques, B u − g(q), at the actuated velocity indices.
/// No parameters. nu and ndx belong to the knot model.
std::shared_ptr<const Residual> control_gravity_residual(
    const std::shared_ptr<const MultibodySystem>& system, int ndx);

/// Momentum about the center of mass, world axes (kg m/s; kg m²/s) minus reference. Parameter: 6
/// numbers.
std::shared_ptr<const Residual> centroidal_momentum_residual(
    const std::shared_ptr<const MultibodySystem>& system);

/// A sphere (from = to) or a capsule: the points within `radius` (m) of a segment in the axes of a
/// robot frame, or of the world (frame −1).
struct Capsule {
  int frame = -1;
  Vector3<double> from = Vector3<double>::zero(), to = Vector3<double>::zero();
  double radius = 0;
};
/// The points within `radius` (m) of the convex hull of vertices (at least one) in the axes of a
/// robot frame, or of the world (frame −1).
struct Polytope {
  int frame = -1;
  std::vector<Vector3<double>> vertices;
  double radius = 0;
};
/// The world points p with normal·p ≤ offset; the normal is a unit vector.
struct HalfSpace {
  Vector3<double> normal{0, 0, 1};
  double offset = 0;  ///< m
};
struct DistancePair {
  std::variant<Capsule, Polytope> first;
  std::variant<Capsule, Polytope, HalfSpace> second;
  /// A margin that the distance is only to keep, m. The value for a polytope then is smooth, and
  /// the distance keeps the margin where the value does. It is less than the distance by at most a
  /// hundredth of the smaller body's radius, by more far away. Absent: exact everywhere.
  std::optional<double> margin = {};

  /// Rows of its distance: one, but over a half-space one for each end of a capsule, `from` and
  /// `to`, or vertex of a polytope with at most kMostHeights; of others the lowest.
  int rows() const;
  static constexpr int kMostHeights = 8;
};
/// Distances between surfaces, m, negative if two shapes overlap: pair after pair. They depend only
/// on the joints between the two bodies. No parameters.
///
/// Distances of two capsules are smoothed as described at closest_points(). Distances of polytopes
/// without a margin are exact (nearest_pairs()); their derivative jumps where other faces, edges or
/// vertices become the nearest ones.
std::shared_ptr<const Residual> distance_residual(
    const std::shared_ptr<const MultibodySystem>& system, const std::vector<DistancePair>& pairs);

/// Residuals of the force of one contact of the system, given by its index in contacts(). At an
/// impulse, the force is the impulse, in Ns and Nms. ndx belongs to the knot model.

/// Force, and torque for a surface contact, on the robot in world axes minus reference. Parameter:
/// 3 numbers, 6 for a surface contact.
std::shared_ptr<const Residual> contact_force_residual(
    const std::shared_ptr<const MultibodySystem>& system, int contact, int ndx);
/// A·force of a cone in world axes (A has 3 columns), or A·wrench of a surface contact in the axes
/// of its frame (6 columns). No parameters.
std::shared_ptr<const Residual> contact_cone_residual(
    const std::shared_ptr<const MultibodySystem>& system, int contact, int ndx,
    const LinearCone& cone);
/// (√(‖f_t‖² + s²) − μ f_n, f_n) with s = kConeSmoothing, N. Smoothing makes the tip differentiable
/// and is conservative. `normal` is a unit vector in the world. No parameters.
std::shared_ptr<const Residual> friction_cone_residual(
    const std::shared_ptr<const MultibodySystem>& system, int contact, int ndx, double friction,
    const Vector3<double>& normal);
inline constexpr double kConeSmoothing = 0.01;  ///< N

}  // namespace conddp
