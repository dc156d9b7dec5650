#pragma once

#include <urdf_model/model.h>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// Distance of a rotational inertia about the center of mass from a physically valid one for this
/// mass (kg), relative to its largest principal moment. An inertia with a radius of gyration below
/// 1 µm comes from rounded zeros and counts as a point mass without a defect.
struct InertiaDefect {
  double negative = 0;  ///< amount of the smallest principal moment below zero
  double triangle = 0;  ///< excess of the largest principal moment over the sum of the others
};
InertiaDefect inertia_defect(const Symmetric3<double>& central, double mass);

/// Tolerance for a defect: rounded digits in a file cause less.
inline constexpr double kInertiaTolerance = 1e-6;

/// Options with patterns replaced by the one-axis joints that they match; `*` matches any letters.
/// An exact name overrides a pattern, and a longer pattern a shorter one. Patterns do not lock
/// mimic joints that follow their leader (they are locked with it) and do not give rotors to locked
/// joints. A pattern that matches no joint is an error.
UrdfOptions resolve_joint_patterns(const urdf::ModelInterface& tree, UrdfOptions options,
                                   UrdfReport& report);

/// Checks masses, axes and limits of every link and joint separately. Limits that keep a joint from
/// moving cause no warning if the joint is locked.
void check_urdf_physics(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report);

/// Checks the names, values and payloads in the options.
void check_urdf_options(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report);

}  // namespace conddp
