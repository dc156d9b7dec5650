// Compiled systems, compared with equivalent expressions.
#include "systems/libraries/library_system.hpp"

#include "support/expression_systems.hpp"
#include "system_comparison.hpp"
#include "systems/expressions/system.hpp"

namespace conddp {
namespace {

using Defect = LibraryKnotFunction::Defect;

std::shared_ptr<const SharedLibrary> test_model() {
  static const auto library = std::make_shared<const SharedLibrary>(
      "the model", std::initializer_list<const char*>{CONDDP_TEST_MODEL});
  return library;
}

std::shared_ptr<const LibraryKnotFunction> function_of(const std::string& name,
                                                       const std::vector<double>& parameters) {
  std::optional<Defect> defect;
  auto function = LibraryKnotFunction::make(test_model(), name, {2, 1}, parameters, defect);
  EXPECT_TRUE(function) << (defect ? defect->message : "");
  return function;
}

struct LibraryCase {
  std::string function;
  std::vector<double> parameters;
  LibrarySystemColumns columns;
  ExpressionSystemText text;
};

std::vector<LibraryCase> library_cases() {
  const std::vector<Column> states = {{"angle", "rad"}, {"speed", "rad/s"}};
  const LibrarySystemColumns first = {.states = states, .controls = {{"torque", "Nm"}}};
  ExpressionSystemText text{.kind = SystemKind::first_order,
                            .states = {{"angle", "rad"}, {"speed", "rad/s"}},
                            .controls = {{"torque", "Nm"}}};
  ExpressionSystemText swing = text, wind = text;
  swing.equations = {{"angle", "speed"},
                     {"speed", "(torque - 5*sin(angle) - 0.1*speed*angle^2)/2"}};
  wind.equations = {{"angle", "speed"}, {"speed", "torque - sin(angle) + 0.3*sin(2*t)"}};
  LibrarySystemColumns discrete = first;
  discrete.kind = SystemKind::discrete;
  ExpressionSystemText next = swing;
  next.kind = SystemKind::discrete;
  return {{"swing", {2, 5}, first, swing},
          {"swing", {2, 5}, discrete, next},
          {"wind", {}, first, wind},
          {"fall",
           {},
           {.kind = SystemKind::second_order,
            .states = {{"y", "m"}},
            .velocities = {{"v", "m/s"}},
            .controls = {{"push", "N"}}},
           {.kind = SystemKind::second_order,
            .states = {{"y", "m"}},
            .velocities = {{"v", "m/s"}},
            .controls = {{"push", "N"}},
            .equations = {{"v", "push - 0.4*v^2"}}}}};
}

TEST(LibrarySystems, MatchColumnsValuesAndJacobiansOfEquations) {
  for (const LibraryCase& c : library_cases()) {
    const auto library = make_library_system(c.columns, function_of(c.function, c.parameters));
    const auto words = expression_system(c.text);
    ASSERT_EQ(library->nx(), words->nx()) << c.function;
    ASSERT_EQ(library->kind(), words->kind()) << c.function;
    for (int i = 0; i < library->nx(); ++i) {
      EXPECT_EQ(library->state_columns()[i].name, words->state_columns()[i].name);
      EXPECT_EQ(library->state_columns()[i].unit, words->state_columns()[i].unit);
    }
    expect_equal_answers<double>(c.function, *library, *words);
    expect_equal_answers<Lane>(c.function, *library, *words);
    // Without a Hessian, the derivatives of the Jacobian are differences.
    expect_equal_answers<Dual<Lane>>(c.function, *library, *words, 1e-8);
  }
}

TEST(LibrarySystems, SecondDerivativesMatchTheEquations) {
  RandomNumbers random(412);
  for (const LibraryCase& c : library_cases()) {
    const auto function = function_of(c.function, c.parameters);
    const auto library = make_library_system(c.columns, function);
    const auto words = expression_system(c.text);
    const SystemPoint<Lane> point = random_point<Lane>(*words, random);
    AlignedVector<Lane> weights;
    for (int i = 0; i < words->rows(); ++i) weights.push_back(Lane(random.uniform(-1, 1)));
    expect_equal_numbers(own_curvature(*library, point, weights),
                         own_curvature(*words, point, weights),
                         function->has_hessian() ? 1e-12 : 1e-8, c.function);
  }
}

TEST(LibrarySystems, ReleaseTheirCheckedOutWorkspaces) {
  const auto in_use = reinterpret_cast<int (*)()>(test_model()->symbol("workspaces_in_use"));
  const int before = in_use();
  const auto function = function_of("swing", {2, 5});
  {
    const auto first = function->create_workspace(), second = function->create_workspace();
    EXPECT_EQ(in_use(), before + 2);
  }
  EXPECT_EQ(in_use(), before);
}

TEST(LibrarySystems, GiveNoNumbersIfTheFunctionFails) {
  const auto function = function_of("torn", {});
  const auto workspace = function->create_workspace();
  const double z[] = {0.1, 0.2, 0.3};
  double f[2] = {}, J[6] = {};
  function->differentiate(z, *workspace, f, J);
  for (const double value : f) EXPECT_TRUE(std::isnan(value));
  for (const double value : J) EXPECT_TRUE(std::isnan(value));
}

/// Jacobian from dual numbers of values, rows x columns.
Eigen::MatrixXd dual_jacobian(const LibraryKnotFunction& function, const std::vector<double>& z) {
  const auto workspace = function.create_workspace();
  Eigen::MatrixXd J(function.rows(), function.columns());
  for (int column = 0; column < function.columns(); ++column) {
    AlignedVector<Dual<Lane>> at, f(function.rows());
    for (const double number : z) at.push_back(Dual<Lane>(number));
    at[column].d = Lane(1.0);
    function.evaluate(at.data(), *workspace, f.data());
    for (int row = 0; row < function.rows(); ++row) J(row, column) = f[row].d[kLaneWidth - 1];
  }
  return J;
}

Eigen::MatrixXd own_jacobian(const LibraryKnotFunction& function, const std::vector<double>& z) {
  const auto workspace = function.create_workspace();
  Eigen::VectorXd f(function.rows());
  Eigen::MatrixXd J(function.rows(), function.columns());
  function.differentiate(z.data(), *workspace, f.data(), J.data());
  return J;
}

TEST(LibraryKnotFunction, DualNumbersOfValuesHaveACorrectJacobian) {
  struct Case {
    const char* function;
    std::vector<double> z;
  };
  const Case cases[] = {{"climb", {10, 100, 3}},   {"climb", {1210, 100, 3}},
                        {"climb", {7e6, 7500, 0}}, {"climb", {-3e4, 20, 1e6}},
                        {"kink", {0, 0, 0}},       {"kink", {1e-7, 0, 0}},
                        {"edge", {0, 0, 0}},       {"edge", {1e-6, 1, 0}},
                        {"edge", {2, 1, 0}},       {"growth", {3, 1, -20}}};
  for (const Case& c : cases) {
    const auto function = function_of(c.function, {});
    EXPECT_EQ(dual_jacobian(*function, c.z), own_jacobian(*function, c.z))
        << c.function << ' ' << c.z[0];
  }
}

TEST(LibraryKnotFunction, DualNumbersReplaceWrongJacobiansByDifferences) {
  const auto function = function_of("crooked", {});
  const std::vector<double> z = {0.3, 2, 1};
  EXPECT_EQ(own_jacobian(*function, z)(1, 2), 2);
  EXPECT_NEAR(dual_jacobian(*function, z)(1, 2), 1, 1e-9);
  EXPECT_NEAR(dual_jacobian(*function, z)(1, 0), -1, 1e-9);
}

TEST(LibraryKnotFunction, JacobiansReceiveTheOutputsTheyRead) {
  const Eigen::MatrixXd J = own_jacobian(*function_of("growth", {}), {0.5, 1, 3});
  EXPECT_DOUBLE_EQ(J(1, 0), std::exp(0.5));
  EXPECT_EQ(J(0, 1), 1);
  EXPECT_EQ(J(1, 2), 1);
}

/// A step as long as the coordinate would span periods.
TEST(LibraryKnotFunction, SecondDerivativesAreConfirmedByShorterSteps) {
  const auto function = function_of("wave", {});
  const auto workspace = function->create_workspace();
  for (const double x : {0.3, 9424.78, 1e5 + 0.7, 1e6 + 0.3}) {
    const double z[] = {x, 1, 2}, weights[] = {0.5, 3};
    Eigen::Matrix3d H;
    function->second_derivatives(z, weights, *workspace, H.data());
    EXPECT_NEAR(H(0, 0), 3 * std::sin(x), 1e-4) << x;
    H(0, 0) = 0;
    EXPECT_LT(H.cwiseAbs().maxCoeff(), 1e-6) << x;
  }
}

TEST(SlopeInterval, ShorterStepConfirmsLongerOneUpToRounding) {
  EXPECT_TRUE(confirms_slope(1, 1 + 1e-7, 0));
  EXPECT_FALSE(confirms_slope(1, 1 + 1e-5, 0));
  EXPECT_TRUE(confirms_slope(0, 1e-9, 1e6));
  EXPECT_FALSE(confirms_slope(0, 1e-7, 1e6));
  EXPECT_FALSE(confirms_slope(1, std::nan(""), 1));
}

TEST(SlopeInterval, ConfirmsInsideAndReplacesOutsideValues) {
  const SlopeInterval kink = between_slopes(2, -1);
  EXPECT_EQ(confirmed_slope(-1, kink, 0), -1);
  EXPECT_EQ(confirmed_slope(0.3, kink, 0), 0.3);
  EXPECT_EQ(confirmed_slope(2.01, kink, 0.02), 2.01);
  EXPECT_EQ(confirmed_slope(2.03, kink, 0.02), 2);
  EXPECT_EQ(confirmed_slope(-5, kink, 0.02), -1);
  EXPECT_EQ(confirmed_slope(std::nan(""), kink, 0), 0.5);
  EXPECT_EQ(confirmed_slope(std::numeric_limits<double>::infinity(), kink, 0), 2);
  EXPECT_TRUE(std::isnan(confirmed_slope(1, between_slopes(std::nan(""), 1), 0)));
  EXPECT_TRUE(std::isnan(
      confirmed_slope(1, between_slopes(-1, std::numeric_limits<double>::infinity()), 0)));
}

TEST(SlopeInterval, BestIsNarrowAndConfirmedByTheNext) {
  const auto index_of = [](const std::vector<MeasuredSlope>& steps) {
    return &best_measured(steps) - steps.data();
  };
  // A narrow interval contradicted by the next; rounding; and constant intervals, where the first
  // wins.
  EXPECT_EQ(index_of({{{0, 0.01}, 0}, {{0.9, 1.1}, 0}, {{0.99, 1.01}, 0}}), 2);
  EXPECT_EQ(index_of({{{0.8, 1.2}, 0}, {{0.99, 1.01}, 1e-3}, {{1, 1}, 0.1}}), 1);
  EXPECT_EQ(index_of({{{0, 1}, 0}, {{0, 1}, 0}, {{0, 1}, 0}}), 0);
  const double none = std::nan("");
  EXPECT_EQ(index_of({{{none, none}, none}, {{none, none}, none}, {{1, 2}, 0}}), 2);
}

TEST(SlopeInterval, ReachesEdgeDerivativesOfRootsAndSmoothFunctions) {
  // Secants of x^1.5 and x^2 from 0: the derivative there is 0.
  const double h = 1e-5;
  const SlopeInterval root = at_edge(std::sqrt(h), std::sqrt(h / 4)), square = at_edge(h, h / 4);
  EXPECT_NEAR(root.lower, 0, 1e-16);
  EXPECT_LE(square.lower, 0);
  EXPECT_GE(square.upper, 0);
}

TEST(LibraryKnotFunction, ReportsMismatches) {
  struct Case {
    std::string function;
    LibraryKnotFunction::Sizes sizes;
    std::vector<double> parameters;
    Defect::Part part;
    std::string message;
  };
  using Part = Defect::Part;
  const Case cases[] = {
      {"absent", {2, 1}, {}, Part::kFunction, "the library has no function 'absent'"},
      {"lonely", {2, 1}, {}, Part::kFunction, "the library has no function 'jac_lonely'"},
      {"odd", {2, 1}, {}, Part::kFunction, "'odd' has an input 'force'"},
      {"flat",
       {2, 1},
       {},
       Part::kFunction,
       "the output 'rate' of 'flat' is 2 x 2, and has to be a vector"},
      {"thin",
       {2, 1},
       {},
       Part::kFunction,
       "the output 'jac_rate_x' of 'jac_thin' is 2 x 1, and has to be 2 x 2"},
      {"nameless", {2, 1}, {}, Part::kFunction, "'jac_nameless' has no output 'jac_rate_x'"},
      {"weightless",
       {2, 1},
       {},
       Part::kFunction,
       "'hess_weightless' has no input 'lam' of 2 numbers, one for each row of 'weightless'"},
      {"strange", {2, 1}, {}, Part::kFunction, "'hess_strange' has an input 'lam_of_y'"},
      {"alien", {2, 1}, {}, Part::kFunction, "'jac_alien' has an input 'out_force'"},
      {"garbled", {2, 1}, {}, Part::kFunction, "'garbled_sparsity_in' describes no matrix"},
      {"swing",
       {3, 1},
       {2, 5},
       Part::kStates,
       "the input 'x' of 'swing' is 2 x 1 with 2 numbers, and the file has 3"},
      {"swing",
       {2, 2},
       {2, 5},
       Part::kControls,
       "the input 'u' of 'swing' is 1 x 1 with 1 numbers, and the file has 2"},
      {"swing",
       {2, 1},
       {2},
       Part::kParameters,
       "the input 'p' of 'swing' is 2 x 1 with 2 numbers, and the file has 1"},
      {"fall", {2, 1}, {2}, Part::kParameters, "'fall' has no input 'p' for parameters"}};
  for (const Case& c : cases) {
    std::optional<Defect> defect;
    EXPECT_FALSE(
        LibraryKnotFunction::make(test_model(), c.function, c.sizes, c.parameters, defect));
    ASSERT_TRUE(defect) << c.function;
    EXPECT_EQ(defect->part, c.part) << c.function;
    EXPECT_EQ(defect->message, c.message);
  }
}

}  // namespace
}  // namespace conddp
