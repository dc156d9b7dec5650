#include "comparison_arguments.hpp"

#include <fmt/format.h>

#include "argument_checks.hpp"

namespace conddp {

void add_comparison_tolerances(CLI::App& command, std::vector<std::string>& values) {
  std::vector<std::string> names;
  std::string list;
  for (const NamedTolerance& tolerance : kNamedTolerances) {
    names.emplace_back(tolerance.name);
    list += fmt::format("{}{} ({})", list.empty() ? "" : ", ", tolerance.name,
                        ComparisonTolerances().*tolerance.member);
  }
  command.add_option("--tolerance", values, "How far apart the same may be: " + list)
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false)
      ->check(named_number(names, 0, 1e300, "a number, at least 0"));
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
