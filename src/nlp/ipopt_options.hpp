#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace conddp {

/// Ipopt's options by their own names, in the order given.
using IpoptValue = std::variant<int, double, std::string>;
using IpoptOptions = std::vector<std::pair<std::string, IpoptValue>>;

/// Number in a value; empty if the value is text.
inline std::optional<double> number_in(const IpoptValue& value) {
  if (const int* number = std::get_if<int>(&value)) return *number;
  if (const double* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

/// Names of all options that a caller may set, in alphabetical order.
const std::vector<std::string>& ipopt_option_names();

/// Reason to reject an option: a name unknown to Ipopt, an option that the caller sets by other
/// means, or a value of the wrong type or out of range.
struct IpoptOptionFault {
  enum class Kind { unknown, reserved, value } kind;
  std::string message;
};
/// True if a known option takes whole numbers.
bool is_integer_option(std::string_view name);

std::optional<IpoptOptionFault> check_ipopt_option(std::string_view name, const IpoptValue& value);

/// First option that this Ipopt cannot use together with those before it, such as a linear solver
/// missing from its build or a combination of methods. Each option passes check_ipopt_option().
std::optional<std::size_t> first_unusable_ipopt_option(const IpoptOptions& options);

}  // namespace conddp
