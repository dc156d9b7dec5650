#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// The exit status and output of another program.
struct ProgramEnd {
  int exit_status = -1;  ///< −1: it could not be started, or a signal ended it
  std::string out, err;
};

/// Runs a program from the search path with arguments and a text on standard input, and waits for
/// it. If it cannot be started, `err` contains the reason. The text should be short: it is written
/// before any output is read.
ProgramEnd run_program(const std::vector<std::string>& words, std::string_view input = {});

}  // namespace conddp
