#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// What another program left behind.
struct ProgramEnd {
  int exit_status = -1;  ///< −1: it could not be started, or a signal ended it
  std::string out, err;
};

/// Runs a program of the search path with arguments and a text on its standard input, and waits
/// for it. Where it cannot be started, `err` says why. The text should be short: it is written
/// before anything is read.
ProgramEnd run_program(const std::vector<std::string>& words, std::string_view input = {});

}  // namespace conddp
