#include "output/report/answer_settings.hpp"

#include <utility>

#include <fmt/format.h>

#include "output/solution/solved_problem.hpp"
#include "solvers/common/option_table.hpp"

namespace conddp {
namespace {

constexpr std::string_view kTolerances = "tolerances.";

/// Names and values of tolerances above their defaults.
std::vector<std::pair<std::string, double>> loose_tolerances(const SolverOptions& options) {
  std::vector<std::pair<std::string, double>> list;
  for (const OptionInfo& info : option_table()) {
    if (!info.name.starts_with(kTolerances)) continue;
    const double value = std::get<double>(info.get(options));
    if (value > std::get<double>(info.default_value()))
      list.emplace_back(info.name.substr(kTolerances.size()), value);
  }
  return list;
}

double default_tolerance(const std::string& name) {
  return std::get<double>(find_option(std::string(kTolerances) + name)->default_value());
}

}  // namespace

std::string loose_tolerances_line(const SolverOptions& options) {
  std::string line;
  for (const auto& [name, value] : loose_tolerances(options))
    line += fmt::format("{} {} {:g} (default {:g})",
                        line.empty() ? "tolerances beyond the defaults:" : ",", name, value,
                        default_tolerance(name));
  return line;
}

AnswerSettings answer_settings(const OrderedJson& document, const BuiltProblem& built) {
  AnswerSettings settings{.overrides = overrides_of(document),
                          .options = built.facts().solver.options};
  for (const DroppedConstraint& constraint : built.dropped)
    settings.dropped.push_back(constraint.name);
  return settings;
}

std::vector<std::string> settings_lines(const AnswerSettings& settings) {
  std::vector<std::string> lines;
  for (const std::string& setting : settings.overrides) lines.push_back("setting " + setting);
  for (const std::string& name : settings.dropped) lines.push_back("dropped " + name);
  if (std::string loose = loose_tolerances_line(settings.options); !loose.empty())
    lines.push_back(std::move(loose));
  return lines;
}

OrderedJson settings_json(const AnswerSettings& settings) {
  OrderedJson loose = OrderedJson::object();
  for (const auto& [name, value] : loose_tolerances(settings.options)) loose[name] = value;
  return {{"overrides", settings.overrides},
          {"dropped_constraints", settings.dropped},
          {"loose_tolerances", std::move(loose)}};
}

}  // namespace conddp
