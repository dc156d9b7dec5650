// Full weight matrices in problem files.
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

std::string with_matrix(std::string_view matrix, std::string_view more = "") {
  return replaced(kPendulum, "weight: 10}",
                  "weight: 10, matrix: " + std::string(matrix) + std::string(more) + "}");
}

double terminal_cost(const Loaded& loaded, double theta, double omega) {
  const Phase& end = loaded.built->problem->terminal();
  KnotWorkspace<double> work(*end.model);
  const double x[2] = {theta, omega};
  end.model->evaluate(KnotInput<double>{x, nullptr, end.parameters.data(), 0.0, 1.0}, work);
  return work.cost;
}

TEST(WeightMatrix, RowsTriangleAndNamesGiveTheSameMatrix) {
  for (const char* matrix :
       {"[[2, 1], [1, 3]]", "[[2], [1, 3]]", "{theta: {theta: 2, omega: 1}, omega: {omega: 3}}",
        "{theta: {theta: 2}, omega: {theta: 1, omega: 3}}",
        "{theta: {theta: 2, omega: 1}, omega: {theta: 1, omega: 3}}"}) {
    const Loaded loaded(with_matrix(matrix));
    ASSERT_TRUE(loaded.built) << loaded.all();
    // θ − 1 = 0.5, ω = −2: ½ (2·0.25 − 2·1 + 3·4) times 10.
    EXPECT_NEAR(terminal_cost(loaded, 1.5, -2), 10 * 0.5 * (0.5 - 2 + 12), 1e-12) << matrix;
  }
}

TEST(WeightMatrix, SingleRowIsANumber) {
  const Loaded good(replaced(kPendulum, "reference: {values: {theta: 1}}, weight: 10}",
                             "columns: omega, matrix: [[4]]}"));
  ASSERT_TRUE(good.built) << good.all();
  EXPECT_NEAR(terminal_cost(good, 1.5, -2), 8, 1e-14);
}

TEST(WeightMatrix, RunningCostsAndPhasesAcceptMatrices) {
  const Loaded loaded(R"(conddp: 1
system: {type: double_integrator, dimension: 2}
initial_state: {}
phases: [{name: a, knots: 1, dt: 0.1}, {name: b, knots: 1, dt: 0.1, weights: {effort: 3}}]
costs: {effort: {residual: control, weight: 2, matrix: [[1], [0.5, 1]]}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const auto& [phase, weight] : {std::pair{0, 2.0}, {1, 3.0}}) {
    const Phase& p = loaded.built->problem->phases()[phase];
    KnotWorkspace<double> work(*p.model);
    const double x[4] = {0, 0, 0, 0}, u[2] = {1, -2};
    p.model->evaluate(KnotInput<double>{x, u, p.parameters.data(), 0.1, 0.1}, work);
    EXPECT_NEAR(work.cost, 0.1 * weight * 0.5 * (1 - 2 + 4), 1e-13);
  }
}

TEST(WeightMatrix, EachContactHasTheMatrix) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts: {LF: {frame: lf_foot}, RF: {frame: rf_foot}}
initial_state: {base: {position: [0, 0, 0.57]}, joints: {LF_KFE: -1, RF_KFE: -1, LH_KFE: 1, RH_KFE: 1}}
phases: [{knots: 2, dt: 0.1, contacts: all}]
costs: {force: {residual: contact_force, matrix: [[1], [0, 1], [0.5, 0.5, 2]]}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& model = *loaded.built->problem->phases()[0].model;
  ASSERT_EQ(model.costs().size(), 2u);
  for (const CostTerm& cost : model.costs()) {
    ASSERT_EQ(cost.residual->blocks().size(), 1u);
    EXPECT_EQ(cost.residual->size(), 3);
  }
}

TEST(WeightMatrix, ExpansionIsEquivalent) {
  for (const char* matrix :
       {"[[2, 1], [1, 3]]", "[[2], [1, 3]]", "{theta: {theta: 2, omega: 1}, omega: {omega: 3}}"}) {
    const Loaded loaded(with_matrix(matrix));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const std::string text = expanded_text(*loaded.built);
    const Loaded again(text);
    ASSERT_TRUE(again.built) << again.all();
    EXPECT_EQ(expanded_text(*again.built), text);
    EXPECT_EQ(terminal_cost(again, 1.5, -2), terminal_cost(loaded, 1.5, -2));
  }
}

TEST(WeightMatrix, SettingsAndFormulasReachEntries) {
  const Loaded set(with_matrix("[[2], [1, 3]]"), {"terminal.costs.goal.matrix.1.1=5"});
  ASSERT_TRUE(set.built) << set.all();
  EXPECT_NEAR(terminal_cost(set, 1.5, -2), 10 * 0.5 * (0.5 - 2 + 20), 1e-12);
  const Loaded formula(replaced(with_matrix("[[=a], [1, '=a + 1']]"),
                                "integrator:", "parameters: {a: 2}\nintegrator:"));
  ASSERT_TRUE(formula.built) << formula.all();
  EXPECT_NEAR(terminal_cost(formula, 1.5, -2), 10 * 0.5 * (0.5 - 2 + 12), 1e-12);
}

TEST(WeightMatrix, ReportsMistakesAtTheirPlaces) {
  const auto error = [](std::string_view matrix, std::string_view more = "") {
    return Loaded(with_matrix(matrix, more)).first_error();
  };
  EXPECT_EQ(error("[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"),
            "15:82: the matrix has 3 rows, and the residual 'state' has 2");
  EXPECT_EQ(error("[[1, 0], [0, 1, 0]]"), "15:91: row 2 of the matrix has 3 numbers, not 2");
  EXPECT_EQ(error("[[1], [0]]"), "15:88: row 2 of the matrix has 1 number, not 2");
  EXPECT_EQ(error("[[1, 0.5], [0.25, 1]]"),
            "15:93: the matrix is not symmetric: row 2 has 0.25 in column 1, and row 1 has 0.5 in "
            "column 2");
  EXPECT_EQ(error("{theta: {omega: 1}, omega: {theta: 2}}"),
            "15:110: the matrix is not symmetric: 'omega' and 'theta' have 1 and 2");
  EXPECT_EQ(error("[[1, 2], [2, 1]]"),
            "15:82: the matrix is not positive semidefinite: its least eigenvalue is -1");
  EXPECT_EQ(error("{theta: {omega: 1}}"),
            "15:82: the matrix is not positive semidefinite: its least eigenvalue is -1");
  EXPECT_EQ(error("{speed: {omega: 1}}"), "15:83: 'speed' is none of the components of the state");
  EXPECT_EQ(error("[[1, 0], [0, 1]]", ", weights: 2"),
            "15:100: 'matrix' and 'weights' exclude each other");
  EXPECT_EQ(error("[[1, 0], [0, 1]]", ", activation: smooth_l1"),
            "15:82: 'matrix' belongs to the activation 'quadratic', and this cost has 'smooth_l1'");
  EXPECT_EQ(error("3"), "15:82: a list is expected here, not 3");
}

}  // namespace
}  // namespace conddp
