#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Where a base that moves evenly with `step` in its own axes (m, m, rad a unit of time) is after
/// `time`: on an arc of a circle where it turns.
PlanarMotion along_arc(const PlanarMotion& step, double time);

/// The one motion and then the other, as seen from where the first one ends.
PlanarMotion followed_by(const PlanarMotion& first, const PlanarMotion& then);

/// Displaces the floating or planar base of a robot in a state; false if its base is fixed. The
/// velocity stays the same as seen from the base.
bool displace_base(const Plant& plant, const PlantPart& part, const PlanarMotion& motion,
                   std::vector<double>& x);

/// Displaces the base of a robot in a state, at its height, to where it stands in another one, and
/// turns it to the heading there; nothing if its base is fixed. A planar base whose plane is not
/// level keeps its pitch.
void bring_base(const Plant& plant, const PlantPart& part, const std::vector<double>& to,
                std::vector<double>& x);

/// Where a point of the world comes to that moves with the base of a robot in a state, as
/// displace_base moves it; nullopt if its base is fixed.
std::optional<Vector3<double>> displaced_point(const Plant& plant, const PlantPart& part,
                                               const PlanarMotion& motion,
                                               const std::vector<double>& x,
                                               const Vector3<double>& point);

}  // namespace conddp
