// An answer in memory and its document are judged alike.
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

/// Certificates of an answer without the time: in memory, and of its document.
struct Judged {
  explicit Judged(const SolvedExample& example)
      : document(certificate_json(example.judge(example.document))) {
    const SolverInfo& solver = *find_solver(example.spec.solver.name.value);
    const Solution solution{example.built, solver, *example.result, {}};
    SolutionCertificate certificate = certify_answer(solution);
    note_nulls(example.document, certificate.checks);
    memory = OrderedJson::parse(certificate_json(certificate).dump());
    document = OrderedJson::parse(document.dump());
    memory.erase("time_s");
    document.erase("time_s");
  }
  OrderedJson memory, document;
};

class AnswersInMemory : public testing::TestWithParam<const char*> {};

TEST_P(AnswersInMemory, AreJudgedAsTheirDocuments) {
  const Judged judged(SolvedExample{GetParam()});
  EXPECT_TRUE(judged.memory["holds"].get<bool>()) << judged.memory.dump(1);
  EXPECT_EQ(judged.memory, judged.document);
}

// Bounds; contacts and an impulse; constraints; a choice before the first state; found contacts.
INSTANTIATE_TEST_SUITE_P(Problems, AnswersInMemory,
                         testing::Values("arm_reach", "hopper_jump", "unicycle_obstacles",
                                         "pendulum_cycle", "block_slope"));

TEST(AnswersInMemory, MayLeaveInfiniteNumbersOpen) {
  const Judged judged(SolvedExample(
      "acrobot_swingup", {"initial_guess.controls={constant: 1.0e+200}", "solver.name=ilqr"},
      {.drop = {"torque"}}));
  EXPECT_TRUE(judged.memory["holds"].get<bool>());
  EXPECT_EQ(judged.memory, judged.document);
}

TEST(AnswersInMemory, AreComparedWithTheirProblem) {
  const SolvedExample example("hopper_jump");
  SolveResult wrong = *example.result;
  wrong.trajectory.u(3)[0] += 1;
  const SolverInfo& solver = *find_solver(example.spec.solver.name.value);
  const Solution solution{example.built, solver, wrong, {}};
  EXPECT_NE(failures(certify_answer(solution)).find("[gap]"), std::string::npos);
}

}  // namespace
}  // namespace conddp
