#include "argument_checks.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "base/spelling.hpp"
#include "base/strict_number.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

CLI::Validator not_empty() {
  return {[](const std::string& argument) {
            return argument.empty() ? std::string("the value is empty") : std::string();
          },
          "TEXT", "not empty"};
}

CLI::Validator solver_name() {
  std::vector<std::string> names{std::string(kAutoSolver)};
  for (const SolverInfo& info : solvers()) names.emplace_back(info.name);
  return CLI::IsMember(std::move(names));
}

CLI::Validator number_between(double lower, double upper, const std::string& words) {
  return {[=](const std::string& argument) {
            const ParsedNumber number = parse_number(argument);
            if (!number.value) return fmt::format("{}; accepted: {}", number.defect, words);
            if (*number.value >= lower && *number.value <= upper) return std::string();
            return fmt::format("'{}' is out of range; accepted: {}", argument, words);
          },
          words, "number"};
}

CLI::Validator named_number(const std::vector<std::string>& names, double lower, double upper,
                            const std::string& words) {
  return {[=](const std::string& argument) {
            const std::size_t equals = argument.find('=');
            const std::string name = argument.substr(0, equals);
            if (std::find(names.begin(), names.end(), name) == names.end())
              return fmt::format("there is no '{}' here: {}", name,
                                 name_hint(name, names, "accepted names"));
            if (equals == std::string::npos)
              return fmt::format("'{}' has no value: write {}=NUMBER", argument, name);
            const ParsedNumber number = parse_number(argument.substr(equals + 1));
            if (!number.value) return fmt::format("{}; accepted: {}", number.defect, words);
            if (*number.value >= lower && *number.value <= upper) return std::string();
            return fmt::format("'{}' is out of range; accepted: {}", argument, words);
          },
          words, "named number"};
}

CLI::Validator perturbation() {
  return named_number({"initial_state", "guess"}, 0, kLargestSpread, "a number, 0 to 1e6");
}

CLI::Validator perturbation_seed() { return CLI::Range(0LL, kLargestSeed); }

std::map<std::string, double> named_numbers(const std::vector<std::string>& arguments) {
  std::map<std::string, double> values;
  for (const std::string& argument : arguments) {
    const std::size_t equals = argument.find('=');
    values[argument.substr(0, equals)] = parse_number(argument.substr(equals + 1)).value.value();
  }
  return values;
}

}  // namespace conddp
