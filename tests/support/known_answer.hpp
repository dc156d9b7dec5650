#pragma once

#include <filesystem>

#include <gtest/gtest.h>

#include "output/solution/golden_case.hpp"

namespace conddp::testing {

/// Solves the problem of a golden case again and returns the answer.
inline nlohmann::json solve_again(const GoldenCase& golden) {
  Diagnostics diagnostics;
  const auto outcome = solve_golden(golden, {}, diagnostics);
  EXPECT_TRUE(outcome) << format_diagnostics(diagnostics, false);
  return outcome ? outcome->answer : nlohmann::json();
}

/// Expects that the problem of a golden file still has its answer, and returns it.
inline nlohmann::json expect_known_answer(const std::filesystem::path& file) {
  Diagnostics diagnostics;
  const auto golden = load_golden(file, diagnostics);
  EXPECT_TRUE(golden) << format_diagnostics(diagnostics, false);
  if (!golden) return {};
  nlohmann::json actual = solve_again(*golden);
  EXPECT_EQ(actual.at("status"), "converged") << actual.at("message");
  for (const Difference& d : compare_solutions(golden->answer, actual, golden->tolerances))
    ADD_FAILURE() << golden->name << ": " << d.quantity << ": " << d.message;
  return actual;
}

}  // namespace conddp::testing
