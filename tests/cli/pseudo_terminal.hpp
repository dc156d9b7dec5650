#pragma once

#include <string>
#include <vector>

#include "process.hpp"

namespace conddp {

struct TerminalOptions {
  int columns = 80;
  std::vector<std::string> environment;  ///< NAME=value, added to ours
  bool out = true;                       ///< stdout is a terminal, else a pipe
  bool err = true;                       ///< likewise
  std::string typed;                     ///< sent to the terminal once `type_after` has appeared
  std::string type_after;                ///< on stderr
};

/// Runs the tool in a session of its own, its controlling terminal `columns` wide, stdout and
/// stderr on terminals of their own so that they can be told apart. Nothing is translated on the
/// way: a line ends in '\n'.
ProcessResult run_in_terminal(const std::vector<std::string>& arguments,
                              const TerminalOptions& options = {});

}  // namespace conddp
