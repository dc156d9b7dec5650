#pragma once

#include <map>
#include <string>

#include "problem_file/assemble/build_problem.hpp"

namespace conddp {

/// Counts how often each possible part occurred in a solved problem.
class Coverage {
 public:
  /// Every part, from the tables of the reader and the registry of solvers.
  explicit Coverage(const std::vector<std::string>& bodies);
  void add(const std::string& body, const BuiltProblem& built, const SolverInfo& used);
  /// Parts that never occurred, one a line.
  std::string missing() const;

 private:
  void count(const std::string& kind, std::string_view name);
  std::map<std::string, int> counts_;
};

}  // namespace conddp
