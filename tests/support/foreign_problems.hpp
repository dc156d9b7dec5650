#pragma once

#include <fstream>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "support/robots.hpp"

// Problems of robots that are not part of the product, as texts of problem files.

namespace conddp {

/// The trot of HyQ that Crocoddyl and Pinocchio solved: discretisation, references, and figures at
/// the first guess and at the optimum. None where the robot or the figures are absent.
inline std::optional<nlohmann::json> hyq_trot_reference() {
  const auto folder = foreign_robot_folder();
  std::ifstream figures(folder.parent_path() / "reference/hyq_trot.json");
  if (!figures || !std::filesystem::exists(folder / "hyq.urdf")) return std::nullopt;
  return nlohmann::json::parse(figures);
}

/// Short names of the feet: LF for lf_foot.
inline std::string hyq_contact_name(const std::string& foot) {
  return {static_cast<char>(foot[0] - 'a' + 'A'), static_cast<char>(foot[1] - 'a' + 'A')};
}

/// Its problem file, to be read from the folder of hyq.urdf.
inline std::string hyq_trot_text(const nlohmann::json& reference) {
  const std::string x0 = reference["x0"].dump(), weights = reference["state_weights"].dump();
  std::string contacts, phases, swings;
  for (const char* foot : {"lf_foot", "rf_foot", "lh_foot", "rh_foot"}) {
    contacts += fmt::format("  {}: {{frame: {}}}\n", hyq_contact_name(foot), foot);
    std::vector<int> knots;
    nlohmann::json values = nlohmann::json::array();
    for (const nlohmann::json& knot : reference["knots"])
      if (knot["swing_ref"].contains(foot)) {
        knots.push_back(knot["k"]);
        values.push_back(knot["swing_ref"][foot]);
      }
    swings += fmt::format(
        "  swing_{0}: {{residual: frame_position, frame: {0}, weight: 1.0e+4, knots: {1}, "
        "reference: {{knots: {1}, values: {2}}}}}\n",
        foot, nlohmann::json(knots).dump(), values.dump());
  }
  std::vector<std::pair<nlohmann::json, int>> runs;
  for (const nlohmann::json& knot : reference["knots"]) {
    if (runs.empty() || runs.back().first != knot["contacts"])
      runs.push_back({knot["contacts"], 0});
    ++runs.back().second;
  }
  for (const auto& [feet, knots] : runs) {
    std::string names;
    for (const nlohmann::json& foot : feet)
      names += (names.empty() ? "" : ", ") + hyq_contact_name(foot);
    phases += fmt::format("  - {{knots: {}, dt: {}, contacts: [{}]}}\n", knots,
                          reference["dt"].get<double>(), names);
  }
  return fmt::format(R"(conddp: 1
name: hyq_trot
robot: {{urdf: hyq.urdf, base: floating}}
contacts:
  defaults: {{friction: 0.7, baumgarte: {{kp: 0, kd: 50}}}}
{0}initial_state: {{state: {1}}}
phases:
{2}costs:
  state: {{residual: state, reference: {1}, weight: 0.1, weights: {3}}}
  control: {{residual: control, weight: 1.0e-3}}
  com: {{residual: com_position, reference: {4}, weight: 100}}
  cone: {{residual: friction_cone, contacts: all, faces: 4, inner: false, weight: 10}}
{5}constraints:
  torque: {{bounds: control, from: urdf}}
terminal:
  costs:
    state: {{residual: state, reference: {1}, weight: 10, weights: {3}}}
    com: {{residual: com_position, reference: {4}, weight: 100}}
initial_guess: {{states: initial, controls: quasi_static}}
solver: {{name: box_fddp, tolerances: {{stationarity: 1.0e-9}}}}
)",
                     contacts, x0, phases, weights, reference["com_ref"].dump(), swings);
}

/// A squat of Talos, 38 degrees of freedom on two soles; its folder is that of talos_reduced.urdf.
inline std::string talos_squat_text() {
  std::string standing, squatting;
  for (const char* side : {"left", "right"}) {
    const double arm = side[0] == 'l' ? 1 : -1;
    standing += fmt::format(
        "leg_{0}_3_joint: -0.411354, leg_{0}_4_joint: 0.859395, leg_{0}_5_joint: -0.448041, "
        "arm_{0}_1_joint: {1}, arm_{0}_2_joint: {2}, arm_{0}_4_joint: -0.525366, ",
        side, 0.25847 * arm, 0.173046 * arm);
    squatting += fmt::format(
        "leg_{0}_3_joint: -0.8, leg_{0}_4_joint: 1.6, leg_{0}_5_joint: -0.8, "
        "arm_{0}_1_joint: {1}, arm_{0}_2_joint: {2}, arm_{0}_4_joint: -0.525366, ",
        side, 0.25847 * arm, 0.173046 * arm);
  }
  return fmt::format(R"(conddp: 1
name: talos_squat
robot:
  urdf: talos_reduced.urdf
  base: floating
  configurations:
    standing: {{joints: {{{0}}}}}
    squatting: {{joints: {{{1}}}}}
contacts:
  defaults: {{type: surface, size: [0.2, 0.1], friction: 0.7, baumgarte: {{kd: 50}}}}
  left: {{frame: left_sole_link}}
  right: {{frame: right_sole_link}}
initial_state: {{configuration: standing}}
phases:
  - {{knots: 50, dt: 0.02, contacts: all}}
costs:
  posture: {{residual: state, reference: squatting, weight: 1,
            weights: {{"base/x": 0, "base/y": 0, "base/z": 0, "base/r*": 10, "q/*": 1,
                      "base/v*": 0.1, "base/w*": 0.1, "v/*": 0.01}}}}
  effort: {{residual: control, weight: 1.0e-3}}
  com: {{residual: com_position, reference: initial, weight: 10}}
  cone: {{residual: wrench_cone, contacts: all, weight: 1}}
terminal:
  costs:
    posture: {{residual: state, reference: squatting, weight: 10,
              weights: {{"base/x": 0, "base/y": 0, "base/z": 0, "v/*": 0.1}}}}
initial_guess: {{states: initial, controls: quasi_static}}
solver: {{name: box_fddp}}
)",
                     standing, squatting);
}

}  // namespace conddp
