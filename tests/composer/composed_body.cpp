#include "composed_body.hpp"

#include <filesystem>
#include <stdexcept>

#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/model/system_fields.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// Slightly perturbed scalar parameters of a closed-form system.
template <class P>
Entries parameter_entries(RandomNumbers& random) {
  Entries entries;
  const P usual;
  for_each_field(usual, [&](std::string_view key, std::string_view, double value,
                            const NumberRange&) {
    if (random.chance(0.5))
      entries.push_back(fmt::format("{}: {}", key, number_text(value * random.uniform(0.7, 1.4))));
  });
  return entries;
}
template <>
Entries parameter_entries<DoubleIntegratorSpec>(RandomNumbers&) {
  return {"dimension: 2"};
}
template <>
Entries parameter_entries<LinearSpec>(RandomNumbers& random) {
  Entries A, B;
  for (int i = 0; i < 3; ++i) {
    A.push_back(flow_list(random_numbers(3, 0.8, random)));
    B.push_back(flow_list(random_numbers(2, 1, random)));
  }
  Entries entries = {"A: " + flow_list(A), "B: " + flow_list(B)};
  if (random.chance(0.5)) entries.push_back("c: " + flow_list(random_numbers(3, 0.1, random)));
  return entries;
}

template <>
Entries parameter_entries<ExpressionSystemSpec>(RandomNumbers& random) {
  return {"positions: {x: m, angle: rad}",
          "velocities: {vx: m/s, omega: rad/s}",
          "controls: [push, turn]",
          fmt::format("parameters: {{k: {:.3g}}}", random.uniform(0.5, 2)),
          "let: {c: cos(angle), s: sin(angle)}",
          "acceleration: {vx: 0.5*push*c - 0.1*vx + 0.2*omega^2*s, omega: turn - k*s - 0.1*omega}"};
}

using Parameters = decltype(SystemSpec::parameters);

template <std::size_t... I>
std::vector<ComposedBody> closed_forms(std::index_sequence<I...> /*types*/) {
  std::vector<ComposedBody> bodies;
  (bodies.push_back({.name = std::string(kSystemTypes[I].name),
                     .text =
                         [](RandomNumbers& random) {
                           Entries entries = {fmt::format("type: {}", kSystemTypes[I].name)};
                           for (std::string& entry :
                                parameter_entries<std::variant_alternative_t<I, Parameters>>(
                                    random))
                             entries.push_back(std::move(entry));
                           return fmt::format("system: {}\n", flow_map(entries));
                         }}),
   ...);
  return bodies;
}

/// Robot text with options common to all robots.
std::function<std::string(RandomNumbers&)> robot_text(std::string keys, std::string more = "") {
  return [keys = std::move(keys), more = std::move(more)](RandomNumbers& random) {
    std::string text = keys;
    if (random.chance(0.3))
      text += fmt::format(", passive: {{damping: {}, friction: {}}}",
                          pick_word(kPassiveWords, random), pick_word(kPassiveWords, random));
    if (random.chance(0.2))
      text += fmt::format(", inertias: {}", pick_word(kInertiasWords, random));
    return fmt::format("robot: {{{}}}\n{}", text, more);
  };
}

/// The same for a robot whose steps find contacts.
std::function<std::string(RandomNumbers&)> stepping_text(const std::string& keys,
                                                         const std::string& candidates,
                                                         const std::string& stepping,
                                                         bool floating = false) {
  return [=](RandomNumbers& random) {
    std::string own = stepping;
    // The midpoint rule requires flat states.
    if (!floating && random.chance(0.5))
      own += fmt::format("{}scheme: {}", own.empty() ? "" : ", ", pick_word(kSchemeWords, random));
    if (random.chance(0.5))
      own +=
          fmt::format("{}friction: {}", own.empty() ? "" : ", ", pick_word(kFrictionWords, random));
    return robot_text(keys, fmt::format("contact_candidates:\n{}", candidates))(random) +
           (own.empty() ? "" : fmt::format("stepping: {{{}}}\n", own));
  };
}

