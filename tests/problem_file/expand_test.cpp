// A problem printed with every default is the same problem.
#include <map>
#include <set>

#include "base/shared_library.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/model/system_fields.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "schema_document.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/sizes.hpp"
#include "support/source_tree.hpp"
#include "yaml_1_1.hpp"

namespace conddp {
namespace {

/// Files that together use every object of the schema, including one with only the required keys.
std::vector<std::string> corpus() {
  std::vector<std::string> texts = {std::string(kPendulum), std::string(kCartpole)};
  for (const auto& file : ready_problems()) texts.push_back(read_file(file));
  allow_code();
  for (const SystemType& system : kSystemTypes) {
    const std::string_view type = system.name;
    const std::string more = type == "linear"        ? ", A: [[1, 0.1], [0, 1]], B: [[0], [0.1]]"
                             : type == "expressions" ? ", states: [x], controls: [u], rate: {x: u}"
                             : type == "library"
                                 ? ", library: " CONDDP_TEST_MODEL
                                   ", function: swing, states: "
                                   "{angle: rad, speed: rad/s}, controls: [torque], parameters: "
                                   "{inertia: 2, weight: 5}"
                                 : "";
    texts.push_back("conddp: 1\nsystem: {type: " + std::string(type) + more +
                    "}\ninitial_state: {}\nphases: [{knots: 3, duration: 0.1}]\n");
  }
  texts.push_back(std::string(kCartpole) +
                  "terrain: {hills: {height_map: {file: tables/hills.csv, cell: 1}}}\n");
  texts.push_back(R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {}
phases: [{knots: 3, duration: 0.1}]
integrals: {effort: u^2}
costs:
  own: {residual: expression, of: {o: {residual: expression, rows: {twice: 2*x}}}, rows: "o[twice]^2"}
)");
  texts.push_back(R"(conddp: 1
system:
  positions: {y: m, turn: unit_quaternion, body: pose}
  velocities: {n: m/s, spin: rad/s, twist: m/s}
  controls: {u: N, w: Nm}
  parameters: {m: 1.5}
  tables:
    drag: {points: [-1, 0, 2], values: [0.5, 0, 1]}
    ground: {points: [[0, 1], [0, 1, 2]], values: [[0, 1, 0], [1, 0, 1]]}
  let: {push: u/m, axis: [0, 0, 1]}
  acceleration:
    n: push - drag(n) + ground(y, n)*sin(t)
    spin: w*rotate(turn, axis)
    twist: [-0.1*twist.linear, 0, w, 'if(y > 0, -0.1, 0.1)*body.position.x']
initial_state: {values: {y: 0.3}}
phases: [{knots: 3, dt: 0.1}]
)");
  texts.push_back(R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {}
phases: [{knots: 3, dt: 0.1}]
costs: {state: {residual: state, matrix: [[1, 0.1], [0.1, 1]]}, effort: {residual: control}}
constraints: {force: {bounds: control, lower: -1, upper: 1}}
terminal: {lqr: {about: {values: {q/0: 0.5}}, weight: 1.1, set: true}}
solver: {name: altro}
)");
  texts.push_back(R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {}
phases: [{knots: 3, dt: 0.1}]
costs: {state: {residual: state}, effort: {residual: control}}
terminal: {lqr: initial}
)");
  texts.push_back(
      "conddp: 1\nsystem: {positions: [y], velocities: [v], controls: [push], "
      "library: " CONDDP_TEST_MODEL
      ", function: fall, gives: acceleration}\n"
      "initial_state: {}\nphases: [{knots: 3, dt: 0.1}]\n"
      "costs: {reach: {residual: library, library: " CONDDP_TEST_MODEL
      ", function: reach, parameters: {length: 0.5}, reference: 0.1}}\n");
  texts.push_back(R"(conddp: 1
system: {states: [x], controls: [u], next: {x: '0.9*x + 0.1*atan2(u, 2)'}}
initial_state: {}
phases: [{knots: 3, dt: 0.1}]
)");
  texts.push_back(R"(conddp: 1
description: "two robots: one of them # flies"
gravity: [0, 0, -1.62]
robots:
  arm: {urdf: robots/arm7.urdf, mimic: enforce, inertias: strict, placement: {position: [3, 0, 0], rpy: [0, 0, 1]},
        locked_joints: {joint_7: 0.3}, rotor_inertia: {joint_1: 0.1}, passive: {friction: urdf},
        payloads: {link_6: {mass: 2, inertia: {ixx: 0.1, iyy: 0.1, izz: 0.1}}},
        external_wrenches: [{frame: tool}, {frame: tool, force: [1, 2, 3]}]}
  body:
    urdf: robots/free_body.urdf
    base: floating
    actuation: {thrusters: [{name: a, frame: body}, {name: b, frame: body, direction: [1, 2, 3],
                torque_ratio: 0.1, lower: null, upper: 3}]}
    configurations: {turned: {base: {position: [0, 0, 1], rpy: [0.3, -0.2, 0.1]}}}
initial_state:
  robots: {arm: {joints: {joint_2: 0.4}, velocity: {joints: {joint_2: 0.1}}},
           body: {configuration: turned, velocity: {base: {linear: [1, 0, 0]}}}}
integrator: rk2
running_costs: sum
phases: [{knots: 2, dt: 0.1, weights: {rate: 2}}, {name: "1.5", knots: 3, dt: 0.05}]
costs:
  rate: {residual: control_rate, phases: phase_1}
  position: {residual: joint_position, joints: arm/joint_2, reference: 0.1, knots: [0, 3]}
  velocity: {residual: joint_velocity, weights: {"arm/joint_*": 2},
             activation: {kind: quadratic_barrier, from: urdf}}
  acceleration: {residual: joint_acceleration, activation: smooth_l1}
  point: {residual: frame_position, frame: arm/tool,
          reference: {times: [0, 0.2], values: [[0, 0, 1], initial]}}
  turn: {residual: frame_rotation, frame: body/body,
         reference: {knots: [1, 4], values: [body/turned, {rpy: [0, 0, 2]}]}}
  pose: {residual: frame_placement, frame: arm/tool,
         reference: {position: [0, 0, 1], orientation: [0.5, 0.5, 0.5, 0.5]}}
  speed: {residual: frame_velocity, frame: arm/tool, axes: local, reference: [0, 0, 0, 0, 0, 1]}
  speed_2: {residual: frame_velocity, frame: arm/tool}
  com: {residual: com_position, reference: initial, matrix: [[2], [0, 1], [0.5, 0, 1]]}
  inside: {residual: com_position, activation: {kind: quadratic_barrier, lower: -9, upper: [9, null, 9]}}
  hold: {residual: control_gravity, activation: {kind: smooth_l2, epsilon: 0.5}}
  chosen: {residual: state, columns: [q/arm/joint_1, v/arm/joint_1]}
constraints: {limits: {bounds: control, from: urdf, upper: 50, phases: ["1.5"]}}
terminal: {costs: {end: {residual: frame_velocity, frame: arm/tool,
                         matrix: {vx: {vx: 2, wz: 1}, wz: {wz: 1}}}, rest: {residual: state}}}
initial_guess: {states: {keyframes: [{time: 0.1, state: body/turned}, {time: 0.2, state:
                {robots: {body: {velocity: {base: {angular: [0, 0, 1]}}}}}}]},
                controls: {constant: {"*": 0.1}, random: {scale: 0.1}}}
solver: {name: box_fddp, max_time_s: 100}
)");
  texts.push_back(R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  defaults: {max_normal_force: 900}
  LF: {frame: lf_foot}
  RF: {frame: rf_foot, type: planar, normal: [0, 0.6, 0.8], tangent: [2, 0, 0]}
  LH: {frame: lh_foot, type: surface, size: [0.2, 0.1], friction: 0.5, min_normal_force: 1}
  RH: {frame: rh_foot, type: normal, axes: local, baumgarte: {kp: 3, kd: 4},
       placement: {position: [0, 0, 0.1]}}
initial_state: {base: {position: [0, 0, 0.57]}, joints: {LF_KFE: -1, RF_KFE: -1, LH_KFE: 1, RH_KFE: 1}}
phases:
  - {knots: 2, dt: 0.1, contacts: all}
  - {knots: 2, dt: 0.1}
  - {name: landing, impulse: [LF, LH]}
  - {name: hit, impulse: all, restitution: 0.5}
  - {knots: 2, dt: 0.1, contacts: [LF, LH]}
costs:
  cone: {residual: friction_cone, contacts: [LF, RF]}
  round: {residual: friction_cone, contacts: LF, cone: second_order, safety: 0.8}
  sole: {residual: wrench_cone, contacts: LH, inner: false}
  pressure: {residual: center_of_pressure, contacts: LH}
  force: {residual: contact_force}
  hit: {residual: contact_force, contacts: LF, phases: landing,
        activation: {kind: quadratic_barrier, upper: 5}}
  spin: {residual: centroidal_momentum, reference: initial, weights: {lx: 3}}
  swing: {residual: frame_position, frame: rf_foot, phases: [phase_2], swing: {height: 0.1}}
  step: {residual: frame_position, frame: lh_foot, phases: [phase_2],
         swing: {height: 0.1, landing: [0, 0, 0]}}
)");
  texts.push_back(R"(conddp: 1
robot: {urdf: robots/arm7.urdf}
collision:
  shapes:
    base: {frame: base, sphere: {radius: 0.1}}
    upper: {frame: link_3, capsule: {radius: 0.05, to: [0, 0, 0.2]}}
    fore: {frame: link_5, capsule: {radius: 0.04, from: [0, 0, 0.01], to: [0, 0, 0.2]}}
    hand: {frame: tool, sphere: {radius: 0.05, center: [0, 0, 0.02]}}
    cup: {frame: tool, hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0, 0.1]]}}
  obstacles:
    ball: {sphere: {radius: 0.1, center: [0.5, 0, 0.5]}}
    pole: {capsule: {radius: 0.1, from: [1, 0, 0], to: [1, 0, 1]}}
    drum: {cylinder: {radius: 0.2, from: [1, 1, 0], to: [1, 1, 1]}}
    shelf: {box: {size: [1, 0.3, 0.02], placement: {position: [1, 0, 1], rpy: [0, 0, 1]}}}
    floor: {half_space: {}}
    wall: {half_space: {normal: [0, -2, 0], point: [0, 1, 0]}}
initial_state: {joints: {joint_2: 0.3}}
phases:
  - {knots: 3, dt: 0.1, refine: {first: 2}}
  - {knots: 3, duration: 0.3, refine: {last: 1, ratio: 0.7}}
costs:
  all: {residual: distance, pairs: all, weights: {"hand-*": 2, fore-floor/to: 3}}
  self: {residual: distance, pairs: self, margin: 0.05}
  named: {residual: distance, pairs: [[hand, "*"], [fore, ball]], activation: smooth_l1}
  level: {residual: joint_position, joints: ["joint_1", "joint_*"]}
constraints: {slow: {residual: frame_velocity, frame: tool, at_most: 3}}
terminal:
  costs: {clear: {residual: distance, pairs: obstacles}}
  constraints: {slower: {residual: frame_velocity, frame: tool, at_most: 1}}
)");
  texts.push_back(R"(conddp: 1
robot: {urdf: robots/finger_spinner.urdf}
contact_candidates:
  tip: {frame: tip, radius: 0.05, against: {frame: spinner, sphere: {radius: 0.25}}}
  floor: {frame: tip, point: [0, 0, 0.1], friction: 0, stiffness: 200}
  wall: {frame: tip, against: {half_space: {normal: [0, 0, 2], point: [0, 0, -3]}}}
  block: {frame: tip, friction: 0.7,
          against: {box: {size: [1, 2, 3], placement: {position: [5, 0, 0], rpy: [0, 0, 1]}}}}
stepping:
  plane: [0, 2, 0]
  joint_limits: {"*": [-2, 2], elbow: [null, 3]}
  joint_friction: {shoulder: 0.1}
  regularization: 0.01
initial_state: {}
phases: [{knots: 3, dt: 0.1}]
costs: {effort: {residual: control, weight: 0.1}}
solver: {name: ipopt}
)");
  texts.push_back(replaced(texts.back(), "plane: [0, 2, 0]", "friction: cone"));
  texts.push_back(R"(conddp: 1
system: {type: pendulum}
initial_state: {}
phases: [{name: start, choose: [theta, "om*"], lower: -1, upper: {theta: 2}}, {knots: 3, dt: 0.1}]
costs: {mix: {residual: combination, rows: {theta: 1, constant: -2}}}
constraints: {mixed: {residual: combination, rows: [{torque: 1, omega: 3}, {omega: 1}], upper: [2, null]}}
terminal:
  constraints: {cycle: {residual: cycle, offset: {theta: 0.5}, equals: {omega: 0}}}
  costs: {near: {residual: cycle}}
solver: {name: altro}
)");
  texts.push_back(R"(conddp: 1
system: {type: pendulum}
initial_state: {}
phases: [{name: start, choose: none}, {knots: 3, dt: 0.1, free_duration: {}},
         {knots: 4, duration: 2, refine: {first: 1}, free_duration: {lower: 0.5}}]
costs: {time: {residual: combination, rows: {constant: 1}}}
solver: {name: ipopt}
)");
  texts.push_back(R"(conddp: 1
parameters: {far: 2, there: [1, "=far/2"]}
tables: {drag: {points: [0, 1, 3], values: [0, 2, 5]}}
robot: {urdf: robots/cartpole.urdf, actuation: {joints: [slider]}}
initial_state: {joints: {hinge: 0.5}}
phases: [{knots: 3, dt: 0.1}]
costs:
  own:
    residual: expression
    of: {tip: {residual: frame_position, frame: tip}, flow: {residual: frame_velocity, frame: tip}}
    rows: [far*tip.z - t, "[drag(flow.vx), u[slider]]"]
    reference: =[1, 2, 3]
    activation: linear
  plain: {residual: expression, rows: "q[slider]"}
constraints: {power: {residual: expression, rows: {power: "u[slider]*v[slider]"}, upper: =far}}
terminal:
  costs: {end: {residual: expression, rows: "v[hinge]", weights: 2}}
  constraints: {stop: {residual: expression, rows: "q[slider]*v[slider]"}}
solver: {name: altro}
)");
  const std::string_view legged = R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  LF: {frame: lf_foot}
  RF: {frame: rf_foot, type: surface}
  LH: {frame: lh_foot, normal: [-0.1, 0.2, 1]}
  RH: {frame: rh_foot}
