#include <algorithm>
#include <fstream>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/source_tree.hpp"
#include "systems/expressions/functions.hpp"
#include "systems/expressions/parser.hpp"
#include "systems/graphs/program.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

/// x = 3 m, y = −2, mass = 1.5 kg, position = (1, 2, 4) m, q with the parts left-knee = 0.5,
/// arm/elbow = 0.25, 1 = −1, legs, rotation = a quaternion, pair = (5, 6), long = five numbers,
/// drag(v) = 2 v, map(a, b) = a + b.
struct ParserFixture {
  ParserFixture() {
    const auto number = [&](double value, std::string unit) {
      ExpressionValue v = ExpressionValue::number(add(value));
      v.unit = std::move(unit);
      return v;
    };
    scope.add("x", number(3, "m"));
    scope.add("y", number(-2, ""));
    scope.add("mass", number(1.5, "kg"));
    scope.add("position", vector({1, 2, 4}, "m"));
    ExpressionValue q = vector({0.5, 0.25, -1}, "rad");
    q.parts = {{"left-knee", 0}, {"arm/elbow", 1}, {"1", 2}, {"legs", 0, 2}};
    scope.add("q", q);
    scope.add("rotation", vector({0.5, 0.5, 0.5, 0.5}, ""));
    scope.add("pair", vector({5, 6}, ""));
    scope.add("long", vector({1, 2, 3, 4, 5}, ""));
    scope.add_table("drag",
                    graph.add_table(std::make_shared<SplineTable>(std::vector<double>{0, 1},
                                                                  std::vector<double>{0, 2})),
                    1);
    scope.add_table(
        "map",
        graph.add_table(std::make_shared<SplineTable>(
            std::vector<double>{0, 1}, std::vector<double>{0, 1}, std::vector<double>{0, 1, 1, 2})),
        2);
  }
  NodeId add(double value) {
    inputs.push_back(value);
    return graph.input(static_cast<int>(inputs.size()) - 1);
  }
  ExpressionValue vector(const std::vector<double>& values, std::string unit) {
    ExpressionValue v = ExpressionValue::vector({});
    for (const double value : values) v.nodes.push_back(add(value));
    v.unit = std::move(unit);
    return v;
  }
  ParsedExpression parse(std::string_view text) { return parse_expression(text, scope, graph); }
  /// Values of a valid expression.
  std::vector<double> numbers(const std::string& text) {
    const ParsedExpression parsed = parse(text);
    if (!parsed.value) {
      ADD_FAILURE() << text << ": " << parsed.error.offset << ": " << parsed.error.message;
      return {};
    }
    const int count = static_cast<int>(inputs.size());
    const ExpressionProgram program(graph, parsed.value->nodes, count, parsed.value->size());
    std::vector<double> registers(program.registers());
    std::copy(inputs.begin(), inputs.end(), registers.begin());
    program.prepare(registers.data());
    program.run(registers.data());
    std::vector<double> result;
    for (int i = 0; i < parsed.value->size(); ++i) result.push_back(registers[program.output(i)]);
    return result;
  }

  ExpressionGraph graph;
  ExpressionScope scope;
  std::vector<double> inputs;
};

TEST(ExpressionParser, ReadsNumbersAndOperators) {
  struct Good {
    std::string text;
    double value;
  };
  const Good cases[] = {
      {"1", 1},
      {" 1.5e3 ", 1500},
      {".5", 0.5},
      {"2.", 2},
      {"1E-2", 0.01},
      {"x", 3},
      {"1 + 2*x", 7},
      {"(1 + 2)*x", 9},
      {"10 - 4 - 3", 3},
      {"24/4/2", 3},
      {"2^3^2", 512},
      {"-x^2", -9},
      {"(-x)^2", 9},
      {"2^-1", 0.5},
      {"x^-2", 1.0 / 9},
      {"x^0.5", std::sqrt(3)},
      {"x^1.5", 3 * std::sqrt(3)},
      {"x^-0.5", 1 / std::sqrt(3)},
      {"2*-x", -6},
      {"--x", 3},
      {"+x", 3},
      {"x\n  + y", 1},
      {"y^3", -8},
      {"y^17", -131072},
      {"2*pi", 2 * std::numbers::pi},
      {"x/y*y", 3},
  };
  ParserFixture fixture;
  for (const Good& good : cases) {
    const std::vector<double> got = fixture.numbers(good.text);
    ASSERT_EQ(got.size(), 1u) << good.text;
    EXPECT_NEAR(got[0], good.value, 1e-14 * std::abs(good.value)) << good.text;
  }
}

