#include "comparison_arguments.hpp"

#include <fmt/format.h>

#include "argument_checks.hpp"

namespace conddp {
namespace {

struct NamedTolerance {
  const char* name;
  double ComparisonTolerances::*member;
};

constexpr NamedTolerance kTolerances[] = {
    {"cost_relative", &ComparisonTolerances::cost_relative},
    {"residual_factor", &ComparisonTolerances::residual_factor},
    {"residual_floor", &ComparisonTolerances::residual_floor},
    {"trajectory_absolute", &ComparisonTolerances::trajectory_absolute},
    {"trajectory_relative", &ComparisonTolerances::trajectory_relative},
    {"rotation", &ComparisonTolerances::rotation},
};

}  // namespace

void add_comparison_tolerances(CLI::App& command, std::vector<std::string>& values) {
  std::vector<std::string> names;
  std::string list;
  for (const NamedTolerance& tolerance : kTolerances) {
    names.emplace_back(tolerance.name);
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", tolerance.name,
                        ComparisonTolerances().*tolerance.member);
  }
  command.add_option("--tolerance", values, "How far apart the same may be: " + list)
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false)
      ->check(named_number(names, 0, 1e300, "a number, at least 0"));
}

ComparisonTolerances comparison_tolerances(const std::vector<std::string>& values) {
  ComparisonTolerances tolerances;
  for (const auto& [name, value] : named_numbers(values))
    for (const NamedTolerance& tolerance : kTolerances)
      if (name == tolerance.name) tolerances.*tolerance.member = value;
  return tolerances;
}

std::string difference_text(const Difference& difference) {
  return fmt::format("  {}: {}\n", difference.quantity, difference.message);
}

}  // namespace conddp