initial_state: {base: {position: [0, 0, 0.57], rpy: [0, 0, 1]}, displaced: [0.1, 0.2, 0.3],
                joints: {LF_KFE: -1, RF_KFE: -1, LH_KFE: 1, RH_KFE: 1}}
gait: {type: stand, dt: 0.02}
costs:
  posture: {residual: state, reference: {base: {position: [0, 0, 0.57]}, displaced: gait}}
  hold: {residual: contact_force, contacts: LF}
terminal:
  costs: {rest: {residual: state, reference: {base: {position: [0, 0, 0.57]}, displaced: gait}}}
)";
  for (const char* gait :
       {"type: stand", "type: walk, period: 0.8, step: {length: 0.1, direction: 0.4}",
        "type: trot, period: 0.4, cycles: 3, step: {length: 0.1, turn: -0.7}, impulses: true",
        "type: pace, period: 0.4, duty: 0.7, step: {turn: 0.2}, stand: {begin: 0, end: 0.1}",
        "type: bound, period: 0.4, duty: 0.3, cycles: 2, impulses: true",
        "type: jump, period: 0.6, cycles: 2, step: {length: 0.3}, feet: {one: LF, two: RH}"})
    texts.push_back(replaced(legged, "type: stand", gait));
  texts.push_back(replaced(
      replaced(kPendulum, "constraints:\n",
               "constraints:\n"
               "  speed: {bounds: velocity, lower: -2, upper: 5}\n"
               "  here: {bounds: state, lower: {theta: -1}, phases: second}\n"
               "  fixed: {residual: state, equals: {theta: 0.2}, knots: [2, 3]}\n"
               "  far: {residual: state, columns: theta, reference: 4, at_least: 1, at_most: 9}\n"
               "  cone: {residual: state, cone: second_order, slope: 2, knots: [5]}\n"
               "  posts: {residual: state, columns: theta, at_least: 1, centers: [[4], {from: [5], "
               "to: [7], count: 3}]}\n"),
      "terminal:\n  costs:\n    goal: {residual: state, reference: {values: {theta: 1}}, weight: "
      "10}\n"
      "solver: {name: box_ddp}\n",
      "terminal:\n  constraints:\n    goal: {residual: state, reference: [1, 0]}\n"
      "    near: {residual: state, lower: -1, upper: [1, null]}\n"
      "solver: {name: altro}\n"));
  texts.push_back(R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  LF: {frame: lf_foot}
  RF: {frame: rf_foot, type: surface, size: [0.2, 0.1], max_normal_force: 300}
initial_state: {base: {position: [0, 0, 0.57]}}
phases: [{knots: 2, dt: 0.1, contacts: all}]
costs: {effort: {residual: control}}
constraints:
  exact: {residual: friction_cone, contacts: LF, cone: second_order, safety: 0.8}
  force: {residual: contact_force, contacts: LF, cone: second_order}
  pyramid: {residual: friction_cone, contacts: LF, faces: 6, inner: false}
  sole: {residual: wrench_cone, contacts: RF}
  foot: {residual: frame_velocity, frame: rh_foot, axes: local, lower: -3}
  joints: {bounds: configuration, from: urdf}
terminal: {constraints: {body: {residual: frame_position, frame: rh_foot, reference: [0, 0, 0], at_most: 2}}}
solver: {name: altro}
)");
  texts.push_back(replaced(kPendulum, "solver:",
                           "initial_guess: {states: interpolate, controls: {random: {scale: 1, "
                           "seed: 12345678901234567}}}\nsolver:"));
  texts.push_back(replaced(kPendulum, "solver:",
                           "initial_guess: {states: {keyframes: [{knot: 2, "
                           "state: [1, 2]}]}, controls: gravity}\nsolver:"));
  texts.push_back(replaced(kPendulum, "solver:",
                           "initial_guess: {states: {interpolation: cubic, keyframes: [{knot: 2, "
                           "state: [1, 2]}, {knot: 5, state: [0, 1]}]}}\nsolver:"));
  texts.push_back(replaced(kPendulum, "solver:", "mesh: {error: 1.0e-3}\nsolver:"));
  const std::string walk = replaced(
      read_file(source_tree() / "problems/mpc/quadruped_commands.yaml"), "../robots", "robots");
  texts.push_back(walk);
  texts.push_back(replaced(walk, "retime: {early: 0.06}", "retime: {late: 0.04}"));
  texts.push_back(replaced(walk, "{noise: state, sigma: 1.0e-4}", "{late: 0.1}"));
  return texts;
}

