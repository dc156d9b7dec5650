// Values and derivatives of random expressions, compared with trees evaluated in complex numbers.
// First derivatives use complex steps, second derivatives complex steps through dual numbers.
#include <gtest/gtest.h>

#include "support/random_expression.hpp"
#include "systems/expressions/parser.hpp"
#include "systems/graphs/derivatives.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

using Complex = std::complex<double>;
constexpr int kInputs = 4;
constexpr double kStep = 1e-100;

struct RandomCase {
  std::string text;
  RandomExpression tree;
  std::vector<double> x;
};

RandomCase random_case(std::uint64_t seed) {
  RandomNumbers random(seed);
  RandomExpression tree(random, kInputs, 3 + random.index(4));
  std::string text = tree.text();
  return {std::move(text), std::move(tree), random.numbers(kInputs, 1.5)};
}

/// Each input moves along its own column.
InputMotions identity_motions(ExpressionGraph& graph) {
  InputMotions motions;
  for (int i = 0; i < kInputs; ++i) motions.push_back({{i, graph.constant(1)}});
  return motions;
}

ExpressionScope numbered_scope(ExpressionGraph& graph) {
  ExpressionScope scope;
  for (int i = 0; i < kInputs; ++i)
    scope.add(fmt::format("x{}", i), ExpressionValue::number(graph.input(i)));
  return scope;
}

NodeId parse_good(const std::string& text, ExpressionGraph& graph) {
  const ParsedExpression parsed = parse_expression(text, numbered_scope(graph), graph);
  if (!parsed.value) throw std::invalid_argument(parsed.error.message + " in " + text);
  return parsed.value->nodes.at(0);
}

template <class S>
AlignedVector<S> run_program(const ExpressionProgram& program, const std::vector<S>& inputs) {
  AlignedVector<S> registers(program.registers());
  program.prepare(registers.data());
  std::copy(inputs.begin(), inputs.end(), registers.begin());
  program.run(registers.data());
  return registers;
}

double slope_by_complex_step(const RandomCase& c, int direction) {
  std::vector<Complex> x(c.x.begin(), c.x.end());
  x[direction] += Complex(0, kStep);
  return c.tree.walk(x).imag() / kStep;
}

double curvature_by_complex_step(const RandomCase& c, int i, int j) {
  std::vector<Along<Complex>> x;
  for (const double value : c.x) x.push_back({value, 0});
  x[i].slope = 1;
  x[j].value += Complex(0, kStep);
  return c.tree.walk(x).slope.imag() / kStep;
}

constexpr int kRandomCases = 400;

TEST(ExpressionDerivatives, RandomExpressionsMatchTheirTrees) {
  for (int seed = 0; seed < kRandomCases; ++seed) {
    const RandomCase c = random_case(seed);
    ExpressionGraph graph;
    const NodeId output = parse_good(c.text, graph);
    const ExpressionProgram program(graph, {&output, 1}, kInputs, 1);
    const double expected = c.tree.walk(std::vector<Complex>(c.x.begin(), c.x.end())).real();
    const double tolerance = 1e-12 * (1 + std::abs(expected));
    EXPECT_NEAR(run_program(program, c.x)[program.output(0)], expected, tolerance) << c.text;
    std::vector<Lane> lanes(c.x.begin(), c.x.end());
    lanes[0].set(1, 0.5);
    std::vector<double> second = c.x;
    second[0] = 0.5;
    const Lane value = run_program(program, lanes)[program.output(0)];
    EXPECT_NEAR(value[0], expected, tolerance) << c.text;
    const double other = c.tree.walk(std::vector<Complex>(second.begin(), second.end())).real();
    EXPECT_NEAR(value[1], other, 1e-12 * (1 + std::abs(other))) << c.text;
  }
}

void expect_gradient(const RandomCase& c, const ExpressionGraph& graph, NodeId output,
                     const std::vector<JacobianEntry>& entries) {
  std::vector<NodeId> outputs{output};
  for (const JacobianEntry& entry : entries) outputs.push_back(entry.value);
  const ExpressionProgram program(graph, outputs, kInputs, 1);
  const AlignedVector<double> registers = run_program(program, c.x);
  std::vector<double> gradient(kInputs, 0.0);
  for (std::size_t i = 0; i < entries.size(); ++i) {
    EXPECT_EQ(entries[i].row, 0);
    gradient[entries[i].column] = registers[program.output(static_cast<int>(i) + 1)];
  }
  double scale = 1;
  for (const double slope : gradient) scale = std::max(scale, std::abs(slope));
  for (int i = 0; i < kInputs; ++i)
    EXPECT_NEAR(gradient[i], slope_by_complex_step(c, i), 1e-11 * scale) << c.text;
}

