#pragma once

#include "spatial/vector3.hpp"

namespace conddp {

/// A rotation that takes +z to the axis (of any length but zero). For an axis along ±x, ±y or ±z
/// its elements are exactly 0 and ±1.
Matrix3<double> rotation_from_z(const Vector3<double>& axis);

/// The rotation by an angle (rad) about a unit axis.
Matrix3<double> rotation_about(const Vector3<double>& axis, double angle);

}  // namespace conddp
