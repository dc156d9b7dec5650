#include "robot/urdf/model_builder.hpp"

#include <cmath>
#include <unordered_map>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "robot/urdf/axis_alignment.hpp"
#include "robot/urdf/urdf_validation.hpp"

namespace conddp {
namespace {

using Base = UrdfOptions::Base;

Vector3<double> vector(const urdf::Vector3& a) { return {a.x, a.y, a.z}; }

SE3<double> pose(const urdf::Pose& a) {
  const urdf::Rotation& r = a.rotation;
  return {rotation_matrix(Quaternion<double>{r.x, r.y, r.z, r.w}), vector(a.position)};
}

SE3<double> rotation(const Matrix3<double>& r) { return {r, Vector3<double>::zero()}; }

Symmetric3<double> central_inertia(const urdf::Inertial& body) {
  return rotate(pose(body.origin).R,
                Symmetric3<double>{body.ixx, body.ixy, body.ixz, body.iyy, body.iyz, body.izz});
}

bool same_placement(const SE3<double>& a, const SE3<double>& b) {
  for (int i = 0; i < 9; ++i)
    if (a.R.m[i] != b.R.m[i]) return false;
  return squared_norm(a.p - b.p) == 0;
}

class Builder {
 public:
  Builder(const urdf::ModelInterface& tree, const UrdfOptions& options, UrdfReport& report)
      : tree_(tree), options_(options), report_(report) {}

  RobotModel build() {
    model_.name = tree_.getName();
    model_.gravity = options_.gravity;
    place_root();
    // Depth first; urdfdom sorts a link's child joints by name.
    std::vector<const urdf::Link*> open{tree_.getRoot().get()};
    while (!open.empty()) {
      const urdf::Link* link = open.back();
      open.pop_back();
      visit(*link);
      for (auto child = link->child_links.rbegin(); child != link->child_links.rend(); ++child)
        open.push_back(child->get());
    }
    add_payloads();
    check_own_base();
    check_inertias();
    if (options_.enforce_mimic) enforce_mimics();
    write_notes();
    prefix_names();
    model_.finalize();
    return std::move(model_);
  }

 private:
  /// Joint that carries a link (−1: the world) and the link's placement in that joint's frame.
  struct Carrier {
    int joint = -1;
    SE3<double> placement = SE3<double>::identity();
  };

  const Carrier& carrier(const std::string& link) const { return carriers_.at(link); }

  bool locked(const urdf::Joint& joint) const {
    return options_.locked_joints.contains(joint.name);
  }

  std::string free_name(std::string name) const {
    while (tree_.joints_.contains(name)) name += "_";
    return name;
  }

  /// The file's floating or planar joint that serves as the requested base, or null.
  const urdf::Joint* own_base() const {
    if (options_.base == Base::fixed) return nullptr;
    const int wanted =
        options_.base == Base::floating ? urdf::Joint::FLOATING : urdf::Joint::PLANAR;
    for (const auto& [name, joint] : tree_.joints_)
      if (joint->type == wanted) return joint.get();
    return nullptr;
  }

  void place_root() {
    Carrier root;
    if (options_.base != Base::floating && options_.placement) root.placement = *options_.placement;
    own_base_ = own_base();
    if (options_.base == Base::floating && !own_base_) {
      root.joint = add_joint(free_name("base"), JointType::floating, -1, SE3<double>::identity());
      add_frame(model_.joints[root.joint].name, FrameKind::joint, root);
    } else if (options_.base == Base::planar && !own_base_) {
      root = add_planar(free_name("base"), root, {0, 0, 1});
    }
    carriers_[tree_.getRoot()->name] = root;
  }

  void visit(const urdf::Link& link) {
    if (link.parent_joint) {
      carriers_[link.name] = place(*link.parent_joint);
      add_frame(link.parent_joint->name, FrameKind::joint, carrier(link.name));
    }
    add_frame(link.name, FrameKind::link, carrier(link.name));
    if (!link.inertial) return;
    const urdf::Inertial& body = *link.inertial;
    model_.frames.back().mass = body.mass;
    carry(link.name,
          inertia_about_origin(body.mass, vector(body.origin.position), central_inertia(body)));
  }

  void carry(const std::string& link, const Inertia<double>& inertia) {
    const Carrier& by = carrier(link);
    (by.joint < 0 ? world_ : model_.joints[by.joint].inertia) += act(by.placement, inertia);
  }

  Carrier place(const urdf::Joint& joint) {
    const Carrier& parent = carrier(joint.parent_link_name);
    const Carrier at{parent.joint, parent.placement * pose(joint.parent_to_joint_origin_transform)};
    switch (joint.type) {
      case urdf::Joint::FLOATING:
        return place_floating(joint, at);
      case urdf::Joint::PLANAR:
        if (!stands_on_world(joint, at)) return at;
        return add_planar(joint.name, at, vector(joint.axis));
      case urdf::Joint::REVOLUTE:
      case urdf::Joint::CONTINUOUS:
      case urdf::Joint::PRISMATIC:
        return place_moving(joint, at);
      default:
        return at;
    }
  }