/// First or second derivative of an expression with respect to x0 at zero inputs.
double derivative_at_zero(const std::string& text, int order) {
  ExpressionGraph graph;
  NodeId node = parse_good(text, graph);
  for (int i = 0; i < order; ++i) {
    const InputMotions motions = identity_motions(graph);
    node = differentiate_forward(graph, {&node, 1}, motions).at(0).value;
  }
  const ExpressionProgram program(graph, {&node, 1}, kInputs, 1);
  return run_program(program, std::vector<double>(kInputs, 0.0))[program.output(0)];
}

TEST(ExpressionDerivatives, PowersHaveTheirDerivativesAtZero) {
  for (const char* text :
       {"x0^1.5", "x0^2.5", "x0^1.7", "x0^2", "pow(x0, 3.5)", "sqrt(x0)^3", "sqrt(x0)^5"})
    EXPECT_EQ(derivative_at_zero(text, 1), 0) << text;
  EXPECT_EQ(derivative_at_zero("sqrt(x0)^2", 1), 1);
  for (const char* text : {"x0^2.5", "x0^2.7", "x0^3", "sqrt(x0)^5"})
    EXPECT_EQ(derivative_at_zero(text, 2), 0) << text;
}

TEST(ExpressionDerivatives, FirstDerivativesMatchComplexSteps) {
  int backward = 0;
  for (int seed = 0; seed < kRandomCases; ++seed) {
    const RandomCase c = random_case(seed);
    ExpressionGraph graph;
    const NodeId output = parse_good(c.text, graph);
    const InputMotions motions = identity_motions(graph);
    expect_gradient(c, graph, output, differentiate_forward(graph, {&output, 1}, motions));
    if (has_choice(graph, {&output, 1})) continue;
    ++backward;
    expect_gradient(c, graph, output, differentiate_backward(graph, {&output, 1}, motions));
  }
  EXPECT_GE(backward, 200);
}

TEST(ExpressionDerivatives, SecondDerivativesMatchComplexSteps) {
  for (int seed = 0; seed < kRandomCases; ++seed) {
    const RandomCase c = random_case(seed);
    ExpressionGraph graph;
    const NodeId output = parse_good(c.text, graph);
    const auto entries = second_derivatives(graph, output, identity_motions(graph), 1000000);
    ASSERT_TRUE(entries);
    std::vector<NodeId> outputs;
    for (const JacobianEntry& entry : *entries) outputs.push_back(entry.value);
    const ExpressionProgram program(graph, outputs, kInputs, 0);
    const AlignedVector<double> registers = run_program(program, c.x);
    double hessian[kInputs][kInputs] = {}, scale = 1;
    for (std::size_t i = 0; i < entries->size(); ++i) {
      const auto [row, column, node] = (*entries)[i];
      EXPECT_GE(row, column);
      hessian[row][column] = registers[program.output(static_cast<int>(i))];
      scale = std::max(scale, std::abs(hessian[row][column]));
    }
    for (int i = 0; i < kInputs; ++i)
      for (int j = 0; j <= i; ++j)
        EXPECT_NEAR(hessian[i][j], curvature_by_complex_step(c, i, j), 1e-10 * scale) << c.text;
  }
}

TEST(ExpressionDerivatives, DualNumbersGiveSecondDerivativesToo) {
  for (int seed = 0; seed < kRandomCases; ++seed) {
    const RandomCase c = random_case(seed);
    ExpressionGraph graph;
    const DifferentiableExpressions functions(graph, {parse_good(c.text, graph)}, kInputs,
                                              identity_motions(graph));
    for (int d = 0; d < kInputs; ++d) {
      std::vector<Dual<Lane>> x;
      for (const double value : c.x) x.push_back({Lane(value), Lane(0.0)});
      x[d].d = Lane(1.0);
      const auto registers = run_program(functions.with_derivatives(), x);
      const double slope = registers[functions.with_derivatives().output(0)].d[0];
      const double expected = slope_by_complex_step(c, d);
      EXPECT_NEAR(slope, expected, 1e-11 * (1 + std::abs(expected))) << c.text;
      for (const auto& entry : functions.jacobian()) {
        const double curvature = registers[entry.place].d[0];
        const double twice = curvature_by_complex_step(c, d, entry.column);
        EXPECT_NEAR(curvature, twice, 1e-10 * (1 + std::abs(twice) + std::abs(expected))) << c.text;
        if (entry.constant) {
          EXPECT_EQ(registers[entry.place].v[0], entry.value);
        }
      }
    }
  }
}

