#pragma once

#include <cstddef>
#include <optional>

#include "nlp/ipopt_options.hpp"

namespace conddp {

/// The first option with which this Ipopt does not start, in the company of those before it: what
/// it was built with, or finds on this machine, does not support it. Solves a program of two
/// variables.
std::optional<std::size_t> first_unusable_option(const IpoptOptions& options);

}  // namespace conddp
