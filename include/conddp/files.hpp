// Problem files and solutions, of the component `files` (conddp::files).
//
//   Diagnostics messages;
//   const auto built = build_problem(
//       read_problem("problem.yaml", {"solver.max_iterations=50"}, messages), {}, messages);
//   std::fputs(format_diagnostics(messages, false).c_str(), stderr);
//   if (!built) return 2;
//
//   const SolverInfo* solver = nullptr;
//   const auto candidates = usable_solvers(*built, messages);
//   const SolveResult result =
//       solve(*built->problem, candidates, built->facts().solver.options, built->guess, solver);
//   const Solution solution{*built, *solver, result};
//   write_solution(solution, solution_json(solution), "out", "");
//
// What is wrong with a file is a diagnostic with file, line, column and what would be accepted,
// never an exception. Of the files of one answer all are written or, with an OutputError, none.
#pragma once

#include "base/files/atomic_file.hpp"
#include "base/text/diagnostic.hpp"
#include "conddp/conddp.hpp"
#include "output/solution/solution.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