std::string expanded(const Loaded& loaded) { return expanded_text(*loaded.built); }

double cost_after(const Loaded& loaded, int iterations) {
  SolverOptions options = loaded.spec->solver.options;
  options.max_iterations = iterations;
  return solve(*loaded.built->problem, loaded.spec->solver.name.value, options, loaded.built->guess)
      .cost;
}

TEST(Expand, ReadingTheTextGivesTheSameProblem) {
  std::vector<Json> documents;
  for (const std::string& text : corpus()) {
    const Loaded first(text);
    ASSERT_TRUE(first.built) << first.all() << text;
    const std::string expansion = expanded(first);
    const Loaded second(expansion);
    ASSERT_TRUE(second.built) << second.all() << expansion;
    EXPECT_EQ(expanded(second), expansion);
    EXPECT_EQ(Yaml11Reader::misread(expansion), std::vector<std::string>());
    for (const int iterations : kSmallSizes ? std::vector{0} : std::vector{0, 3})
      EXPECT_EQ(cost_after(second, iterations), cost_after(first, iterations)) << expansion;
    documents.push_back(parse_to_json(expansion));
    EXPECT_EQ(documents.back(), Json(expand_problem(*first.built))) << expansion;
  }
  const std::vector<bool> bad = violations(documents);
  for (std::size_t i = 0; i < bad.size(); ++i)
    EXPECT_FALSE(bad[i]) << documents[i].dump(1) << " does not fit the schema";
}

