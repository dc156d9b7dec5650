#include "nlp/ipopt_options.hpp"

#include "nlp/ipopt_library.hpp"

namespace conddp {

std::optional<double> number_in(const IpoptValue& value) {
  if (const int* number = std::get_if<int>(&value)) return *number;
  if (const double* number = std::get_if<double>(&value)) return *number;
  return std::nullopt;
}

const std::vector<std::string>& ipopt_option_names() { return ipopt_library().option_names(); }

bool is_integer_option(std::string_view name) { return ipopt_library().is_integer_option(name); }

std::optional<IpoptOptionFault> check_ipopt_option(std::string_view name, const IpoptValue& value) {
  return ipopt_library().check_option(name, value);
}

}  // namespace conddp
