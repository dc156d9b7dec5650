#include "argument_checks.hpp"

#include <fmt/format.h>

#include "problem_file/strict_number.hpp"

namespace conddp {

CLI::Validator not_empty() {
  return {[](const std::string& argument) {
            return argument.empty() ? std::string("the value is empty") : std::string();
          },
          "TEXT", "not empty"};
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

}  // namespace conddp
