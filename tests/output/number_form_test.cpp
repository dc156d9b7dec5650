// Documents with number blocks and with lists are equivalent.
#include <gtest/gtest.h>

#include "base/json/number_block.hpp"
#include "output/report/certificate_report.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

OrderedJson document_of(const SolvedExample& example, NumberForm form) {
  const SolverInfo& solver = *find_solver(example.spec.solver.name.value);
  return solution_json({example.spec, example.built, solver, *example.result, {}}, form);
}

OrderedJson judged(const SolvedExample& example, const OrderedJson& document) {
  OrderedJson certificate = certificate_json(example.judge(document));
  certificate.erase("time_s");
  return certificate;
}

class NumberForms : public testing::TestWithParam<const char*> {};

TEST_P(NumberForms, AgreeAndAreJudgedAlike) {
  const SolvedExample example(GetParam());
  const OrderedJson lists = document_of(example, NumberForm::kLists);
  const OrderedJson blocks = document_of(example, NumberForm::kBlocks);
  EXPECT_TRUE(with_lists(blocks) == lists);
  EXPECT_EQ(json_text(blocks), json_text(lists));
  EXPECT_TRUE(with_lists(unpacked_document(packed_document(blocks))) == lists);
  const OrderedJson certificate = judged(example, lists);
  EXPECT_TRUE(certificate["holds"].get<bool>()) << certificate.dump(1);
  EXPECT_EQ(judged(example, blocks), certificate);
}

// Bounds; contacts and an impulse; constraints; a choice before the first state.
INSTANTIATE_TEST_SUITE_P(Problems, NumberForms,
                         testing::Values("arm_reach", "hopper_jump", "unicycle_obstacles",
                                         "pendulum_cycle"));

TEST(NumberForms, DetectsBlocksWithWrongNumbersOrShapes) {
  const SolvedExample example("arm_reach");
  const OrderedJson blocks = document_of(example, NumberForm::kBlocks);
  const std::vector<double> wrong(7, 0.3);
  OrderedJson changed = blocks;
  changed["trajectory"]["u"] = with_lists(changed["trajectory"]["u"]);
  EXPECT_TRUE(example.judge(changed).checks.holds());
  changed["trajectory"]["u"][3] = number_block(wrong);
  EXPECT_FALSE(example.judge(changed).checks.holds());
  changed = blocks;
  const auto controls = NumberBlock::of(blocks["trajectory"]["u"]);
  ASSERT_TRUE(controls && controls->is_table());
  std::vector<double> numbers(controls->size() * controls->columns());
  controls->copy(numbers.data());
  numbers[10] += 1e-3;
  changed["trajectory"]["u"] = number_block(controls->size(), controls->columns(), numbers);
  EXPECT_FALSE(example.judge(changed).checks.holds());
  changed["trajectory"]["u"] =
      number_block(controls->columns(), controls->size(), numbers);  // rows and columns swapped
  EXPECT_FALSE(example.judge(changed).checks.holds());
  changed = blocks;
  changed["gains"]["K"][3] = number_block(1, 7, wrong);
  EXPECT_FALSE(example.judge(changed).checks.holds());
}

TEST(NumberForms, WriterAnswerServesTheSameTrajectoryOnly) {
  const SolvedExample example("hopper_jump");
  const auto certificate_with = [&](const OrderedJson& document, const Answer& written) {
    OrderedJson certificate =
        certificate_json(certify_solution(document, example.spec, example.built, false, &written));
    certificate.erase("time_s");
    return certificate;
  };
  const OrderedJson blocks = document_of(example, NumberForm::kBlocks);
  const OrderedJson certificate = judged(example, blocks);
  EXPECT_TRUE(certificate["holds"].get<bool>());
  SolveResult other = *example.result;
  other.trajectory.u(3)[0] += 1;
  for (const SolveResult& result : {*example.result, other})
    EXPECT_EQ(certificate_with(blocks, Answer(example.spec, example.built, result)), certificate);
}

}  // namespace
}  // namespace conddp