TEST(ExpressionParser, ReadsFunctions) {
  const double x = 3, y = -2;
  struct Good {
    std::string text;
    double value;
  };
  const Good cases[] = {
      {"sin(x)", std::sin(x)},
      {"cos(x)", std::cos(x)},
      {"tan(x)", std::tan(x)},
      {"asin(x/4)", std::asin(x / 4)},
      {"acos(x/4)", std::acos(x / 4)},
      {"atan(x)", std::atan(x)},
      {"atan2(y, -x)", std::atan2(y, -x)},
      {"sinh(x)", std::sinh(x)},
      {"cosh(x)", std::cosh(x)},
      {"tanh(y)", std::tanh(y)},
      {"exp(y)", std::exp(y)},
      {"log(x)", std::log(x)},
      {"log10(x)", std::log10(x)},
      {"sqrt(x)", std::sqrt(x)},
      {"pow(x, y)", 1.0 / 9},
      {"x^mass", std::pow(x, 1.5)},
      {"2^y", 0.25},
      {"hypot(x, 4)", 5},
      {"abs(y)", 2},
      {"sign(y) + 10*sign(x) + 100*sign(x - x)", 9},
      {"min(x, y)", -2},
      {"max(x, y)", 3},
      {"smooth_abs(y, 0.1)", std::sqrt(4.01)},
      {"smooth_min(x, y, 0.5)", (1 - std::sqrt(25.25)) / 2},
      {"smooth_max(x, y, 0.5)", (1 + std::sqrt(25.25)) / 2},
      {"smooth_step(x, 2)", (1 + std::tanh(1.5)) / 2},
      {"smooth_norm(position, 2)", 5},
      {"norm(position)", std::sqrt(21.0)},
      {"dot(pair, pair)", 61},
      {"if(x > y, 1, 2)", 1},
      {"if(x < y, 1, 2)", 2},
      {"if(x <= 3 and y >= -2, 1, 2)", 1},
      {"if(x < 3 or not y > -2, 1, 2)", 1},
      {"if(not (x > 0 and y < 0), 1, 2)", 2},
      {"if(x < 0 or x > 2 and y > 0, 1, 2)", 2},
      {"drag(x)", 6},
      {"map(x, y)", 1},
      {"position[0] + 10*position.y + 100*position[z]", 421},
      {"pair.x - pair[1]", -1},
      {"q[left-knee]", 0.5},
      {"q[ arm/elbow ]/2", 0.125},
      {"q[1]", -1},
      {"q[0]", 0.5},
      {"q.legs[1]", 0.25},
      {"long[4]", 5},
      {"rotation.w", 0.5},
      {"[1, 2, x].z", 3},
      {"[1, 2, x][0]", 1},
      {"cross(position, [0, 1, 0])[0]", -4},
  };
  ParserFixture fixture;
  for (const Good& good : cases) {
    const std::vector<double> got = fixture.numbers(good.text);
    ASSERT_EQ(got.size(), 1u) << good.text;
    EXPECT_NEAR(got[0], good.value, 2e-15 * (1 + std::abs(good.value))) << good.text;
  }
}

TEST(ExpressionParser, ReadsVectors) {
  using Numbers = std::vector<double>;
  ParserFixture fixture;
  const std::pair<std::string, Numbers> cases[] = {
      {"position", {1, 2, 4}},
      {"2*position - position/2 + [1, 0, 0]", {2.5, 3, 6}},
      {"position*x", {3, 6, 12}},
      {"-pair", {-5, -6}},
      {"[pair, x, [y]]", {5, 6, 3, -2}},
      {"cross([1, 0, 0], [0, 1, 0])", {0, 0, 1}},
      {"if(x > 0, pair, [0, 0])", {5, 6}},
      // Rotation by 120 degrees about (1, 1, 1).
      {"rotate(rotation, position)", {4, 1, 2}},
      {"rotate_inverse(rotation, position)", {2, 4, 1}},
      {"conjugate(rotation)", {-0.5, -0.5, -0.5, 0.5}},
      {"quaternion_product(rotation, rotation)", {0.5, 0.5, 0.5, -0.5}},
  };
  for (const auto& [text, expected] : cases) {
    const Numbers got = fixture.numbers(text);
    ASSERT_EQ(got.size(), expected.size()) << text;
    for (std::size_t i = 0; i < got.size(); ++i) EXPECT_NEAR(got[i], expected[i], 1e-15) << text;
  }
}

TEST(ExpressionParser, WarnsAboutNonsmoothExpressions) {
  ParserFixture fixture;
  const ParsedExpression parsed = fixture.parse("1 + abs(x) - min(x, if(x > 0, 1, 2))");
  ASSERT_TRUE(parsed.value);
  std::vector<std::pair<int, std::string>> warnings;
  for (const ExpressionMessage& warning : parsed.warnings)
    warnings.emplace_back(warning.offset, warning.message.substr(0, 5));
  EXPECT_EQ(warnings,
            (std::vector<std::pair<int, std::string>>{{4, "'abs'"}, {20, "'if' "}, {13, "'min'"}}));
  EXPECT_TRUE(fixture.parse("smooth_abs(x, 1) + norm(position)").warnings.empty());
  const ParsedExpression width = fixture.parse("smooth_abs(x, y)");
  ASSERT_EQ(width.warnings.size(), 1u);
  EXPECT_EQ(width.warnings[0].offset, 14);
  EXPECT_EQ(width.warnings[0].message,
            "the argument 'width' of 'smooth_abs' is not constant: it has to stay above 0");
}