  Carrier place_moving(const urdf::Joint& joint, const Carrier& at) {
    const bool slides = joint.type == urdf::Joint::PRISMATIC;
    const Matrix3<double> align = rotation_from_z(vector(joint.axis));
    if (locked(joint)) return place_locked(joint, at, align.column(2));
    const Carrier moved =
        add_along(joint.name, slides ? JointType::prismatic : JointType::revolute, at, align);
    Joint& added = model_.joints[moved.joint];
    copy_limits(joint, added);
    if (joint.dynamics) {
      added.damping = joint.dynamics->damping;
      added.friction = joint.dynamics->friction;
    }
    if (const auto rotor = options_.rotor_inertia.find(joint.name);
        rotor != options_.rotor_inertia.end())
      added.rotor_inertia = rotor->second;
    return moved;
  }

  /// Carrier of a joint locked at a position along or about `axis`.
  Carrier place_locked(const urdf::Joint& joint, const Carrier& at, const Vector3<double>& axis) {
    const double value = options_.locked_joints.at(joint.name);
    const SE3<double> moved = joint.type == urdf::Joint::PRISMATIC
                                  ? SE3<double>{Matrix3<double>::identity(), value * axis}
                                  : rotation(rotation_about(axis, value));
    return {at.joint, at.placement * moved};
  }

  static void copy_limits(const urdf::Joint& joint, Joint& added) {
    if (!joint.limits) return;
    added.max_effort = joint.limits->effort;
    added.max_velocity = joint.limits->velocity;
    if (joint.type == urdf::Joint::CONTINUOUS) return;
    added.lower = joint.limits->lower;
    added.upper = joint.limits->upper;
  }

  bool stands_on_world(const urdf::Joint& joint, const Carrier& at) {
    if (at.joint < 0) return true;
    const std::string kind = joint.type == urdf::Joint::FLOATING ? "floating" : "planar";
    report_.error(report_.joint(joint.name),
                  "a " + kind + " joint is supported only if its parent is the root link, or " +
                      "fixed to it, and the base is fixed; here the parent moves with joint '" +
                      model_.joints[at.joint].name + "'");
    return false;
  }

  Carrier place_floating(const urdf::Joint& joint, const Carrier& at) {
    if (!stands_on_world(joint, at)) return at;
    if (!same_placement(at.placement, SE3<double>::identity()))
      report_.note(
          "joint '" + joint.name +
          "' floats: its configuration is relative to the world's origin, not to the joint's own");
    return {add_joint(joint.name, JointType::floating, -1, SE3<double>::identity()),
            SE3<double>::identity()};
  }

  Carrier add_planar(const std::string& name, Carrier at, const Vector3<double>& normal) {
    const Matrix3<double> plane = rotation_from_z(normal);
    at.placement = at.placement * rotation(plane);
    const auto add = [&](const char* suffix, JointType type, const Vector3<double>& axis) {
      at = add_along(free_name(name + suffix), type, at, rotation_from_z(axis));
      add_frame(model_.joints[at.joint].name, FrameKind::joint, at);
    };
    add("_x", JointType::prismatic, {1, 0, 0});
    add("_y", JointType::prismatic, {0, 1, 0});
    add("_yaw", JointType::revolute, {0, 0, 1});
    at.placement = at.placement * rotation(transpose(plane));
    return at;
  }

  /// Adds a one-axis joint at `at`; `align` rotates z to the joint's axis.
  Carrier add_along(const std::string& name, JointType type, const Carrier& at,
                    const Matrix3<double>& align) {
    return {add_joint(name, type, at.joint, at.placement * rotation(align)),
            rotation(transpose(align))};
  }

  int add_joint(const std::string& name, JointType type, int parent, const SE3<double>& placement) {
    Joint joint;
    joint.name = name;
    joint.type = type;
    joint.parent = parent;
    joint.placement = placement;
    model_.joints.push_back(std::move(joint));
    return model_.joint_count() - 1;
  }

  void add_frame(const std::string& name, FrameKind kind, const Carrier& at) {
    model_.frames.push_back({name, kind, at.joint, at.placement});
  }

  void add_payloads() {
    for (const UrdfOptions::Payload& payload : options_.payloads) {
      carry(payload.link,
            inertia_about_origin(payload.mass, payload.com,
                                 payload.inertia.value_or(Symmetric3<double>::zero())));
      if (carrier(payload.link).joint < 0)
        report_.note("the payload on link '" + payload.link +
                     "' has no effect: the link does not move");
    }
  }

  /// The file's own base joint replaces the requested one. Mass that remains rigid with the world
  /// is then an error.
  void check_own_base() {
    if (!own_base_) return;
    const std::string kind = options_.base == Base::floating ? "floating" : "planar";
    if (world_.mass > 0)
      report_.error(
          report_.joint(own_base_->name),
          "the file has a " + kind + " joint of its own besides the requested " + kind + " base",
          "set the base to fixed");
    else
      report_.note("the " + kind + " joint '" + own_base_->name +
                   "' of the file is the requested base; no other one is added");
  }

