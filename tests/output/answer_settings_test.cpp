#include "output/report/answer_settings.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/json/json_document.hpp"

namespace conddp {
namespace {

AnswerSettings settings_of(const OrderedJson& overrides, double constraint) {
  const auto spec = std::make_shared<ProblemSpec>();
  spec->solver.options.tolerances.constraint = constraint;
  BuiltProblem built{.problem_spec = spec};
  built.dropped.push_back({.name = "torque"});
  return answer_settings({{"problem", {{"overrides", overrides}}}}, built);
}

TEST(AnswerSettings, ListsOverridesDroppedConstraintsAndLooseTolerances) {
  const AnswerSettings settings = settings_of({"dt=0.01", "costs.effort.weight=2"}, 10);
  EXPECT_TRUE(settings.changed());
  EXPECT_EQ(settings_lines(settings),
            (std::vector<std::string>{"setting dt=0.01", "setting costs.effort.weight=2",
                                      "dropped torque",
                                      "tolerances beyond the defaults: constraint 10 (default "
                                      "1e-06)"}));
  EXPECT_EQ(settings_json(settings).dump(),
            R"({"overrides":["dt=0.01","costs.effort.weight=2"],"dropped_constraints":["torque"],)"
            R"("loose_tolerances":{"constraint":10.0}})");
}

TEST(AnswerSettings, DoesNotListDefaultOrTighterTolerances) {
  SolverOptions options;
  EXPECT_EQ(loose_tolerances_line(options), "");
  options.tolerances.constraint = 1e-12;
  EXPECT_EQ(loose_tolerances_line(options), "");
  options.tolerances.gap = 1;
  EXPECT_EQ(loose_tolerances_line(options),
            "tolerances beyond the defaults: gap 1 (default 1e-09)");
}

TEST(AnswerSettings, ListsNothingWithoutOverridesAndDrops) {
  AnswerSettings settings;
  EXPECT_FALSE(settings.changed());
  EXPECT_TRUE(settings_lines(settings).empty());
  settings.options.tolerances.gap = 1;
  EXPECT_FALSE(settings.changed()) << "the file may say so";
}

TEST(AnswerSettings, ThrowsIfOverridesAreNotTexts) {
  EXPECT_THROW(settings_of({1, 2}, 1e-9), MalformedSolution);
  EXPECT_THROW(settings_of("dt=0.01", 1e-9), MalformedSolution);
}

}  // namespace
}  // namespace conddp