/// Lines of the file of malformed expressions: text, one-based column, message.
struct MalformedExpression {
  std::string text;
  int column = 0;
  std::string message;
};

std::vector<MalformedExpression> malformed_expressions() {
  std::ifstream file(source_tree().string() + "/tests/systems/malformed_expressions.txt");
  std::vector<MalformedExpression> cases;
  std::string line;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t first = line.find(" | "), second = line.find(" | ", first + 3);
    if (second == std::string::npos) throw std::runtime_error("two '|' are missing: " + line);
    cases.push_back(
        {line.substr(second + 3), std::stoi(line), line.substr(first + 3, second - first - 3)});
  }
  return cases;
}

TEST(ExpressionParser, MalformedExpressionsHaveAColumnAndAMessage) {
  const std::vector<MalformedExpression> cases = malformed_expressions();
  EXPECT_GE(cases.size(), 300u);
  for (const MalformedExpression& c : cases) {
    ParserFixture fixture;
    const ParsedExpression parsed = fixture.parse(c.text);
    EXPECT_FALSE(parsed.value) << c.text;
    const std::string& hint = parsed.error.hint;
    EXPECT_EQ(parsed.error.message + (hint.empty() ? "" : "; " + hint), c.message) << c.text;
    EXPECT_EQ(parsed.error.offset + 1, c.column) << c.text;
  }
}

TEST(ExpressionParser, EmptyTextIsNotAnExpression) {
  for (const char* text : {"", " ", "\n\t "}) {
    ParserFixture fixture;
    const ParsedExpression parsed = fixture.parse(text);
    EXPECT_FALSE(parsed.value);
    EXPECT_EQ(parsed.error.message, "the expression is empty");
    EXPECT_EQ(parsed.error.offset, 0);
  }
}

TEST(ExpressionParser, LimitsSizeAndDepth) {
  ParserFixture fixture;
  const auto nested = [](int depth) {
    return std::string(depth, '(') + "x" + std::string(depth, ')');
  };
  EXPECT_TRUE(fixture.parse(nested(kMostExpressionNesting - 1)).value);
  const ParsedExpression deep = fixture.parse(nested(kMostExpressionNesting));
  EXPECT_EQ(deep.error.message, "the expression is nested more than 100 levels deep");
  EXPECT_EQ(deep.error.offset, kMostExpressionNesting);
  for (const char* repeated : {"-", "not ", "sin(", "[", "x^"}) {
    std::string text;
    for (int i = 0; i < 300; ++i) text += repeated;
    EXPECT_EQ(fixture.parse(text + "x").error.message,
              "the expression is nested more than 100 levels deep")
        << repeated;
  }

  // A name in a vector that defines the next name would double the size each time.
  std::string vector = "[x";
  for (std::size_t i = 0; i < kMostVectorNumbers / 5; ++i) vector += ", long";
  EXPECT_EQ(fixture.parse(vector + "]").error.message, "a vector has at most 1000 numbers");

  // Long sums do not nest deeply.
  std::string sum = "x";
  while (sum.size() < kMostExpressionBytes - 10) sum += " + x*y";
  EXPECT_TRUE(fixture.parse(sum).value);
  EXPECT_NEAR(fixture.numbers(sum)[0], 3 - 6.0 * static_cast<double>((sum.size() - 1) / 6), 1e-9);
  const ParsedExpression large = fixture.parse(sum + std::string(20, ' '));
  EXPECT_FALSE(large.value);
  EXPECT_EQ(large.error.message, "an expression has at most 20000 bytes");
}

TEST(ExpressionFunctions, AreDocumentedAndHaveUniqueNames) {
  std::vector<std::string_view> names;
  for (const ExpressionFunction& function : expression_functions()) {
    names.push_back(function.name);
    EXPECT_FALSE(function.documentation.empty()) << function.name;
    EXPECT_FALSE(function.arguments.empty()) << function.name;
    EXPECT_EQ(find_expression_function(function.name), &function);
    EXPECT_TRUE(is_expression_name(function.name));
  }
  for (const ExpressionConstant& constant : expression_constants()) names.push_back(constant.name);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
  EXPECT_EQ(find_expression_function("sine"), nullptr);
}

}  // namespace
}  // namespace conddp