/// Compares an expansion with the defaults of the schema.
class DefaultWalk {
 public:
  explicit DefaultWalk(const Json& schema) : schema_(schema) { collect(schema, ""); }

  void compare(const Json& part, const Json& document) {
    const Json& target = resolved(part);
    for (const char* choice : {"anyOf", "oneOf"})
      if (target.contains(choice))
        for (const Json& branch : target[choice])
          if (takes(resolved(branch), document)) {
            compare(branch, document);
            break;
          }
    if (document.is_array() && target.contains("items"))
      for (const Json& item : document) compare(target["items"], item);
    if (!document.is_object()) return;
    const Json properties = Json::object();
    const Json& known = target.contains("properties") ? target["properties"] : properties;
    for (const auto& [key, value] : known.items()) {
      if (document.contains(key)) compare(value, document[key]);
      const auto found = defaults_.find(&value);
      if (found == defaults_.end()) continue;
      if (!document.contains(key))
        missing_.insert(found->second);
      else if (document[key] == default_of(value))
        seen_.insert(found->second);
    }
    if (target.contains("additionalProperties") && target["additionalProperties"].is_object())
      for (const auto& [key, value] : document.items())
        if (!known.contains(key)) compare(target["additionalProperties"], value);
  }

  /// Keys with a default that some expansion omitted.
  const std::set<std::string>& missing() const { return missing_; }
  /// Keys whose default no expansion showed.
  std::set<std::string> unseen() const {
    std::set<std::string> rest;
    for (const auto& [node, path] : defaults_)
      if (!seen_.contains(path)) rest.insert(path);
    return rest;
  }
  std::size_t count() const { return defaults_.size(); }

