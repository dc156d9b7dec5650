#include "arguments/shared_arguments.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "base/text/spelling.hpp"
#include "base/text/strict_number.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

struct Interval {
  double lower;
  double upper;
  std::string words;
};

/// The defect of a number; `argument` is its text on the command line.
std::string number_defect(const std::string& number, const std::string& argument,
                          const Interval& accepted) {
  const ParsedNumber parsed = parse_number(number);
  if (!parsed.value) return fmt::format("{}; accepted: {}", parsed.defect, accepted.words);
  if (*parsed.value >= accepted.lower && *parsed.value <= accepted.upper) return {};
  return fmt::format("'{}' is out of range; accepted: {}", argument, accepted.words);
}

}  // namespace

Argument solver_argument(std::string& solver, std::string description) {
  std::vector<std::string> names{std::string(kAutoSolver)};
  for (const SolverInfo& info : solvers()) names.emplace_back(info.name);
  return {.names = {"--solver"},
          .value = "NAME",
          .description = std::move(description),
          .choices = std::move(names),
          .target = &solver};
}

Argument problem_of_solution(std::string& file, std::string description) {
  return {.names = {"--problem"},
          .value = "FILE.yaml",
          .description = std::move(description),
          .target = &file};
}

Argument drop_argument(std::vector<std::string>& names, std::string description) {
  return {.names = {"--drop"},
          .value = "NAME",
          .description = std::move(description),
          .target = &names};
}

Argument setting_argument(std::vector<std::string>& settings, std::string description) {
  return {.names = {"--set"},
          .value = "KEY=VALUE",
          .description = std::move(description),
          .target = &settings};
}

Argument max_time_argument(double& seconds, std::string description) {
  return {.names = {"--max-time"},
          .value = "SECONDS",
          .description = std::move(description),
          .check =
              [](const std::string& value) {
                return number_defect(value, value, {1e-3, 1e9, "0.001 to 1e9 s"});
              },
          .target = &seconds};
}

Argument threads_argument(int& threads, std::string description) {
  return {.names = {"--threads"},
          .value = "N",
          .description = std::move(description),
          .numbers = WholeNumbers{1, 1024},
          .target = &threads};
}

std::vector<std::string> solve_settings(double max_time, int threads) {
  std::vector<std::string> settings;
  if (max_time > 0) settings.push_back(fmt::format("solver.max_time_s={}", max_time));
  if (threads > 0) settings.push_back(fmt::format("solver.threads={}", threads));
  return settings;
}

Argument perturbation_argument(std::vector<std::string>& values, std::string description) {
  return {
      .names = {"--perturb"},
      .value = "NAME=NUMBER",
      .description = std::move(description),
      .check = named_number({"initial_state", "guess"}, 0, kLargestSpread, "a number, 0 to 1e6"),
      .target = &values};
}

Argument seed_argument(std::uint64_t& seed, std::string description) {
  return {.names = {"--seed"},
          .value = "N",
          .description = std::move(description),
          .numbers = WholeNumbers{0, kLargestSeed},
          .fallback = std::to_string(seed),
          .needs = "--perturb",
          .target = &seed};
}

std::vector<Argument> joined(std::vector<Argument> first, std::vector<Argument> second) {
  first.insert(first.end(), std::make_move_iterator(second.begin()),
               std::make_move_iterator(second.end()));
  return first;
}

ArgumentCheck named_number(std::vector<std::string> names, double lower, double upper,
                           std::string words) {
  return [names = std::move(names),
          accepted = Interval{lower, upper, std::move(words)}](const std::string& argument) {
    const std::size_t equals = argument.find('=');
    const std::string name = argument.substr(0, equals);
    if (std::find(names.begin(), names.end(), name) == names.end())
      return fmt::format("there is no '{}' here: {}", name,
                         name_hint(name, names, "accepted names"));
    if (equals == std::string::npos)
      return fmt::format("'{}' has no value: write {}=NUMBER", argument, name);
    return number_defect(argument.substr(equals + 1), argument, accepted);
  };
}

std::map<std::string, double> named_numbers(const std::vector<std::string>& arguments) {
  std::map<std::string, double> values;
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    values[argument.substr(0, equals)] = parse_number(argument.substr(equals + 1)).value.value();
  }
  return values;
}

Argument comparison_tolerance_argument(std::vector<std::string>& values) {
  std::vector<std::string> names;
  std::string list;
  for (const NamedTolerance& tolerance : kNamedTolerances) {
    names.emplace_back(tolerance.name);
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", tolerance.name,
                        ComparisonTolerances().*tolerance.member);
  }
  return {.names = {"--tolerance"},
          .value = "NAME=NUMBER",
          .description = "Tolerance of the comparison: " + list,
          .check = named_number(std::move(names), 0, 1e300, "a number, at least 0"),
          .target = &values};
}

ComparisonTolerances comparison_tolerances(const std::vector<std::string>& values,
                                           ComparisonTolerances tolerances) {
  for (const auto& [name, value] : named_numbers(values))
    for (const NamedTolerance& tolerance : kNamedTolerances)
      if (name == tolerance.name) tolerances.*tolerance.member = value;
  return tolerances;
}

std::string difference_text(const Difference& difference) {
  return fmt::format("  {}: {}\n", difference.quantity, difference.message);
}

}  // namespace conddp
