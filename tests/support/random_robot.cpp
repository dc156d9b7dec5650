#include "support/random_robot.hpp"

#include <algorithm>
#include <utility>

#include "robot/model.hpp"

namespace conddp {

namespace {

/// A physically valid inertia: a positive mass distribution, hence the triangle inequality.
Inertia<double> random_inertia(RandomNumbers& random) {
  const double mass = random.uniform(0.5, 5);
  Symmetric3<double> spread = Symmetric3<double>::zero();
  for (int i = 0; i < 3; ++i) spread += point_inertia(mass / 3, random.vector(0.2));
  const Vector3<double> com = random.vector(0.15);
  return inertia_about_origin(mass, com, spread);
}

Joint random_joint(RandomNumbers& random, const std::string& name, int parent, double prismatic,
                   bool rotor) {
  Joint joint;
  joint.name = name;
  joint.type = random.chance(prismatic) ? JointType::prismatic : JointType::revolute;
  joint.parent = parent;
  joint.placement = random.placement(0.4);
  joint.inertia = random_inertia(random);
  if (rotor) joint.rotor_inertia = random.uniform(0, 0.3);
  return joint;
}

Joint floating_joint(RandomNumbers& random) {
  Joint base;
  base.name = "base";
  base.type = JointType::floating;
  base.inertia = random_inertia(random);
  return base;
}

void add_frames(RobotModel& model, RandomNumbers& random) {
  model.frames.push_back({"world", FrameKind::link, -1, SE3<double>::identity()});
  model.frames.push_back({"somewhere", FrameKind::link, -1, random.placement(1)});
  for (int i = 0; i < model.joint_count(); ++i) {
    const std::string& name = model.joints[i].name;
    model.frames.push_back({name, FrameKind::joint, i, SE3<double>::identity()});
    model.frames.push_back({name + "_link", FrameKind::link, i, random.placement(0.5)});
  }
}

}  // namespace

RobotModel random_robot(std::uint64_t seed, const RandomRobotOptions& options) {
  RandomNumbers random(seed);
  RobotModel model;
  model.name = "random" + std::to_string(seed);
  if (options.floating) model.joints.push_back(floating_joint(random));
  // Depth first: a joint attaches to the last one or to one of its ancestors.
  for (int i = 0; i < options.joints; ++i) {
    int parent = model.joint_count() - 1;
    while (parent >= 0 && random.chance(options.branching)) {
      if (options.floating && parent == 0) break;
      parent = model.joints[parent].parent;
    }
    model.joints.push_back(random_joint(random, "joint" + std::to_string(i), parent,
                                        options.prismatic, options.rotors && random.chance(0.7)));
  }
  add_frames(model, random);
  for (int i = 0; i < options.wrenches; ++i) {
    const Vector3<double> force = random.vector(20);
    const int frame = i == 0 ? 1 : random.index(static_cast<int>(model.frames.size()));
    model.wrenches.push_back({frame, {force, random.vector(5)}});
  }
  model.finalize();
  return model;
}

RobotModel humanoid_like_robot(std::uint64_t seed) {
  RandomNumbers random(seed);
  RobotModel model;
  model.name = "humanoid_like";
  model.joints.push_back(floating_joint(random));
  const auto limb = [&](const std::string& name, int joints, int parent) {
    for (int i = 0; i < joints; ++i) {
      model.joints.push_back(random_joint(random, name + std::to_string(i), parent, 0, true));
      parent = model.joint_count() - 1;
    }
    return parent;
  };
  limb("left_leg", 6, 0);
  limb("right_leg", 6, 0);
  const int torso = limb("waist", 2, 0);
  limb("head", 2, torso);
  limb("left_arm", 8, torso);
  limb("right_arm", 8, torso);
  add_frames(model, random);
  model.finalize();
  return model;
}

RobotModel loaded_robot(RobotModel model, std::uint64_t seed) {
  RandomNumbers random(seed);
  const int last = model.joint_count() - 1;
  const int first_parameter = model.add_parameter("load");
  const int second_parameter = model.add_parameter("other");
  const auto add = [&](int parameter, int body) {
    const Inertia<double> y = random_inertia(random);
    const Symmetric3<double>& j = y.rotational;
    constexpr double kShare = 0.05;
    const Inertia<double> unit{
        kShare * y.mass,
        kShare * y.moment,
        {kShare * j.xx, kShare * j.xy, kShare * j.xz, kShare * j.yy, kShare * j.yz, kShare * j.zz}};
    model.loads.push_back({parameter, body, unit});
    for (int i = 0; i < 3; ++i) model.joints[body].inertia += unit;
  };
  add(first_parameter, 0);
  add(second_parameter, last / 2);
  add(first_parameter, last);
  return model;
}

const std::vector<TestModel>& random_robots() {
  static const std::vector<TestModel> models = [] {
    std::vector<TestModel> m;
    const auto add = [&m](const char* name, RobotModel model) {
      m.push_back({name, std::move(model)});
    };
    add("one_joint", random_robot(1, {.joints = 1}));
    add("chain", random_robot(2, {.joints = 7, .branching = 0}));
    add("sliders", random_robot(3, {.joints = 4, .prismatic = 1}));
    add("tree", random_robot(4, {.joints = 12, .branching = 0.4}));
    add("bare_tree", random_robot(5, {.joints = 9, .rotors = false, .wrenches = 0}));
    add("one_body", random_robot(6, {.joints = 0, .floating = true}));
    add("floating_chain", random_robot(7, {.joints = 5, .floating = true, .branching = 0}));
    add("floating_tree", random_robot(8, {.joints = 14, .floating = true, .branching = 0.4}));
    add("bare_floating_tree",
        random_robot(9, {.joints = 12, .floating = true, .rotors = false, .wrenches = 0}));
    add("humanoid_like", humanoid_like_robot(10));
    RobotModel first = random_robot(11, {.joints = 5, .floating = true});
    RobotModel second = random_robot(12, {.joints = 4});
    RobotModel third = random_robot(13, {.joints = 2, .floating = true});
    add("three_trees", combine({first, second, third}));
    RobotModel tilted = random_robot(14, {.joints = 6, .floating = true});
    tilted.gravity = {1.5, -3.0, -8.0};
    add("tilted_gravity", std::move(tilted));
    add("loaded_tree", loaded_robot(random_robot(15, {.joints = 8, .branching = 0.4}), 16));
    add("loaded_floating_tree",
        loaded_robot(random_robot(17, {.joints = 9, .floating = true, .branching = 0.4}), 18));
    add("loaded_trees",
        combine({loaded_robot(random_robot(19, {.joints = 4, .floating = true}), 20),
                 loaded_robot(random_robot(21, {.joints = 3}), 22)}));
    return m;
  }();
  return models;
}

RobotState random_state(const RobotModel& model, RandomNumbers& random) {
  RobotState state{model.neutral_configuration(), std::vector<double>(model.nv),
                   std::vector<double>(model.nv), std::vector<double>(model.nv)};
  for (const Joint& joint : model.joints) {
    double* q = &state.q[joint.q];
    if (joint.type == JointType::floating) {
      const Vector3<double> p = random.vector(2);
      const Quaternion<double> r = random.rotation();
      const double values[] = {p.x, p.y, p.z, r.x, r.y, r.z, r.w};
      std::copy(std::begin(values), std::end(values), q);
    } else {
      q[0] = random.uniform(-3, 3);
    }
  }
  for (int i = 0; i < model.nv; ++i) {
    state.v[i] = random.uniform(-2, 2);
    state.a[i] = random.uniform(-5, 5);
    state.tau[i] = random.uniform(-20, 20);
  }
  for (const Joint& joint : model.joints)
    if (joint.type == JointType::parameter) state.v[joint.v] = 0;
  return state;
}

}  // namespace conddp
