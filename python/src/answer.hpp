#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"
#include "output/solution/grid_solve.hpp"
#include "output/solution/solution.hpp"

namespace conddp::python {

/// An answer with its problem. It does not change any more, and may be shared by threads.
struct Answer {
  SolveTask task;  ///< on the grid of the answer
  const SolverInfo* solver;
  SolveResult result;
  std::vector<std::string> settings;
  std::vector<MeshRound> mesh;
  std::optional<SolutionCertificate> certificate;

  Solution solution() const;
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
  std::string document() const;
  std::string certificate_text() const;
  /// The page of the report. Throws std::runtime_error if this build lacks it.
  std::string page() const;
  /// Writes the files of `conddp solve` into a folder; returns their paths.
  std::vector<std::string> write(const std::string& folder, bool with_page) const;
};

}  // namespace conddp::python