 private:
  const Json& resolved(const Json& part) const {
    if (part.contains("$ref")) {
      const std::string link = part["$ref"];
      return resolved(schema_.at(Json::json_pointer(link.substr(1))));
    }
    return part.contains("allOf") ? resolved(part["allOf"][0]) : part;
  }
  bool has_default(const Json& part) const {
    return part.contains("default") || resolved(part).contains("default");
  }
  const Json& default_of(const Json& part) const {
    return part.contains("default") ? part["default"] : resolved(part)["default"];
  }
  /// True if the keys of the document match this branch.
  bool takes(const Json& branch, const Json& document) const {
    if (!document.is_object() || !branch.contains("properties")) return false;
    const Json& known = branch["properties"];
    if (known.contains("type") && known["type"]["const"] != document.value("type", Json()))
      return false;
    return std::all_of(document.items().begin(), document.items().end(),
                       [&](const auto& entry) { return known.contains(entry.key()); });
  }
  void collect(const Json& part, const std::string& path) {
    if (!part.is_structured()) return;
    if (part.is_object() && part.contains("properties") && part["properties"].is_object())
      for (const auto& [key, value] : part["properties"].items())
        if (has_default(value)) defaults_[&value] = path + "/" + key;
    int index = 0;
    for (const auto& [key, value] : part.items()) {
      if (key != "default" && key != "examples")
        collect(value, path + "/" + (part.is_array() ? std::to_string(index) : key));
      ++index;
    }
  }

