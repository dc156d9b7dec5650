#pragma once

namespace conddp {

/// The option of the tool that allows it.
inline constexpr const char* kAllowCode = "--allow-code";

/// Whether this process may run compiled code that problem files name. Such code has all rights of
/// the process, so that a file cannot permit it itself: a person does. Off at the beginning.
bool code_is_allowed();
/// From now on, for the whole process and all its threads.
void allow_code();

}  // namespace conddp
