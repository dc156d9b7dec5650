#pragma once

namespace conddp {

/// What the process returns; after a signal it is 128 + the signal's number.
enum ExitCode : int {
  kExitConverged = 0,     ///< solved, or what was asked for holds
  kExitNotConverged = 1,  ///< ended otherwise; outputs are written all the same
  kExitBadInput = 2,      ///< wrong usage, wrong files, or outputs that cannot be written
  kExitDefect = 3,        ///< a mistake in conddp itself
  kExitSignalBase = 128,  ///< + 2 after Ctrl-C, + 15 after SIGTERM
};

}  // namespace conddp
