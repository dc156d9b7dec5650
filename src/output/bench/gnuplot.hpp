#pragma once

#include <string>

namespace conddp {

/// What gnuplot printed, or why there is nothing.
struct GnuplotResult {
  std::string output;
  std::string defect;  ///< a sentence, empty if it drew
};

/// Runs gnuplot (a Debian package, looked for on the PATH) on a script and collects what it prints
/// on stdout. Without gnuplot, or where the script fails, the result says so.
GnuplotResult run_gnuplot(const std::string& script);

}  // namespace conddp
