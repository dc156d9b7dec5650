#include "arguments/comparison_arguments.hpp"

#include <fmt/format.h>

#include "arguments/shared_arguments.hpp"

namespace conddp {

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
