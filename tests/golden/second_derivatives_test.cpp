// Exact Hessians of the ready problems: by parts, and by dual numbers through everything.
#include <gtest/gtest.h>

#include "ocp/acts.hpp"
#include "ocp/knot_second_derivatives.hpp"
#include "problem_file/build.hpp"
#include "problem_file/read_problem.hpp"
#include "support/random_numbers.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Around the guess.
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

/// Whether a running node is known by parts.
bool known_by_parts(const ShootingProblem& problem) {
  const KnotModel& model = *problem.knot(0).model;
  KnotBatch<Lane> at(model);
  KnotBatch<Dual<Lane>> moving(model);
  return KnotSecondDerivatives::make(model, at, moving) != nullptr;
}

void expect_equal_hessians(const ShootingProblem& problem, const Trajectory& guess) {
  RandomNumbers random(23);
  const Trajectory t = perturbed(problem, guess, random);
  Eigen::MatrixXd costates(problem.ndx(), problem.knots() + 1);
  for (double& l : costates.reshaped()) l = random.uniform(-1, 1);
  Augmentation augmentation(problem);
  augmentation.penalty.setConstant(3);
  augmentation.multiplier.setConstant(0.4);
  Acts by_parts(problem), reference(problem);
  reference.reserve_lagrangian_hessian(false);
  Linearization a(problem), b(problem);
  by_parts.lagrangian_hessian(t, costates, a, &augmentation);
  reference.lagrangian_hessian(t, costates, b, &augmentation);
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::MatrixXd &got = a.knots[k].hessian(), &expected = b.knots[k].hessian();
    if (!expected.allFinite()) continue;
    ASSERT_LT((got - expected).cwiseAbs().maxCoeff(), 1e-9 * (1 + expected.cwiseAbs().maxCoeff()))
        << "knot " << k;
  }
}

TEST(SecondDerivatives, OfReadyProblemsAreThoseOfDualNumbersThroughEverything) {
  int known = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(CONDDP_SOURCE_DIR) / "problems")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path().stem().string());
    Diagnostics out;
    const auto spec = read_problem(entry.path(), {}, out);
    const auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
    ASSERT_TRUE(built) << format_diagnostics(out, false);
    const bool by_parts = known_by_parts(*built->problem);
    known += by_parts;
    if (entry.path().stem().string().starts_with("quadruped_trot")) {
      EXPECT_TRUE(by_parts);
    }
    expect_equal_hessians(*built->problem, built->guess);
    if (HasFatalFailure()) return;
  }
  EXPECT_GE(known, 12);
}

}  // namespace
}  // namespace conddp
