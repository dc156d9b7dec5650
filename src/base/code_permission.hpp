#pragma once

namespace conddp {

/// The command-line option that allows compiled code.
inline constexpr const char* kAllowCode = "--allow-code";

/// True if this process may run compiled code that problem files name. Such code has all rights of
/// the process, so a file cannot grant the permission; the user does. Initially false.
bool code_is_allowed();
/// Allows compiled code from now on, for the whole process and all its threads.
void allow_code();

}  // namespace conddp
