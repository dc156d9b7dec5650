#include <algorithm>
#include <functional>

#include <fmt/format.h>

#include "base/json/ordered_json.hpp"
#include "base/text/text_layout.hpp"
#include "summary/summary.hpp"

namespace conddp {
namespace {

OrderedJson sigmas_json(const Eigen::VectorXd& sigma) {
  return std::vector<double>(sigma.begin(), sigma.end());
}

OrderedJson node_json(const Margin& margin, const std::vector<double>& times) {
  return {{"knot", margin.knot},         {"time_s", times[margin.knot]},
          {"distance", margin.distance}, {"sigma", margin.sigma},
          {"margin", margin.steps()},    {"probability", margin.probability()}};
}

OrderedJson curve_json(const MarginCurve& curve, const std::vector<double>& times) {
  OrderedJson nodes = OrderedJson::array();
  for (const Margin& margin : curve.nodes) nodes.push_back(node_json(margin, times));
  return {{"name", curve.name},
          {"row", curve.row < 0 ? OrderedJson(nullptr) : OrderedJson(curve.row + 1)},
          {"side", curve.upper ? "upper" : "lower"},
          {"smallest", node_json(curve.smallest(), times)},
          {"nodes", std::move(nodes)}};
}

std::string name_of(const OrderedJson& curve) {
  const std::string name = curve["name"];
  return curve["row"].is_null() ? name : fmt::format("{} row {}", name, curve["row"].get<int>());
}

/// Standard deviations of the coordinates with noise: "theta 0.01, omega 0.02"; "0.01 each" if
/// several coordinates all have the same; "none".
std::string noise_text(const OrderedJson& sigmas, const OrderedJson& columns) {
  const auto differ = std::adjacent_find(sigmas.begin(), sigmas.end(), std::not_equal_to<>());
  if (sigmas.size() > 1 && differ == sigmas.end() && sigmas[0] != 0)
    return fmt::format("{:g} each", sigmas[0].get<double>());
  std::string text;
  for (std::size_t i = 0; i < sigmas.size(); ++i)
    if (sigmas[i] != 0)
      text += fmt::format("{}{} {:g}", text.empty() ? "" : ", ", columns[i].get<std::string>(),
                          sigmas[i].get<double>());
  return text.empty() ? "none" : text;
}

}  // namespace

OrderedJson margins_json(const std::vector<MarginCurve>& curves, const StateNoise& noise,
                         const BuiltProblem& built, const Trajectory& trajectory) {
  const std::vector<double> times = built.problem->times(trajectory);
  OrderedJson bounds = OrderedJson::array();
  for (const MarginCurve& curve : curves) bounds.push_back(curve_json(curve, times));
  return {{"format", "conddp.margins/1"},
          {"problem", built.facts().file.string()},
          {"name", built.facts().name.value},
          {"columns", tangent_columns(built)},
          {"initial", sigmas_json(noise.initial)},
          {"process", sigmas_json(noise.process)},
          {"measurement", sigmas_json(noise.measurement)},
          {"bounds", std::move(bounds)}};
}

std::string margins_text(const OrderedJson& margins) {
  std::string text = margins["name"].get<std::string>() + '\n';
  for (const char* key : {"initial", "process", "measurement"})
    text += fmt::format("  {:<12}{}\n", key, noise_text(margins[key], margins["columns"]));
  if (margins["bounds"].empty()) return text + "  noise moves no quantity that has a bound\n";
  TextTable table{.columns = {{"bound", false},
                              {"side", false},
                              {"smallest margin"},
                              {"probability"},
                              {"distance"},
                              {"sigma"},
                              {"time, s"},
                              {"knot"}},
                  .rows = {}};
  for (const auto& curve : margins["bounds"]) {
    const auto& at = curve["smallest"];
    table.rows.push_back({name_of(curve), curve["side"],
                          fmt::format("{:.4g}", at["margin"].get<double>()),
                          fmt::format("{:.3g}", at["probability"].get<double>()),
                          fmt::format("{:.4g}", at["distance"].get<double>()),
                          fmt::format("{:.4g}", at["sigma"].get<double>()),
                          fmt::format("{:.4g}", at["time_s"].get<double>()),
                          fmt::format("{}", at["knot"].get<int>())});
  }
  return text + table.text(2);
}

}  // namespace conddp
