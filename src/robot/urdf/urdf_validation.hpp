#pragma once

#include <urdf_model/model.h>

#include "robot/urdf/urdf_report.hpp"

namespace conddp {

/// How far a rotational inertia about a centre of mass is from one that a body of this mass (kg)
/// can have, relative to its largest principal moment. What is left of zeros by rounding, a radius
/// of gyration below 1 µm, is a point mass without a defect.
struct InertiaDefect {
  double negative = 0;  ///< of the smallest principal moment below zero
  double triangle = 0;  ///< of the largest principal moment above the sum of the others
};
InertiaDefect inertia_defect(const Symmetric3<double>& central, double mass);

/// Rounding in a file's digits stays below this.
inline constexpr double kInertiaTolerance = 1e-6;

/// The options with joints in place of names with `*`, which stands for any letters: those of one
/// axis that fit, an exact name before a pattern, a longer pattern before a shorter one. Mimic
/// joints that follow their leader are locked with it, not by a pattern; joints that are locked get
/// no rotor by one. A pattern that fits no joint is an error.
UrdfOptions resolve_joint_patterns(const urdf::ModelInterface& tree, UrdfOptions options,
                                   UrdfReport& report);

/// Masses, axes and limits of every link and joint, as far as one of them alone tells.
/// Joints that are locked are not warned of limits that keep them from moving.
void check_urdf_physics(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report);

/// Names, values and payloads that were asked for.
void check_urdf_options(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report);

}  // namespace conddp
