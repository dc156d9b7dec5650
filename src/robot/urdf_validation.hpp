#pragma once

#include <urdf_model/model.h>

#include "robot/urdf_report.hpp"

namespace conddp {

/// How far a rotational inertia about a centre of mass is from one that a body can have, relative
/// to its largest principal moment.
struct InertiaDefect {
  double negative = 0;  ///< of the smallest principal moment below zero
  double triangle = 0;  ///< of the largest principal moment above the sum of the others
};
InertiaDefect inertia_defect(const Symmetric3<double>& central);

/// Rounding in a file's digits stays below this.
inline constexpr double kInertiaTolerance = 1e-6;

/// Masses, inertias, axes and limits of every link and joint, as far as one of them alone tells.
void check_urdf_physics(const urdf::ModelInterface& tree, UrdfReport& report);

/// Names, values and payloads that were asked for.
void check_urdf_options(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report);

}  // namespace conddp
