#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// The motion after `time` of a base that moves uniformly with `step` in its own axes (m, m, rad
/// per unit of time). A turning base follows an arc of a circle.
PlanarMotion along_arc(const PlanarMotion& step, double time);

/// Composition: the first motion, then the second relative to the end of the first.
PlanarMotion followed_by(const PlanarMotion& first, const PlanarMotion& then);

/// Displaces the floating or planar base of a robot in a state; false if its base is fixed. The
/// velocity in base axes is unchanged.
bool displace_base(const Plant& plant, const PlantPart& part, const PlanarMotion& motion,
                   std::vector<double>& x);

/// Moves the base of a robot in a state to its position in another state, at its own height, and
/// turns it to the heading there. No effect on a fixed base. A planar base in a plane that is not
/// level keeps its pitch.
void bring_base(const Plant& plant, const PlantPart& part, const std::vector<double>& to,
                std::vector<double>& x);

/// New position of a world point that moves with the base of a robot in a state, as displace_base
/// moves it; nullopt if its base is fixed.
std::optional<Vector3<double>> displaced_point(const Plant& plant, const PlantPart& part,
                                               const PlanarMotion& motion,
                                               const std::vector<double>& x,
                                               const Vector3<double>& point);

}  // namespace conddp