  const Json& schema_;
  std::map<const Json*, std::string> defaults_;
  std::set<std::string> seen_, missing_;
};

TEST(Expand, ShowsEveryDefaultOfTheSchema) {
  const Json schema = load_schema();
  DefaultWalk walk(schema);
  EXPECT_GT(walk.count(), 80u);
  for (const std::string& text : corpus()) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    walk.compare(schema, Json(expand_problem(*loaded.built)));
  }
  // Keys that another choice excludes, and keys of particular residuals.
  std::set<std::string> conditional = {"/definitions/robot/placement",
                                       "/definitions/activation/anyOf/1/epsilon",
                                       "/gravity",
                                       "/definitions/cost/weights",
                                       "/definitions/terminal_cost/weights",
                                       "/definitions/cost/activation",
                                       "/definitions/terminal_cost/activation",
                                       "/definitions/constraint/scale",
                                       "/definitions/constraint/nodes",
                                       "/definitions/residual_constraint/nodes",
                                       "/definitions/phase/restitution",
                                       "/definitions/mpc/commands",
                                       "/definitions/mpc/properties/plant/ground",
                                       "/definitions/phase/weights"};
  for (const char* term :
       {"cost", "terminal_cost", "residual_constraint", "terminal_constraint", "operand"})
    for (const ResidualKey* key : residual_keys())
      conditional.insert(fmt::format("/definitions/{}/{}", term, key->info.name));
  for (const std::string& key : walk.missing())
    EXPECT_TRUE(conditional.contains(key)) << key << " has a default that an expansion lacks";
  std::set<std::string> unseen = walk.unseen();
  // The expansion contains the results of a gait and its commands instead of their keys. GaitFile
  // covers their defaults, LibraryFiles those of compiled residuals, LoopFile those of loops, which
  // become contacts. The ground is written as a shape.
  std::erase_if(unseen, [](const std::string& key) {
    return key.starts_with("/gait") || key.starts_with("/definitions/gait/") ||
           key.starts_with("/definitions/commands/") || key.starts_with("/definitions/loop/") ||
           key == "/definitions/mpc/commands" || key.ends_with("/plant/ground") ||
           key.ends_with("/parameters");
  });
  EXPECT_EQ(unseen, std::set<std::string>{}) << "the schema's default is not the reader's";
}

