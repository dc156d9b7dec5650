#pragma once

#include <memory>

#include "problem_file/spec/spec.hpp"
#include "systems/system.hpp"

namespace conddp {

/// A closed-form system, or one of expressions. Null where the phases do not fit it (a system with
/// a step of its own), which is reported.
std::shared_ptr<const System> make_system(const SystemSpec& system, const ProblemSpec& spec,
                                          Diagnostics& out);

}  // namespace conddp
