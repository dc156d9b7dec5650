// Prints rigid-body kernel values of a robot in given states as JSON; scripts/foreign_robots
// compares them with an independent library.
//
// usage: robot_values < REQUEST
//   {"urdf": FILE, "base": "fixed" | "floating", "locked_joints": {NAME: VALUE},
//    "states": [{"q": [...], "v": [...], "a": [...]}, ...]}
//
// The answer is {"joints": [NAME], "nq", "nv", "mass",
//   "values": [{"M", "bias", "tau", "tau_q", "tau_v"}]}
// with column-major matrices (the lower triangle of M), or {"errors": [{"message", "hint"}]}.

#include <iostream>

#include <nlohmann/json.hpp>

#include "robot/dynamics.hpp"
#include "robot/urdf/urdf.hpp"

namespace {

using namespace conddp;
using nlohmann::json;

json values_in(const RobotModel& model, const json& state) {
  const std::vector<double> q = state.at("q"), v = state.at("v"), a = state.at("a");
  RobotData<double> data(model);
  inverse_dynamics(model, q.data(), v.data(), a.data(), data);
  json values;
  values["tau"] = data.tau;
  update_derivative_columns(model, data);
  mass_matrix(model, data);
  values["M"] = data.M;
  bias_forces(model, v.data(), data);
  values["bias"] = data.bias;
  std::copy(a.begin(), a.end(), data.acceleration.begin());
  inverse_dynamics_derivatives(model, v.data(), data);
  values["tau_q"] = data.tau_q;
  values["tau_v"] = data.tau_v;
  return values;
}

json answer(const json& request) {
  UrdfOptions options;
  options.base =
      request.at("base") == "floating" ? UrdfOptions::Base::floating : UrdfOptions::Base::fixed;
  options.locked_joints = request.value("locked_joints", std::map<std::string, double>{});
  const UrdfResult result = load_urdf(request.at("urdf").get<std::string>(), options);
  json answer;
  if (!result.model) {
    for (const UrdfProblem& problem : result.problems)
      if (!problem.warning)
        answer["errors"].push_back({{"message", problem.message}, {"hint", problem.hint}});
    return answer;
  }
  const RobotModel& model = *result.model;
  for (const UrdfProblem& problem : result.problems) answer["warnings"].push_back(problem.message);
  for (const Joint& joint : model.joints) answer["joints"].push_back(joint.name);
  answer["nq"] = model.nq;
  answer["nv"] = model.nv;
  answer["mass"] = model.total_mass();
  answer["values"] = json::array();
  for (const json& state : request.at("states"))
    answer["values"].push_back(values_in(model, state));
  return answer;
}

}  // namespace

int main() {
  std::cout << answer(json::parse(std::cin)).dump() << '\n';
  return 0;
}
