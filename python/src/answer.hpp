#pragma once

#include <memory>
#include <string>
#include <vector>

#include "batch/session/kept_problem.hpp"

namespace conddp::python {

/// An answer as Python sees it.
struct Answer : KeptAnswer {
  std::string status() const { return std::string(to_string(result.status)); }
  std::string solver_name() const { return std::string(solver->name); }
  /// "" without a certificate.
  std::string verdict() const;
  /// True if the solve ended well and its certificate does not deny it.
  bool solved() const;
  /// Times of all nodes, s.
  std::vector<double> times() const { return task.built.problem->times(result.trajectory); }
  /// JSON texts of the columns, of solution.json, of its certificate (or null).
  std::string names() const;
  std::string document_text() const { return document().dump(); }
  std::string certificate_text() const;
  /// The page of the report. Throws std::runtime_error if this build lacks it.
  std::string page() const;
  /// Writes the files of `conddp solve` in these forms into a folder; returns their paths.
  std::vector<std::string> write(const std::string& folder, bool with_page,
                                 const std::string& formats) const;
};

}  // namespace conddp::python
