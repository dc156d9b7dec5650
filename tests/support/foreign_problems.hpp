#pragma once

#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "support/robots.hpp"

// Problems of robots that are not part of the product: the files of tests/foreign.

namespace conddp {

/// What read_problem takes: the file, and the setting that says where its robot is.
struct ForeignProblem {
  std::filesystem::path file;
  std::vector<std::string> settings;
};

/// tests/foreign/NAME.yaml with the robot of that URDF file; none where the robot is absent.
inline std::optional<ForeignProblem> foreign_problem(const std::string& name,
                                                     const std::string& urdf) {
  const auto robot = foreign_robot_folder() / urdf;
  if (!std::filesystem::exists(robot)) return std::nullopt;
  const auto folder = std::filesystem::path(CONDDP_SOURCE_DIR) / "tests/foreign";
  return ForeignProblem{folder / (name + ".yaml"), {"robot.urdf=" + robot.string()}};
}

/// The trot of HyQ that Crocoddyl and Pinocchio solved: two diagonal swings on the spot.
inline std::optional<ForeignProblem> hyq_trot() { return foreign_problem("hyq_trot", "hyq.urdf"); }

/// What they found for it: figures at the first guess and at the optimum. None where it is absent.
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
