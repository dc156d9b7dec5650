#include "messages.hpp"

#include <cstdio>

#include "terminal.hpp"

namespace conddp {

void print_messages(const Diagnostics& diagnostics, Verbosity verbosity) {
  const Severity least = verbosity == Verbosity::kQuiet    ? Severity::kError
                         : verbosity == Verbosity::kNormal ? Severity::kWarning
                                                           : Severity::kNote;
  std::fputs(format_diagnostics(diagnostics, terminal_of(2).colour, least).c_str(), stderr);
}

}  // namespace conddp
