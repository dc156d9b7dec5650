#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "nlp/ipopt_options.hpp"

namespace conddp {

/// The functions of ipopt_options.hpp, by the table of options that Ipopt itself keeps.
const std::vector<std::string>& registered_option_names();
bool is_registered_integer(std::string_view name);
std::optional<IpoptOptionFault> check_registered_option(std::string_view name,
                                                        const IpoptValue& value);

}  // namespace conddp
