#include "nlp/ipopt_options.hpp"

#include "nlp/ipopt_library.hpp"

namespace conddp {

const std::vector<std::string>& ipopt_option_names() { return ipopt_library().option_names(); }

bool is_integer_option(std::string_view name) { return ipopt_library().is_integer_option(name); }

std::optional<IpoptOptionFault> check_ipopt_option(std::string_view name, const IpoptValue& value) {
  return ipopt_library().check_option(name, value);
}

std::optional<std::size_t> first_unusable_ipopt_option(const IpoptOptions& options) {
  return ipopt_library().first_unusable(options);
}

}  // namespace conddp