TEST(ExpressionDerivatives, ValuesAloneMatchThoseWithDerivativesBitwise) {
  for (int seed = 0; seed < kRandomCases; ++seed) {
    const RandomCase c = random_case(seed), other = random_case(seed + kRandomCases);
    ExpressionGraph graph;
    const NodeId first = parse_good(c.text, graph);
    const DifferentiableExpressions functions(
        graph, {first, parse_good(other.text, graph), graph.square(first)}, kInputs,
        identity_motions(graph));
    const auto values = run_program(functions.values(), c.x);
    const auto both = run_program(functions.with_derivatives(), c.x);
    for (int i = 0; i < functions.size(); ++i)
      EXPECT_EQ(values[functions.values().output(i)], both[functions.with_derivatives().output(i)])
          << c.text;
  }
}

TEST(ExpressionDerivatives, OmitsSecondDerivativesOfLargeExpressions) {
  ExpressionGraph graph;
  const NodeId output = parse_good("sin(x0*x1)*cos(x2*x3)", graph);
  EXPECT_FALSE(second_derivatives(graph, output, identity_motions(graph), 10));
}

TEST(ExpressionGraphs, ComputeNothingTwice) {
  ExpressionGraph graph;
  const NodeId a = parse_good("sin(x0 + 2*x1)^2 + x2", graph);
  const int size = graph.size();
  EXPECT_EQ(parse_good("x2 + sin(x1*2 + x0)*sin(x0 + x1*2)", graph), a);
  EXPECT_EQ(graph.size(), size);
}

TEST(ExpressionGraphs, OmitOperationsWithoutEffect) {
  ExpressionGraph graph;
  const NodeId x = graph.input(0), y = graph.input(1);
  EXPECT_EQ(parse_good("x0 + 0", graph), x);
  EXPECT_EQ(parse_good("0 + x0 - 0", graph), x);
  EXPECT_EQ(parse_good("1*x0/1", graph), x);
  EXPECT_EQ(parse_good("--x0", graph), x);
  EXPECT_EQ(parse_good("x0^1", graph), x);
  EXPECT_EQ(parse_good("1/(1/x0)", graph), x);
  EXPECT_EQ(parse_good("if(x1 < 0, x0, x0)", graph), x);
  EXPECT_EQ(parse_good("if(1 < 2, x0, x1)", graph), x);
  EXPECT_EQ(parse_good("2*(0.5*x0)", graph), x);
  EXPECT_EQ(parse_good("x0 - (-x1)", graph), graph.add(x, y));
  EXPECT_EQ(parse_good("-(x0 - x1)", graph), graph.subtract(y, x));
  EXPECT_EQ(parse_good("(-x0)*(-x1)", graph), graph.multiply(x, y));
  EXPECT_EQ(graph.constant_of(parse_good("x0*0 + 2^10 - cos(0)", graph)), 1023);
  EXPECT_EQ(graph.constant_of(parse_good("x0 - x0", graph)), 0);
  EXPECT_EQ(graph.constant_of(parse_good("x0^0", graph)), 1);
}

TEST(ExpressionPrograms, ReuseRegisters) {
  ExpressionGraph graph;
  std::string text = "x0";
  for (int i = 0; i < 90; ++i) text = fmt::format("sin({} + x1)", text);
  const NodeId output = parse_good(text, graph);
  const ExpressionProgram program(graph, {&output, 1}, kInputs, 1);
  EXPECT_EQ(program.instructions(), 180);
  EXPECT_LE(program.registers(), kInputs + 2);
}

TEST(ExpressionPrograms, FuseProductsWithSumsAndSinesWithCosines) {
  ExpressionGraph graph;
  const NodeId output = parse_good("x0*x1 + x2*sin(x3) - x1*cos(x3)", graph);
  const ExpressionProgram program(graph, {&output, 1}, kInputs, 1);
  EXPECT_EQ(program.instructions(), 4);  // sincos, one product, two fused instructions
}

TEST(ExpressionPrograms, OutputsMayBeInputsOrConstants) {
  ExpressionGraph graph;
  const std::vector<NodeId> outputs{graph.input(2), graph.constant(7), graph.input(2)};
  const ExpressionProgram program(graph, outputs, kInputs, 3);
  const auto registers = run_program(program, std::vector<double>{1, 2, 3, 4});
  EXPECT_EQ(registers[program.output(0)], 3);
  EXPECT_EQ(registers[program.output(1)], 7);
  EXPECT_EQ(registers[program.output(2)], 3);
}

}  // namespace
}  // namespace conddp