constexpr const char* kArmShapes = R"(collision:
  shapes:
    upper_arm: {frame: link_3, capsule: {radius: 0.05, from: [0, 0, 0], to: [0, 0, 0.2]}}
    hand: {frame: link_7, sphere: {radius: 0.05, center: [0, 0, 0.02]}}
    column: {frame: base, capsule: {radius: 0.1, from: [0, 0, 0], to: [0, 0, 0.2]}}
  obstacles:
    ball: {sphere: {radius: 0.1, center: [0.6, 0, 0.4]}}
    pole: {capsule: {radius: 0.1, from: [0.6, 0.5, 0], to: [0.6, 0.5, 1]}}
    table: {half_space: {normal: [0, 0, 1], point: [0, 0, -0.2]}}
)";

std::vector<ComposedBody> robots() {
  std::vector<ComposedBody> bodies;
  bodies.push_back(
      {.name = "double_pendulum", .text = robot_text("urdf: robots/double_pendulum.urdf")});
  bodies.push_back({.name = "cartpole",
                    .text = robot_text("urdf: robots/cartpole.urdf, actuation: {joints: [slider]}"),
                    .initial_state = {"joints: {hinge: 0.3}"}});
  bodies.push_back(
      {.name = "arm",
       .text = robot_text("urdf: robots/arm7.urdf, locked_joints: {joint_3: 0, joint_5: 0.1}, "
                          "payloads: {link_7: {mass: 0.5, com: [0, 0, 0.05]}}, rotor_inertia: "
                          "{joint_1: 0.1}",
                          kArmShapes),
       .initial_state = {"joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}"},
       .shapes = {"upper_arm", "hand", "ball"},
       .most_knots = 8});
  bodies.push_back(
      {.name = "two_robots",
       .text =
           [](RandomNumbers&) {
             return std::string(
                 "robots:\n"
                 "  cart: {urdf: robots/cartpole.urdf, placement: {position: [0, 1, 0]}}\n"
                 "  body: {urdf: robots/free_body.urdf, base: floating, actuation: none,\n"
                 "         external_wrenches: [{frame: body, force: [0, 0, 1]}]}\n");
           },
       .initial_state = {"robots: {body: {base: {position: [0, 0, 1]}}}"},
       .floating = true});
  bodies.push_back(
      {.name = "free_body",
       .text = robot_text(
           "urdf: robots/free_body.urdf, base: floating, actuation: {thrusters: ["
           "{name: push, frame: body, direction: [1, 0, 0], torque_ratio: 0.1, lower: -3, upper: "
           "3}, {name: lift, frame: body, upper: 20}, {name: twist, frame: antenna, direction: "
           "[0, 1, 0], torque_ratio: -0.1, lower: -3, upper: null}]}"),
       .initial_state = {"base: {position: [0, 0, 1], rpy: [0.1, 0, 0.2]}"},
       .floating = true});
  bodies.push_back(
      {.name = "hopper",
       .text = robot_text("urdf: robots/hopper.urdf, base: planar, "
                          "placement: {rpy: [1.5707963267948966, 0, 0]}"),
       .initial_state = {"base: {position: [-0.023, 0.4583]}", "joints: {hip: 0.75, knee: -1.4}"},
       .feet = {{"foot", "foot"}}});
  bodies.push_back(
      {.name = "quadruped",
       .text = robot_text("urdf: robots/quadruped.urdf, base: floating"),
       .initial_state = {"base: {position: [0, 0, 0.57]}",
                         "joints: {\"*F_HFE\": 0.75, \"*F_KFE\": -1.5, \"*H_HFE\": -0.75, "
                         "\"*H_KFE\": 1.5}"},
       .feet = {{"LF", "lf_foot"}, {"RF", "rf_foot"}, {"LH", "lh_foot"}, {"RH", "rh_foot"}},
       .walks = true,
       .floating = true,
       .most_knots = 5});
  bodies.push_back(
      {.name = "biped",
       .text = robot_text(
           "urdf: robots/biped.urdf, base: floating, locked_joints: {l_shoulder_pitch: 0, "
           "l_shoulder_roll: 0, l_shoulder_yaw: 0, l_elbow: 0, r_shoulder_pitch: 0, "
           "r_shoulder_roll: 0, r_shoulder_yaw: 0, r_elbow: 0, torso_yaw: 0}"),
       .initial_state = {"base: {position: [0, 0, 0.7832]}",
                         "joints: {\"*_hip_pitch\": -0.4, \"*_knee\": 0.8, \"*_ankle_pitch\": "
                         "-0.4}"},
       .feet = {{"left", "l_sole", true}, {"right", "r_sole", true}},
       .floating = true,
       .most_knots = 4});
  bodies.push_back({.name = "block",
                    .text = stepping_text("urdf: robots/block.urdf, actuation: {joints: [base_x]}",
                                          "  rear: {frame: corner_1, friction: 0.5}\n"
                                          "  front: {frame: corner_2, friction: 0.2}\n",
                                          "plane: [0, 1, 0]"),
                    .initial_state = {"joints: {base_z: 0.5}"},
                    .stepping = true,
                    .most_knots = 5});
  bodies.push_back(
      {.name = "finger",
       .text = stepping_text(
           "urdf: robots/finger_spinner.urdf, actuation: {joints: [shoulder, elbow]}",
           "  tip: {frame: tip, radius: 0.05, against: {frame: hub, sphere: {radius: 0.25}}}\n",
           "plane: [0, 1, 0], joint_limits: {elbow: [0, 2.5]}, joint_friction: {shoulder: 0.1}"),
       .initial_state = {"joints: {shoulder: 0.3, elbow: 1.5}"},
       .stepping = true,
       .most_knots = 5});
  bodies.push_back(
      {.name = "crate",
       .text = stepping_text(
           "urdf: robots/crate.urdf, base: floating, actuation: {thrusters: [{name: pull, frame: "
           "handle, lower: -7, upper: 7}]}",
           "  c1: {frame: corner_1, friction: 0.5}\n"
           "  c2: {frame: corner_2, stiffness: 2000, friction: 0}\n",
           "", true),
       .initial_state = {"base: {position: [0, 0, 0.12]}"},
       .stepping = true,
       .floating = true,
       .most_knots = 4});
  return bodies;
}

