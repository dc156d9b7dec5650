#pragma once

#include <string>
#include <vector>

#include "process.hpp"

namespace conddp {

struct TerminalOptions {
  int columns = 80;
  std::vector<std::string> environment;  ///< NAME=value, added to the current environment
  bool out = true;                       ///< true: stdout is a terminal; false: a pipe
  bool err = true;                       ///< likewise for stderr
  std::string typed;                     ///< sent to the terminal once `type_after` has appeared
  std::string type_after;                ///< on stderr
};

/// Runs the tool in its own session with a controlling terminal of `columns` columns. stdout and
/// stderr are separate terminals so that they can be distinguished. Output is not translated: a
/// line ends in '
/// '.
ProcessResult run_in_terminal(const std::vector<std::string>& arguments,
                              const TerminalOptions& options = {});

}  // namespace conddp
