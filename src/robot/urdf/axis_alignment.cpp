#include "robot/urdf/axis_alignment.hpp"

#include <cmath>

namespace conddp {
namespace {

/// Rotations from z to −x and x, −y and y, −z and z. Signed cyclic permutations, the identity and
/// half a turn are exact: no rounding enters.
constexpr Matrix3<double> kTurnsToAxis[3][2] = {
    {{{0, 0, -1, 1, 0, 0, 0, -1, 0}}, {{0, 0, 1, 1, 0, 0, 0, 1, 0}}},
    {{{0, -1, 0, 0, 0, -1, 1, 0, 0}}, {{0, 1, 0, 0, 0, 1, 1, 0, 0}}},
    {{{1, 0, 0, 0, -1, 0, 0, 0, -1}}, {{1, 0, 0, 0, 1, 0, 0, 0, 1}}}};

}  // namespace

Matrix3<double> rotation_from_z(const Vector3<double>& axis) {
  const double norm = std::sqrt(squared_norm(axis));
  const Vector3<double> z{axis.x / norm, axis.y / norm, axis.z / norm};
  const double parts[] = {z.x, z.y, z.z};
  for (int i = 0; i < 3; ++i)
    if (parts[(i + 1) % 3] == 0 && parts[(i + 2) % 3] == 0) return kTurnsToAxis[i][parts[i] > 0];
  // Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017.
  const double sign = std::copysign(1.0, z.z);
  const double a = -1 / (sign + z.z);
  const double b = z.x * z.y * a;
  return {{1 + sign * z.x * z.x * a, b, z.x, sign * b, sign + z.y * z.y * a, z.y, -sign * z.x, -z.y,
           z.z}};
}

Matrix3<double> rotation_about(const Vector3<double>& axis, double angle) {
  const Matrix3<double> k = skew(axis);
  const double half = std::sin(0.5 * angle);
  return Matrix3<double>::identity() + std::sin(angle) * k + (2 * half * half) * (k * k);
}

}  // namespace conddp
