#include "robot/urdf/urdf_validation.hpp"

#include <cmath>
#include <map>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "base/text/spelling.hpp"

namespace conddp {
namespace {

/// Type of a joint as the file names it.
std::string type_of(const std::string& joint, const UrdfReport& report) {
  return report.joint(joint).node.attribute("type").value();
}

bool moves_along_one_axis(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS ||
         joint.type == urdf::Joint::PRISMATIC;
}

bool has_rotational_inertia(const urdf::Inertial& body) {
  return body.ixx != 0 || body.iyy != 0 || body.izz != 0;
}

void check_link(const urdf::Link& link, UrdfReport& report) {
  if (!link.inertial) return;
  const urdf::Inertial& body = *link.inertial;
  if (body.mass < 0)
    report.error(report.link(link.name, "inertial"), fmt::format("its mass is {} kg", body.mass),
                 "a mass cannot be negative");
  if (body.mass == 0 && has_rotational_inertia(body))
    report.warning(report.link(link.name, "inertial"), "it has rotational inertia but no mass");
}

void check_axis(const urdf::Joint& joint, UrdfReport& report) {
  if (!moves_along_one_axis(joint) && joint.type != urdf::Joint::PLANAR) return;
  const double norm = std::hypot(joint.axis.x, joint.axis.y, joint.axis.z);
  if (!(norm > 1e-12) || !std::isfinite(norm))
    report.error(report.joint(joint.name, "axis"), "its axis is zero",
                 "write e.g. <axis xyz=\"0 0 1\"/>");
  else if (std::abs(norm - 1) > 1e-3)
    report.warning(report.joint(joint.name, "axis"),
                   fmt::format("its axis has length {:.6g} and is normalized", norm));
}

/// Locked joints get errors but no warnings.
void check_limits(const urdf::Joint& joint, bool locked, UrdfReport& report) {
  if (!joint.limits || !moves_along_one_axis(joint)) return;
  const urdf::JointLimits& limits = *joint.limits;
  const auto error = [&](const std::string& message, const char* hint = "") {
    report.error(report.joint(joint.name, "limit"), message, hint);
  };
  const auto warning = [&](const std::string& message, const char* hint = "") {
    if (!locked) report.warning(report.joint(joint.name, "limit"), message, hint);
  };
  if (limits.effort < 0)
    error(fmt::format("its effort limit is {} {}", limits.effort,
                      joint.type == urdf::Joint::PRISMATIC ? "N" : "Nm"),
          "an effort limit cannot be negative");
  if (limits.effort == 0)
    warning("its effort limit is 0: it cannot be actuated within the URDF's limits");
  if (limits.velocity < 0)
    error(fmt::format("its velocity limit is {}", limits.velocity),
          "a velocity limit cannot be negative");
  if (limits.velocity == 0)
    warning("its velocity limit is 0: it cannot move within the URDF's limits");
  if (joint.type == urdf::Joint::CONTINUOUS) return;
  if (limits.lower > limits.upper)
    error(fmt::format("its lower limit {} is above the upper {}", limits.lower, limits.upper));
  if (limits.lower == limits.upper)
    warning(fmt::format("its lower and upper limits are both {}: it cannot move within the URDF's "
                        "limits",
                        limits.lower),
            "if this is intended, make it fixed or lock it; an absent limit reads as 0");
}

void check_mimic(const urdf::Joint& joint, UrdfReport& report) {
  if (joint.mimic && (joint.type == urdf::Joint::FLOATING || joint.type == urdf::Joint::PLANAR))
    report.error(report.joint(joint.name, "mimic"),
                 fmt::format("a {} joint cannot mimic another one", type_of(joint.name, report)),
                 "revolute, continuous and prismatic joints can");
}

void check_joint(const urdf::Joint& joint, bool locked, UrdfReport& report) {
  check_axis(joint, report);
  check_limits(joint, locked, report);
  if (joint.dynamics && (joint.dynamics->damping < 0 || joint.dynamics->friction < 0))
    report.error(report.joint(joint.name, "dynamics"), "its damping or friction is negative");
  check_mimic(joint, report);
}

std::vector<std::string> moving_joints(const urdf::ModelInterface& tree) {
  std::vector<std::string> names;
  for (const auto& [name, joint] : tree.joints_)
    if (moves_along_one_axis(*joint)) names.push_back(name);
  return names;
}

/// The joint if it exists and has one axis, else null and an error that states the purpose.
const urdf::Joint* moving_joint(const urdf::ModelInterface& tree, const std::string& name,
                                const std::string& purpose, UrdfReport& report) {
  const auto found = tree.joints_.find(name);
  const bool exists = found != tree.joints_.end();
  if (exists && moves_along_one_axis(*found->second)) return found->second.get();
  report.error(report.joint(name),
               exists ? fmt::format("a {} joint is not one {}", type_of(name, report), purpose)
                      : "there is no such joint " + purpose,
               name_hint(name, moving_joints(tree), "joints"));
  return nullptr;
}

void check_locked(const urdf::Joint& joint, double value, UrdfReport& report) {
  if (!std::isfinite(value))
    return report.error(report.joint(joint.name), "the value to lock it at is not finite");
  if (!joint.limits || joint.type == urdf::Joint::CONTINUOUS) return;
  if (value >= joint.limits->lower && value <= joint.limits->upper) return;
  report.error(report.joint(joint.name, "limit"),
               fmt::format("it is to be locked at {}, outside its limits {} to {}", value,
                           joint.limits->lower, joint.limits->upper));
}

void check_rotor(const std::string& joint, double inertia, bool locked, UrdfReport& report) {
  if (!std::isfinite(inertia) || inertia < 0)
    report.error(report.joint(joint),
                 fmt::format("its rotor inertia {} is not a finite number of at "
                             "least 0",
                             inertia));
  else if (locked)
    report.warning(report.joint(joint), "its rotor inertia has no effect: the joint is locked");
}

/// Defect of a payload's inertia; empty if it is valid.
std::string payload_inertia_defect(const Symmetric3<double>& j, double mass) {
  if (!std::isfinite(j.xx + j.xy + j.xz + j.yy + j.yz + j.zz)) return "inertia is not finite";
  const InertiaDefect defect = inertia_defect(j, mass);
  if (defect.negative <= kInertiaTolerance && defect.triangle <= kInertiaTolerance) return {};
  return "inertia is not physically valid: principal moments are positive and none exceeds the sum "
         "of the others";
}

void check_payload_numbers(const UrdfOptions::Payload& payload, UrdfReport& report) {
  const auto fail = [&](const std::string& message) {
    report.error(report.link(payload.link), "its payload's " + message);
  };
  if (!std::isfinite(payload.mass) || payload.mass < 0)
    fail(fmt::format("mass {} kg is not a finite number of at least 0", payload.mass));
  if (!std::isfinite(squared_norm(payload.com))) fail("center of mass is not finite");
  if (!payload.inertia) return;
  const std::string defect = payload_inertia_defect(*payload.inertia, payload.mass);
  if (!defect.empty()) fail(defect);
}

void check_payload(const urdf::ModelInterface& tree, const UrdfOptions::Payload& payload,
                   UrdfReport& report) {
  if (tree.links_.contains(payload.link)) return check_payload_numbers(payload, report);
  std::vector<std::string> names;
  for (const auto& [name, link] : tree.links_) names.push_back(name);
  report.error(report.link(payload.link), "there is no such link to carry a payload",
               name_hint(payload.link, names, "links"));
}

/// Checks the joints to be locked and the joints with rotor inertias.
void check_joint_options(const urdf::ModelInterface& tree, const UrdfOptions& options,
                         UrdfReport& report) {
  for (const auto& [name, value] : options.locked_joints)
    if (const urdf::Joint* joint = moving_joint(tree, name, "that can be locked", report))
      check_locked(*joint, value, report);
  for (const auto& [name, inertia] : options.rotor_inertia)
    if (moving_joint(tree, name, "that can have a rotor inertia", report))
      check_rotor(name, inertia, options.locked_joints.contains(name), report);
}

/// One number per joint from numbers by name or pattern. `may_have`: true if patterns apply to the
/// joint.
template <class MayHave>
std::map<std::string, double> resolve_patterns(const urdf::ModelInterface& tree,
                                               const std::map<std::string, double>& given,
                                               MayHave may_have, UrdfReport& report) {
  std::map<std::string, double> resolved;
  for (const auto& [name, value] : given)
    if (!is_pattern(name)) resolved.emplace(name, value);
  const std::vector<std::string> joints = moving_joints(tree);
  std::map<std::string, std::size_t> quality;
  for (const auto& [pattern, value] : given) {
    if (!is_pattern(pattern)) continue;
    bool any = false;
    for (const std::string& joint : joints) {
      const std::size_t found = fit(pattern, joint);
      any = any || found > 0;
      if (found <= quality[joint] || given.contains(joint) || !may_have(joint)) continue;
      quality[joint] = found;
      resolved[joint] = value;
    }
    if (!any)
      report.error(report.joint(pattern), "fits none of the joints that move",
                   name_hint(pattern, joints, "joints"));
  }
  return resolved;
}

}  // namespace

InertiaDefect inertia_defect(const Symmetric3<double>& central, double mass) {
  Eigen::Matrix3d j;
  j << central.xx, central.xy, central.xz, central.xy, central.yy, central.yz, central.xz,
      central.yz, central.zz;
  const Eigen::Vector3d moments =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(j, Eigen::EigenvaluesOnly).eigenvalues();
  const double largest = moments.cwiseAbs().maxCoeff();
  constexpr double kSquaredRadius = 1e-12;  // m²
  if (largest <= kSquaredRadius * mass) return {};
  return {std::max(0.0, -moments[0] / largest),
          std::max(0.0, (moments[2] - moments[1] - moments[0]) / largest)};
}

UrdfOptions resolve_joint_patterns(const urdf::ModelInterface& tree, UrdfOptions options,
                                   UrdfReport& report) {
  const auto follows = [&](const std::string& joint) {
    return options.enforce_mimic && tree.joints_.at(joint)->mimic != nullptr;
  };
  options.locked_joints = resolve_patterns(
      tree, options.locked_joints, [&](const std::string& joint) { return !follows(joint); },
      report);
  options.rotor_inertia = resolve_patterns(
      tree, options.rotor_inertia,
      [&](const std::string& joint) { return !options.locked_joints.contains(joint); }, report);
  return options;
}

void check_urdf_physics(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report) {
  for (const auto& [name, link] : tree.links_) check_link(*link, report);
  for (const auto& [name, joint] : tree.joints_)
    check_joint(*joint, options.locked_joints.contains(name), report);
}

void check_urdf_options(const urdf::ModelInterface& tree, const UrdfOptions& options,
                        UrdfReport& report) {
  check_joint_options(tree, options, report);
  for (const UrdfOptions::Payload& payload : options.payloads) check_payload(tree, payload, report);
  if (!std::isfinite(squared_norm(options.gravity))) report.error({}, "gravity is not finite");
  if (options.placement && options.base == UrdfOptions::Base::floating)
    report.warning({}, "the robot's placement has no effect: its base floats",
                   "the initial state sets its position");
}

}  // namespace conddp
