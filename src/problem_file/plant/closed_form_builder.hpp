#pragma once

#include <memory>

#include "problem_file/model/spec.hpp"
#include "systems/system.hpp"

namespace conddp {

/// A closed-form system or a system of expressions. Null with an error if the phases do not fit it
/// (a system with its own step).
std::shared_ptr<const System> make_system(const SystemSpec& system, const ProblemSpec& spec,
                                          Diagnostics& out);

}  // namespace conddp
