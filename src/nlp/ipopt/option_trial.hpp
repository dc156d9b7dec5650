#pragma once

#include <cstddef>
#include <optional>

#include "nlp/ipopt_options.hpp"

namespace conddp {

/// First option that keeps this Ipopt from starting, together with those before it: its build, or
/// the libraries on this machine, do not support the option. Solves a program of two variables.
std::optional<std::size_t> first_unusable_option(const IpoptOptions& options);

}  // namespace conddp