  /// Vendors' files contain inertias that are not physically valid: placeholders, rounded digits,
  /// products of inertia with the wrong sign. `joints_with_negative_inertia` checks their effect on
  /// the whole robot after all inertias are added.
  void check_inertias() {
    for (const Joint& joint : model_.joints)
      if (!std::isfinite(joint.inertia.mass + squared_norm(joint.inertia.moment) +
                         joint.inertia.rotational.xx + joint.inertia.rotational.yy +
                         joint.inertia.rotational.zz))
        report_.error(report_.joint(joint.name), "the inertia that it moves overflows");
    for (const auto& [name, link] : tree_.links_)
      if (const auto& body = link->inertial)
        check_inertia(name, inertia_defect(central_inertia(*body), body->mass));
  }

  void check_inertia(const std::string& link, const InertiaDefect& defect) {
    std::string message, hint;
    if (defect.negative > kInertiaTolerance) {
      message = fmt::format(
          "its inertia is not positive semidefinite: a principal moment is negative by {:.3g} % of "
          "the largest",
          100 * defect.negative);
      hint = "check signs and units (kg m²)";
    } else if (defect.triangle > kInertiaTolerance) {
      message = fmt::format(
          "its inertia is not physically valid: the largest principal moment exceeds the sum of "
          "the others by {:.3g} %",
          100 * defect.triangle);
      hint = "check the units and that it is taken about the center of mass";
    } else {
      return;
    }
    const UrdfPlace place = report_.link(link, "inertial");
    if (options_.inertias == UrdfOptions::Inertias::strict)
      report_.error(place, message, hint + "; 'inertias: as_given' accepts it as it is");
    else
      report_.warning(place, message + "; it is used as given");
  }

  /// The file's joint of this name if it mimics another one, else null.
  const urdf::Joint* find_mimic(const std::string& joint) const {
    const auto found = tree_.joints_.find(joint);
    return found != tree_.joints_.end() && found->second->mimic ? found->second.get() : nullptr;
  }

  /// Independent joint at the end of a follower's chain of leaders. `mimic` receives the composed
  /// multiplier and offset. Earlier checks exclude cycles, and followers of locked joints are
  /// locked.
  const urdf::Joint& find_leader(const urdf::Joint& follower, Mimic& mimic) const {
    const urdf::Joint* leader = &follower;
    while (leader->mimic) {
      mimic.offset += mimic.multiplier * leader->mimic->offset;
      mimic.multiplier *= leader->mimic->multiplier;
      leader = tree_.joints_.at(leader->mimic->joint_name).get();
    }
    return *leader;
  }

  void enforce_mimics() {
    for (int i = 0; i < model_.joint_count(); ++i) {
      const urdf::Joint* follower = find_mimic(model_.joints[i].name);
      if (!follower) continue;
      Mimic mimic{.joint = i, .leader = -1, .multiplier = 1, .offset = 0};
      const urdf::Joint& leader = find_leader(*follower, mimic);
      const auto index = model_.find_joint(leader.name);
      if (!index || model_.joints[*index].type == JointType::floating) {
        report_.error(report_.joint(model_.joints[i].name, "mimic"),
                      "it mimics joint '" + leader.name + "', which has no coordinate",
                      fmt::format("lock it, at {}", mimic.offset));
        continue;
      }
      mimic.leader = *index;
      model_.mimics.push_back(mimic);
    }
  }

  /// Adds a note that lists all joints satisfying the predicate, if any.
  template <class Predicate>
  void note_joints(const std::string& text, Predicate is_noted) {
    std::vector<std::string> names;
    for (const Joint& joint : model_.joints)
      if (is_noted(joint)) names.push_back(joint.name);
    if (!names.empty()) report_.note(text + ": " + listed(names));
  }

  void write_notes() {
    note_joints("joint damping is ignored unless the problem asks for it",
                [](const Joint& joint) { return joint.damping != 0; });
    note_joints("joint friction is ignored unless the problem asks for it",
                [](const Joint& joint) { return joint.friction != 0; });
    note_joints("mimic joints are independent unless the problem enforces them",
                [this](const Joint& joint) {
                  return !options_.enforce_mimic && find_mimic(joint.name) != nullptr;
                });
    if (world_.mass > 0)
      report_.note(fmt::format("{:.6g} kg rigid with the world have no effect", world_.mass));
    if (model_.joints.empty())
      report_.warning({}, "no joint of the robot moves",
                      "if it is a free body, set the base to floating");
  }

  void prefix_names() {
    for (Joint& joint : model_.joints) joint.name = options_.prefix + joint.name;
    for (Frame& frame : model_.frames) frame.name = options_.prefix + frame.name;
  }

  const urdf::ModelInterface& tree_;
  const UrdfOptions& options_;
  UrdfReport& report_;
  RobotModel model_;
  const urdf::Joint* own_base_ = nullptr;
  std::unordered_map<std::string, Carrier> carriers_;
  Inertia<double> world_ = Inertia<double>::zero();  ///< of all bodies rigid with the world
};

}  // namespace

RobotModel build_model(const urdf::ModelInterface& tree, const UrdfOptions& options,
                       UrdfReport& report) {
  return Builder(tree, options, report).build();
}

}  // namespace conddp
