#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp::python {

/// Errors in a problem, with their places.
struct ProblemFailure : std::runtime_error {
  explicit ProblemFailure(const Diagnostics& found)
      : std::runtime_error("the problem has errors"),
        text(format_diagnostics(found, false, Severity::kError)) {
    for (const Diagnostic& d : found.list())
      if (d.severity == Severity::kError) errors.push_back(d);
  }

  std::string text;
  std::vector<Diagnostic> errors;
};

}  // namespace conddp::python
