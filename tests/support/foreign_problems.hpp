#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/robots.hpp"
#include "support/source_tree.hpp"

// Problems of robots from outside the product: the files of tests/foreign.

namespace conddp {

/// Input of read_problem: the file, and the setting for the path of its robot.
struct ForeignProblem {
  std::filesystem::path file;
  std::vector<std::string> settings;
};

/// tests/foreign/NAME.yaml with the robot of that URDF file; nullopt if the robot is absent.
inline std::optional<ForeignProblem> foreign_problem(const std::string& name,
                                                     const std::string& urdf) {
  const auto robot = foreign_robot_folder() / urdf;
  if (!std::filesystem::exists(robot)) return std::nullopt;
  const auto folder = source_tree() / "tests/foreign";
  return ForeignProblem{folder / (name + ".yaml"), {"robot.urdf=" + robot.string()}};
}

/// The HyQ trot solved by Crocoddyl and Pinocchio: two diagonal swings in place.
inline std::optional<ForeignProblem> hyq_trot() { return foreign_problem("hyq_trot", "hyq.urdf"); }

/// Their reference figures at the first guess and at the optimum; nullopt if absent.
inline std::optional<nlohmann::json> hyq_trot_reference() {
  std::ifstream figures(foreign_robot_folder().parent_path() / "reference/hyq_trot.json");
  if (!figures) return std::nullopt;
  return nlohmann::json::parse(figures);
}

/// A squat of Talos, 38 degrees of freedom on two soles.
inline std::optional<ForeignProblem> talos_squat() {
  return foreign_problem("talos_squat", "talos_reduced.urdf");
}

}  // namespace conddp
