#pragma once

#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "output/report/report.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {

/// Entry of a list with this name.
inline const OrderedJson& named(const OrderedJson& list, const std::string& name) {
  for (const OrderedJson& entry : list)
    if (entry["name"] == name) return entry;
  throw std::out_of_range(name + " is not in the list");
}

/// An example problem with its answer after one iteration.
class Report : public testing::Test {
 protected:
  void load(const std::string& name, const std::vector<std::string>& settings = {},
            const std::vector<std::string>& left_out = {}) {
    Diagnostics out;
    spec_ = read_problem(source_tree() / "problems" / name, settings, out);
    ASSERT_TRUE(spec_) << format_diagnostics(out, false);
    built_ = build_problem(*spec_, {.drop = left_out}, out);
    ASSERT_TRUE(built_) << format_diagnostics(out, false);
    const char* solver = !spec_->candidates.empty()               ? "ipopt"
                         : built_->problem->constraints().empty() ? "box_fddp"
                                                                  : "altro";
    result_ = std::make_unique<SolveResult>(
        solve(*built_->problem, solver, {.max_iterations = 1}, built_->guess));
    document_ = solution_json({*built_, *find_solver(solver), *result_, {}});
  }
  ReportEntry entry() const {
    return {.label = "answer", .document = document_, .built = &*built_};
  }

  std::optional<ProblemSpec> spec_;
  std::optional<BuiltProblem> built_;
  std::unique_ptr<SolveResult> result_;
  OrderedJson document_;
};

}  // namespace conddp
