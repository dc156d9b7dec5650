#pragma once

#include <vector>

#include <Eigen/Core>

#include "spatial/vector3.hpp"

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

}  // namespace conddp
