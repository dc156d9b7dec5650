#pragma once

#include "base/json/ordered_json.hpp"
#include "spatial/se3.hpp"

namespace conddp {

/// Coordinates of a scene in lists of numbers, rounded to a micrometer; null if not finite.
void append(OrderedJson& list, const Vector3<double>& v);
/// Position, followed by the quaternion x y z w.
void append(OrderedJson& list, const SE3<double>& placement);
OrderedJson vector_json(const Vector3<double>& v);
OrderedJson placement_json(const SE3<double>& placement);

}  // namespace conddp
