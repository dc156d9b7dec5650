#pragma once

#include <string>

namespace conddp {

/// The output of gnuplot, or the reason for its absence.
struct GnuplotResult {
  std::string output;
  std::string defect;  ///< a sentence, empty on success
};

/// Runs gnuplot (a Debian package, searched on the PATH) on a script and collects its stdout. The
/// result reports a missing gnuplot or a failed script.
GnuplotResult run_gnuplot(const std::string& script);

}  // namespace conddp