/// Queries the tool for names in a problem with only the body.
void learn(ComposedBody& body) {
  RandomNumbers random(1);
  Diagnostics out;
  const std::string text = fmt::format(
      "conddp: 1\n{}initial_state: {}\nphases: [{{knots: 1, dt: 0.1}}]\n{}", body.text(random),
      flow_map(body.initial_state), body.stepping ? "solver: {name: ipopt}\n" : "");
  const auto spec = read_problem_text(text, source_tree() / "problems/composed.yaml", {}, out);
  const auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
  if (!built) throw std::runtime_error(format_diagnostics(out, false) + text);
  const Plant& plant = built->plant;
  body.robot = plant.multibody() != nullptr;
  body.kind = plant.actuated().kind();
  const StateManifold& manifold = plant.system->manifold();
  body.curved = !manifold.curved().empty();
  for (const auto& segment : manifold.segments())
    for (int i = 0; segment.part == StateManifold::Part::flat && i < segment.n; ++i) {
      (segment.dx + i < plant.system->nv() ? body.positions : body.velocities) = true;
      body.columns.push_back(plant.system->state_columns()[segment.x + i].name);
    }
  for (const Column& column : plant.actuated().control_columns())
    body.controls.push_back(column.name);
  if (!body.robot) return;
  body.joints = joint_names(plant.robot());
  body.frames = frame_names(plant.robot());
  for (int joint = 0; joint < plant.robot().joint_count(); ++joint) {
    if (!is_independent(plant.robot(), joint)) continue;
    const MultibodySystem::JointLimits limits = plant.multibody()->limits(joint);
    body.limited_positions |= std::isfinite(limits.lower) || std::isfinite(limits.upper);
    body.limited_velocities |= std::isfinite(limits.max_velocity);
  }
}

}  // namespace

const std::vector<ComposedBody>& composed_bodies() {
  static const std::vector<ComposedBody> kBodies = [] {
    // All but the last, whose function is in a separate file.
    std::vector<ComposedBody> list =
        closed_forms(std::make_index_sequence<std::size(kSystemTypes) - 1>());
    for (ComposedBody& body : robots()) list.push_back(std::move(body));
    for (ComposedBody& body : list) learn(body);
    return list;
  }();
  return kBodies;
}

}  // namespace conddp
