#pragma once

#include <string_view>

namespace conddp {

/// Exit codes of the process; after a signal, 128 + the signal's number.
enum ExitCode : int {
  kExitConverged = 0,
  kExitNotConverged = 1,
  kExitBadInput = 2,
  kExitDefect = 3,
  kExitSignalBase = 128,
};

/// Explanation of an exit code for users.
struct ExitCodeInfo {
  int code;
  std::string_view meaning;
};
inline constexpr ExitCodeInfo kExitCodes[] = {
    {kExitConverged, "solved, or the requested check passed"},
    {kExitNotConverged, "ended otherwise; outputs are written anyway"},
    {kExitBadInput, "wrong usage, wrong files, or outputs that cannot be written"},
    {kExitDefect, "a defect of conddp itself"},
    {kExitSignalBase + 2, "ended by Ctrl-C; 'solve' writes the best iterate"},
    {kExitSignalBase + 15, "ended by SIGTERM; likewise"},
};

}  // namespace conddp
