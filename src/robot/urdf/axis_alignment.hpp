#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

/// Rotation that takes +z to an axis of any nonzero length. For an axis along ±x, ±y or ±z its
/// elements are exactly 0 and ±1.
Matrix3<double> rotation_from_z(const Vector3<double>& axis);

/// Rotation by an angle (rad) about a unit axis.
Matrix3<double> rotation_about(const Vector3<double>& axis, double angle);

}  // namespace conddp
