#pragma once

#include <vector>

#include <Eigen/Core>

#include "spatial/vector3.hpp"

namespace conddp {

/// Linear inequalities lower ≤ A f ≤ upper on a contact's force (3 columns) or wrench (6 columns:
/// force; torque).
struct LinearCone {
  Eigen::MatrixXd A;
  std::vector<double> lower, upper;  ///< −∞ and +∞ where there is none
};

/// What limits the force of one contact.
struct FrictionLimits {
  double friction = 0.7;  ///< coefficient μ, a safety factor included
  double min_normal = 0;  ///< N
  double max_normal = std::numeric_limits<double>::infinity();  ///< N
};

/// Friction cone ‖f_t‖ ≤ μ f_n as a pyramid of `faces` ≥ 3, about a unit normal in the axes of f.
/// Outer pyramids contain the cone and touch it, inner ones stand in it. The last row is f_n. The
/// faces turn with the normal by the smallest rotation from +z. Throws std::invalid_argument where
/// faces < 3, μ ≤ 0 or the limits contradict each other.
LinearCone friction_pyramid(const FrictionLimits& limits, int faces, bool inner,
                            const Vector3<double>& normal);

/// Centre of pressure inside the rectangle |x| ≤ half_x, |y| ≤ half_y (m) of a sole with normal +z:
/// |τ_x| ≤ half_y f_z, |τ_y| ≤ half_x f_z. Four rows.
LinearCone center_of_pressure_cone(double half_x, double half_y);

/// Contact wrench cone of a rectangular sole with normal +z (Caron, Pham, Nakamura 2015, eq. 26 to
/// 29): four-sided friction, unilateral normal force, centre of pressure, yaw torque. 17 rows, the
/// last one f_z. Inner: μ / √2, so that the friction pyramid stands in the cone.
LinearCone wrench_cone(const FrictionLimits& limits, double half_x, double half_y, bool inner);

/// The rotation that takes +z to a unit vector, about their common normal.
Matrix3<double> rotation_to_normal(const Vector3<double>& normal);

}  // namespace conddp
