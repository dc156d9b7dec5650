#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nlp/ipopt_options.hpp"

namespace conddp {

/// Functions of ipopt_options.hpp, based on Ipopt's own table of options.
const std::vector<std::string>& registered_option_names();
bool is_registered_integer(std::string_view name);
std::optional<IpoptOptionFault> check_registered_option(std::string_view name,
                                                        const IpoptValue& value);

}  // namespace conddp
