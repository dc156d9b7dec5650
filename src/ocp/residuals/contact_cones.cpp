#include "ocp/residuals/contact_cones.hpp"

#include <numbers>
#include <stdexcept>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void check(const FrictionLimits& limits) {
  if (!(limits.friction > 0)) throw std::invalid_argument("friction must be positive");
  if (!(limits.min_normal >= 0) || !(limits.max_normal > limits.min_normal))
    throw std::invalid_argument("normal forces need 0 <= minimum < maximum");
}

LinearCone upper_bounded(int rows, int columns) {
  return {Eigen::MatrixXd::Zero(rows, columns), std::vector<double>(rows, -kInfinity),
          std::vector<double>(rows, 0.0)};
}

/// Sets a row to the normal force and its bounds.
void bound_normal_force(const FrictionLimits& limits, int row, LinearCone& cone) {
  cone.lower[row] = limits.min_normal;
  cone.upper[row] = limits.max_normal;
}

}  // namespace

Matrix3<double> rotation_to_normal(const Vector3<double>& n) {
  // Rodrigues' formula with the axis (−y, x, 0); for −z, a half turn about x.
  const double c = n.z;
  if (c < -1 + 1e-12) return {{1, 0, 0, 0, -1, 0, 0, 0, -1}};
  const double k = 1 / (1 + c);
  return {{1 - n.x * n.x * k, -n.x * n.y * k, n.x, -n.x * n.y * k, 1 - n.y * n.y * k, n.y, -n.x,
           -n.y, c}};
}

LinearCone friction_pyramid(const FrictionLimits& limits, int faces, bool inner,
                            const Vector3<double>& normal) {
  check(limits);
  if (faces < 3) throw std::invalid_argument("a pyramid has at least three faces");
  const double mu = limits.friction * (inner ? std::cos(std::numbers::pi / faces) : 1);
  const Matrix3<double> R = rotation_to_normal(normal);
  LinearCone cone = upper_bounded(faces + 1, 3);
  for (int i = 0; i < faces; ++i) {
    const double angle = 2 * std::numbers::pi * i / faces;
    const Vector3<double> row = R * Vector3<double>{std::cos(angle), std::sin(angle), -mu};
    cone.A.row(i) << row.x, row.y, row.z;
  }
  cone.A.row(faces) << normal.x, normal.y, normal.z;
  bound_normal_force(limits, faces, cone);
  return cone;
}

LinearCone center_of_pressure_cone(double half_x, double half_y) {
  LinearCone cone = upper_bounded(4, 6);
  cone.A.row(0) << 0, 0, -half_y, 1, 0, 0;
  cone.A.row(1) << 0, 0, -half_y, -1, 0, 0;
  cone.A.row(2) << 0, 0, -half_x, 0, 1, 0;
  cone.A.row(3) << 0, 0, -half_x, 0, -1, 0;
  return cone;
}

LinearCone wrench_cone(const FrictionLimits& limits, double half_x, double half_y, bool inner) {
  check(limits);
  const double mu = limits.friction * (inner ? std::numbers::sqrt2 / 2 : 1);
  LinearCone cone = upper_bounded(17, 6);
  int row = 0;
  for (const double sign : {1.0, -1.0}) {
    cone.A.row(row++) << sign, 0, -mu, 0, 0, 0;
    cone.A.row(row++) << 0, sign, -mu, 0, 0, 0;
  }
  cone.A.middleRows(row, 4) = center_of_pressure_cone(half_x, half_y).A;
  row += 4;
  // τ_min ≤ τ_z ≤ τ_max: each of the two sums of absolute values gives four inequalities.
  for (const double side : {1.0, -1.0})
    for (const double a : {1.0, -1.0})
      for (const double b : {1.0, -1.0})
        cone.A.row(row++) << a * half_y, b * half_x, -mu * (half_x + half_y), side * a * mu,
            side * b * mu, side;
  cone.A(row, 2) = 1;
  bound_normal_force(limits, row, cone);
  return cone;
}

}  // namespace conddp