TEST(Expand, KeepsModelineOfFileOrExample) {
  const Loaded plain{std::string(kPendulum)};
  EXPECT_TRUE(expanded(plain).starts_with(
      "# yaml-language-server: $schema=../schemas/problem.schema.json\nconddp: 1\n"));
  const Loaded own("# yaml-language-server: $schema=/opt/problem.json\n" + std::string(kPendulum));
  EXPECT_TRUE(
      expanded(own).starts_with("# yaml-language-server: $schema=/opt/problem.json\nconddp"));
}

TEST(Expand, OverridesAreInIt) {
  const Loaded loaded(std::string(kPendulum), {"solver.max_iterations=7", "phases.0.knots=9"});
  const OrderedJson json = expand_problem(*loaded.built);
  EXPECT_EQ(json["solver"]["max_iterations"], 7);
  EXPECT_EQ(json["phases"][0]["knots"], 9);
}

TEST(YamlText, IsReadBackTheSame) {
  const OrderedJson document = {
      {"plain", "a/b.c-d e"},
      {"texts", {"1.5",   "null",
                 "~",     "true",
                 "y",     "NO",
                 "a: b",  "#x",
                 "- x",   "",
                 " a ",   "*",
                 "ünï ∂", "quote \" and \\",
                 "'",     "{a}",
                 "0x10",  "1e5",
                 "a\tb",  "2 lines\nhere",
                 "!t",    "&a"}},
      {"1", "key of digits"},
      {"<<", "no merge"},
      {"null", nullptr},
      {"numbers", {0.1, -1e-300, 1e22, 5e-324, 1.7976931348623157e308, -0.0, 123456789012345678}},
      {"nested", {{{"a", {{1, 2}, {3, 4}}}}, OrderedJson::object(), OrderedJson::array()}}};
  EXPECT_EQ(parse_to_json(yaml_text(document)), Json(document)) << yaml_text(document);
}

}  // namespace
}  // namespace conddp
