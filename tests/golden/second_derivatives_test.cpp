// Exact Hessians of the example problems: partwise, compared with dual numbers through everything.
#include "support/second_derivatives.hpp"

#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// A random trajectory near the guess.
Trajectory perturbed(const ShootingProblem& problem, const Trajectory& guess,
                     RandomNumbers& random) {
  Trajectory t = guess;
  std::vector<double> step(problem.ndx());
  for (int k = 0; k <= problem.knots(); ++k) {
    for (double& d : step) d = random.uniform(-0.1, 0.1);
    problem.manifold().integrate(t.x(k).data(), step.data(), t.x(k).data());
    if (k == problem.knots()) break;
    for (double& u : t.u(k)) u += random.uniform(-1, 1);
  }
  return t;
}

TEST(SecondDerivatives, MatchDualNumbersOnExampleProblems) {
  int known = 0;
  for (const auto& entry : fs::directory_iterator(source_tree() / "problems")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().stem().string());
    Diagnostics out;
    const auto spec = read_problem(entry.path(), {}, out);
    const auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
    ASSERT_TRUE(built) << format_diagnostics(out, false);
    const ShootingProblem& problem = *built->problem;
    const bool by_parts = known_by_parts(*problem.knot(0).model);
    known += by_parts;
    const std::string name = entry.path().stem().string();
    if (name.starts_with("quadruped_trot") || name == "push_box" || name == "quadruped_hop") {
      EXPECT_TRUE(by_parts) << name;
    }
    RandomNumbers random(23);
    Augmentation augmentation(problem);
    augmentation.penalty.setConstant(3);
    augmentation.multiplier.setConstant(0.4);
    expect_hessians_of_dual_numbers(problem, perturbed(problem, built->guess, random), augmentation,
                                    random);
    if (HasFatalFailure()) return;
  }
  EXPECT_GE(known, 12);
}

}  // namespace
}  // namespace conddp
