#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace conddp {

/// Options of Ipopt by their own names, in the order given.
using IpoptValue = std::variant<int, double, std::string>;
using IpoptOptions = std::vector<std::pair<std::string, IpoptValue>>;

/// The number that a value is, if it is one.
inline std::optional<double> number_in(const IpoptValue& value) {
  if (const int* number = std::get_if<int>(&value)) return *number;
  if (const double* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

/// The names of all options that a caller may set, in alphabetical order.
const std::vector<std::string>& ipopt_option_names();

/// What is wrong with an option, if anything: a name that Ipopt does not know, one that the caller
/// sets by other means, a value of another type or out of range.
struct IpoptOptionFault {
  enum class Kind { unknown, reserved, value } kind;
  std::string message;
};
/// Whether the values of an option that Ipopt knows are whole numbers.
bool is_integer_option(std::string_view name);

std::optional<IpoptOptionFault> check_ipopt_option(std::string_view name, const IpoptValue& value);

/// The first option, each of which passes check_ipopt_option(), that this Ipopt cannot use together
/// with those before it: a linear solver that it was built without, a combination of methods.
std::optional<std::size_t> first_unusable_ipopt_option(const IpoptOptions& options);

}  // namespace conddp
