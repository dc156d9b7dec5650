#pragma once

#include "problem_file/spec/spec_robot.hpp"
#include "problem_file/values/key_forms.hpp"

namespace conddp {

/// The keys of a closed-form system. Keys of expressions and of libraries depend on each other:
/// these have readers of their own.
void describe(Keys& keys, SystemSpec& system);

/// A system of the type with this index in kSystemTypes, with the type's default parameters.
SystemSpec default_system(std::size_t type);

}  // namespace conddp
