#include "systems/expressions/parser.hpp"

#include <cmath>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"
#include "systems/expressions/functions.hpp"

namespace conddp {
namespace {

using Kind = ExpressionValue::Kind;
using Token = ExpressionToken;

/// Precedence climbing that adds nodes to the graph directly. Throws on errors.
class Parser {
 public:
  Parser(std::string_view text, const ExpressionScope& scope, ExpressionGraph& graph,
         std::vector<ExpressionMessage>& warnings)
      : text_(text), lexer_(text), scope_(scope), graph_(graph), warnings_(warnings) {}

  ExpressionValue whole() {
    if (lexer_.next().kind == Token::Kind::kEnd) fail(0, "the expression is empty");
    ExpressionValue value = alternative();
    const Token& rest = lexer_.next();
    if (rest.kind != Token::Kind::kEnd) fail_at_operator(rest);
    return value;
  }

 private:
  [[noreturn]] static void fail(int offset, std::string message, std::string hint = {}) {
    throw ExpressionError({offset, std::move(message), std::move(hint)});
  }
  [[noreturn]] static void fail_at_operator(const Token& token) {
    if (token.is(")") || token.is("]"))
      fail(token.offset, fmt::format("'{}' closes nothing", token.text));
    if (token.is(","))
      fail(token.offset, "unexpected ','", "vectors are written in brackets: [a, b]");
    fail(token.offset, fmt::format("expected an operator instead of '{}'", token.text),
         hint_of_operator(token));
  }
  /// Suggests the intended operator for an unexpected token.
  static std::string hint_of_operator(const Token& token) {
    if (token.is("{") || token.is("}")) return "";
    if (const auto hint = foreign_operator_hint(token.text); !hint.empty())
      return std::string(hint);
    if (token.kind == Token::Kind::kNumber && token.text[0] == '.')
      return fmt::format("a number of a vector v is written v[{}]", token.text.substr(1));
    return "a product is written with '*'";
  }
  [[noreturn]] static void fail_at_end(const Token& end, const Token& opened) {
    fail(end.offset, fmt::format("the '{}' is not closed", opened.text));
  }

  /// Limits nesting, which would otherwise exhaust the stack.
  class Level {
   public:
    Level(int& depth, const Token& token) : depth_(depth) {
      if (++depth_ > kMostExpressionNesting)
        fail(token.offset, fmt::format("the expression is nested more than {} levels deep",
                                       kMostExpressionNesting));
    }
    ~Level() { --depth_; }
    Level(const Level&) = delete;

   private:
    int& depth_;
  };

  ExpressionValue number(NodeId node) { return ExpressionValue::number(node); }

  // Conditions.

  void need_condition(const ExpressionValue& value, const Token& of, int offset) {
    if (value.kind == Kind::kCondition) return;
    fail(offset, fmt::format("'{}' needs a condition, and this is a {}", of.text, value.type()));
  }

  ExpressionValue alternative() {
    const int offset = lexer_.next().offset;
    ExpressionValue left = conjunction();
    while (lexer_.next().is("or")) left = join(std::move(left), offset, false);
    return left;
  }

  ExpressionValue conjunction() {
    const int offset = lexer_.next().offset;
    ExpressionValue left = negation();
    while (lexer_.next().is("and")) left = join(std::move(left), offset, true);
    return left;
  }

  /// Parses 'and' or 'or' and its right operand.
  ExpressionValue join(ExpressionValue left, int left_offset, bool both) {
    const Token word = lexer_.take();
    const int offset = lexer_.next().offset;
    const ExpressionValue right = both ? negation() : conjunction();
    need_condition(left, word, left_offset);
    need_condition(right, word, offset);
    const NodeId a = left.nodes[0], b = right.nodes[0];
    return ExpressionValue::condition(both ? graph_.choose(a, b, graph_.constant(0))
                                           : graph_.choose(a, graph_.constant(1), b));
  }

  ExpressionValue negation() {
    if (!lexer_.next().is("not")) return comparison();
    const Token word = lexer_.take();
    const Level level(depth_, word);
    const int offset = lexer_.next().offset;
    const ExpressionValue value = negation();
    need_condition(value, word, offset);
    return ExpressionValue::condition(
        graph_.choose(value.nodes[0], graph_.constant(0), graph_.constant(1)));
  }

  static bool compares(const Token& token) {
    return token.is("<") || token.is("<=") || token.is(">") || token.is(">=");
  }

  ExpressionValue comparison() {
    ExpressionValue left = sum();
    if (!compares(lexer_.next())) return left;
    const Token sign = lexer_.take();
    const ExpressionValue right = sum();
    if (!left.is_number() || !right.is_number()) fail_types(sign, left, right, "two numbers");
    if (compares(lexer_.next()))
      fail(lexer_.next().offset, "a comparison has two sides", "write a < b and b < c");
    const bool swapped = sign.text[0] == '>';
    const NodeId a = swapped ? right.nodes[0] : left.nodes[0];
    const NodeId b = swapped ? left.nodes[0] : right.nodes[0];
    return ExpressionValue::condition(sign.text.size() == 1 ? graph_.less(a, b)
                                                            : graph_.less_equal(a, b));
  }

  // Arithmetic.

  [[noreturn]] static void fail_types(const Token& sign, const ExpressionValue& left,
                                      const ExpressionValue& right, std::string_view wanted,
                                      std::string hint = {}) {
    fail(sign.offset,
         fmt::format("'{}' takes {}; both sides: {} and {}", sign.text, wanted, left.type(),
                     right.type()),
         std::move(hint));
  }

  /// Returns the value; fails if one of its constants is not finite.
  ExpressionValue finite(ExpressionValue value, int offset, std::string_view what) const {
    for (const NodeId node : value.nodes)
      if (const auto constant = graph_.constant_of(node); constant && !std::isfinite(*constant))
        fail(offset, fmt::format("the value of '{}' is not finite", what));
    return value;
  }

  ExpressionValue sum() {
    ExpressionValue left = product();
    while (lexer_.next().is("+") || lexer_.next().is("-")) {
      const Token sign = lexer_.take();
      const ExpressionValue right = product();
      if (left.kind == Kind::kCondition || !left.has_type_of(right))
        fail_types(sign, left, right, "two numbers or two vectors of one size");
      for (int i = 0; i < left.size(); ++i)
        left.nodes[i] = sign.text == "+" ? graph_.add(left.nodes[i], right.nodes[i])
                                         : graph_.subtract(left.nodes[i], right.nodes[i]);
      left = finite(plain(std::move(left)), sign.offset, sign.text);
    }
    return left;
  }

  ExpressionValue product() {
    ExpressionValue left = signed_factor();
    while (lexer_.next().is("*") || lexer_.next().is("/")) {
      const Token sign = lexer_.take();
      const ExpressionValue right = signed_factor();
      left = finite(sign.text == "*" ? times(sign, left, right) : over(sign, left, right),
                    sign.offset, sign.text);
    }
    return left;
  }

  ExpressionValue times(const Token& sign, const ExpressionValue& left,
                        const ExpressionValue& right) {
    if (left.kind == Kind::kVector && right.kind == Kind::kVector)
      fail_types(sign, left, right, "a number and a number or vector",
                 "products of vectors are dot(a, b) and cross(a, b)");
    if (left.kind == Kind::kCondition || right.kind == Kind::kCondition)
      fail_types(sign, left, right, "a number and a number or vector");
    const bool swapped = right.kind == Kind::kVector;
    ExpressionValue result = plain(swapped ? right : left);
    const NodeId factor = swapped ? left.nodes[0] : right.nodes[0];
    for (NodeId& node : result.nodes) node = graph_.multiply(node, factor);
    return result;
  }

  ExpressionValue over(const Token& sign, const ExpressionValue& left,
                       const ExpressionValue& right) {
    if (left.kind == Kind::kCondition || !right.is_number())
      fail_types(sign, left, right, "a number or vector, and a number");
    ExpressionValue result = plain(left);
    for (NodeId& node : result.nodes) node = graph_.divide(node, right.nodes[0]);
    return result;
  }

  ExpressionValue signed_factor() {
    if (!lexer_.next().is("-") && !lexer_.next().is("+")) return power();
    const Token sign = lexer_.take();
    const Level level(depth_, sign);
    ExpressionValue value = signed_factor();
    if (value.kind == Kind::kCondition)
      fail(sign.offset, fmt::format("'{}' takes a number or a vector, not a condition", sign.text));
    value = plain(std::move(value));
    if (sign.text == "-")
      for (NodeId& node : value.nodes) node = graph_.negate(node);
    return value;
  }

  ExpressionValue power() {
    ExpressionValue base = postfix();
    if (!lexer_.next().is("^")) return base;
    const Token sign = lexer_.take();
    const Level level(depth_, sign);
    const ExpressionValue exponent = signed_factor();
    if (!base.is_number() || !exponent.is_number())
      fail_types(sign, base, exponent, "two numbers",
                 base.kind == Kind::kVector ? "the square of a vector's length is dot(v, v)" : "");
    return finite(number(graph_.power(base.nodes[0], exponent.nodes[0])), sign.offset, sign.text);
  }

  /// Drops the unit and the parts of an operand, which do not apply to the result.
  static ExpressionValue plain(ExpressionValue value) {
    value.unit.clear();
    value.parts.clear();
    return value;
  }

  // Parts of vectors.

  ExpressionValue postfix() {
    ExpressionValue value = primary();
    for (;;) {
      if (lexer_.next().is("[")) {
        const Token bracket = lexer_.next();
        const Token name = lexer_.take_bracketed();
        if (name.kind == Token::Kind::kEnd) fail_at_end(name, bracket);
        value = part_of(value, name);
      } else if (lexer_.next().is(".")) {
        const Token dot = lexer_.take();
        if (lexer_.next().kind != Token::Kind::kName)
          fail(dot.offset, "expected the name of a part behind '.'");
        value = part_of(value, lexer_.take());
      } else {
        return value;
      }
    }
  }

  ExpressionValue part_of(const ExpressionValue& value, const Token& token) const {
    if (value.kind != Kind::kVector && value.parts.empty())
      fail(token.offset, fmt::format("a {} has no parts", value.type()));
    if (token.text.empty()) fail(token.offset, "expected an index or the name of a part");
    const std::vector<ExpressionValue::Part> parts = value.named_parts();
    for (const auto& part : parts)
      if (part.name == token.text) return value.part(part);
    if (token.text.find_first_not_of("0123456789") == std::string_view::npos)
      return numbered_part(value, token);
    std::vector<std::string> names;
    for (const auto& part : parts) names.push_back(part.name);
    fail(token.offset,
         fmt::format("unknown part '{}' of a {}", printable(token.text), value.type()),
         names.empty() ? "parts are given by an index, counted from 0"
                       : name_hint(token.text, names, "parts"));
  }

  static ExpressionValue numbered_part(const ExpressionValue& value, const Token& token) {
    constexpr std::size_t kDigits = 6;
    const int index =
        token.text.size() > kDigits ? value.size() : std::stoi(std::string(token.text));
    if (index < value.size()) return value.part({"", index});
    fail(token.offset, fmt::format("there is no number {} in a {}: they are counted from 0",
                                   token.text.substr(0, kDigits + 1), value.type()));
  }

  // Numbers, names, calls, parentheses and vectors.

  static bool joins_conditions(const Token& token) {
    return token.is("and") || token.is("or") || token.is("not");
  }

  ExpressionValue primary() {
    const Token token = lexer_.take();
    const Level level(depth_, token);
    if (graph_.size() > kMostOperations)
      fail(token.offset,
           fmt::format("the expressions have more than {} operations", kMostOperations),
           "these are too many to be evaluated in every iteration");
    if (token.kind == Token::Kind::kNumber) return number(graph_.constant(token.number));
    if (token.kind == Token::Kind::kEnd)
      fail(token.offset, "the expression ends where a number, a name or '(' is expected");
    if (token.is("(")) {
      ExpressionValue value = alternative();
      close(token, ")");
      return value;
    }
    if (token.is("[")) return vector(token);
    if (token.kind == Token::Kind::kName && !joins_conditions(token))
      return lexer_.next().is("(") ? call(token) : named(token);
    fail(token.offset, fmt::format("expected a number, a name or '(' instead of '{}'", token.text));
  }

  void close(const Token& opened, std::string_view with) {
    const Token token = lexer_.next();
    if (token.kind == Token::Kind::kEnd) fail_at_end(token, opened);
    if (!token.is(with)) {
      if (token.is(",") || token.is(")") || token.is("]"))
        fail(token.offset, fmt::format("expected '{}' instead of '{}'", with, token.text));
      fail_at_operator(token);
    }
    lexer_.take();
  }

  ExpressionValue vector(const Token& opened) {
    if (lexer_.next().is("]")) fail(lexer_.next().offset, "a vector has at least one number");
    std::vector<NodeId> nodes;
    for (;;) {
      const int offset = lexer_.next().offset;
      const ExpressionValue value = alternative();
      if (value.kind == Kind::kCondition)
        fail(offset, "a vector is made of numbers and vectors, and this is a condition");
      nodes.insert(nodes.end(), value.nodes.begin(), value.nodes.end());
      if (nodes.size() > kMostVectorNumbers)
        fail(offset, fmt::format("a vector has at most {} numbers", kMostVectorNumbers));
      if (!lexer_.next().is(",")) break;
      lexer_.take();
    }
    close(opened, "]");
    return ExpressionValue::vector(std::move(nodes));
  }

  ExpressionValue named(const Token& token) const {
    if (const ExpressionValue* value = scope_.find(token.text)) return *value;
    if (const ExpressionConstant* constant = find_expression_constant(token.text))
      return ExpressionValue::number(graph_.constant(constant->value));
    if (find_expression_function(token.text) || scope_.find_table(token.text))
      fail(token.offset,
           fmt::format("'{}' is a function: its arguments follow in parentheses", token.text));
    fail(token.offset, fmt::format("unknown name '{}'", token.text), hint_of_name(token));
  }

  /// Suggests an intended name for an unknown one.
  std::string hint_of_name(const Token& token) const {
    if (std::string hint = scope_.explanation_of(token.text); !hint.empty()) return hint;
    const std::string_view part = scope_.part_at(text_.substr(token.offset));
    std::string hint;
    for (const std::string& whole : scope_.names_with_part(part))
      hint += fmt::format("{}'{}[{}]'", hint.empty() ? "write " : " or ", whole, part);
    if (hint.empty()) hint = foreign_name_hint(token.text);
    return hint.empty() ? name_hint(token.text, scope_.value_names(), "names") : hint;
  }

  struct Argument {
    int offset;
    ExpressionValue value;
  };

  /// Reports a name before parentheses that is not a function.
  [[noreturn]] void fail_at_call(const Token& name) const {
    if (scope_.find(name.text) || find_expression_constant(name.text))
      fail(name.offset, fmt::format("'{}' is not a function", name.text),
           "a product is written with '*'");
    const std::string_view foreign = foreign_function_hint(name.text);
    fail(name.offset, fmt::format("unknown function '{}'", name.text),
         foreign.empty() ? name_hint(name.text, scope_.function_names(), "functions")
                         : std::string(foreign));
  }

  /// Parses the arguments in parentheses.
  std::vector<Argument> take_arguments() {
    const Token opened = lexer_.take();
    std::vector<Argument> arguments;
    for (bool more = !lexer_.next().is(")"); more;) {
      const int offset = lexer_.next().offset;
      arguments.push_back({offset, alternative()});
      more = lexer_.next().is(",");
      if (more) lexer_.take();
    }
    close(opened, ")");
    return arguments;
  }

  ExpressionValue call(const Token& name) {
    const ExpressionFunction* function = find_expression_function(name.text);
    const ExpressionScope::Table* table = scope_.find_table(name.text);
    if (!function && !table) fail_at_call(name);
    const std::vector<Argument> arguments = take_arguments();
    ExpressionValue value =
        function ? apply(*function, name, arguments) : look_up(*table, name, arguments);
    return finite(std::move(value), name.offset, name.text);
  }

  static void check_count(const Token& name, std::size_t wanted, std::size_t given) {
    if (wanted == given) return;
    fail(name.offset, fmt::format("'{}' takes {} argument{}, not {}", name.text, wanted,
                                  wanted == 1 ? "" : "s", given));
  }

  /// True if a value is a number that is not known to be 0 or less.
  bool may_be_above_zero(const ExpressionValue& value) const {
    if (!value.is_number()) return false;
    const auto constant = graph_.constant_of(value.nodes[0]);
    return !constant || *constant > 0;
  }

  bool fits(ArgumentKind kind, const std::vector<Argument>& arguments, std::size_t i) const {
    const ExpressionValue& value = arguments[i].value;
    const auto is_vector = [&](int size) {
      return value.kind == Kind::kVector && value.size() == size;
    };
    switch (kind) {
      case ArgumentKind::kNumber:
        return value.is_number();
      case ArgumentKind::kAboveZero:
        return may_be_above_zero(value);
      case ArgumentKind::kVector:
        return value.kind == Kind::kVector;
      case ArgumentKind::kSameVector:
        return is_vector(arguments[0].value.size());
      case ArgumentKind::kVector3:
        return is_vector(3);
      case ArgumentKind::kQuaternion:
        return is_vector(4);
      case ArgumentKind::kCondition:
        return value.kind == Kind::kCondition;
      case ArgumentKind::kAny:
        return value.kind != Kind::kCondition;
      case ArgumentKind::kSame:
        return value.has_type_of(arguments[i - 1].value);
    }
    return false;
  }

  /// Reports why an argument does not fit.
  [[noreturn]] static void fail_at_argument(const ExpressionFunction::Argument& wanted,
                                            const Token& name,
                                            const std::vector<Argument>& arguments, std::size_t i) {
    const Argument& given = arguments[i];
    if (wanted.kind == ArgumentKind::kSame || wanted.kind == ArgumentKind::kSameVector)
      fail(given.offset, fmt::format("'{}' takes two of one type; both: {} and {}", name.text,
                                     arguments[i - 1].value.type(), given.value.type()));
    const bool too_small = wanted.kind == ArgumentKind::kAboveZero && given.value.is_number();
    fail(given.offset,
         fmt::format("argument '{}' of '{}' has to be {}", wanted.name, name.text,
                     too_small ? "above 0"
                               : fmt::format("{}, not a {}", argument_kind_name(wanted.kind),
                                             given.value.type())));
  }

  /// Checks that constant quaternions have unit length, and warns about widths that are not
  /// constant and might become 0.
  void check_numbers(const ExpressionFunction::Argument& wanted, const Token& name,
                     const Argument& given) {
    if (wanted.kind == ArgumentKind::kAboveZero && !graph_.constant_of(given.value.nodes[0]))
      warnings_.push_back({given.offset,
                           fmt::format("the argument '{}' of '{}' is not constant: it has to stay "
                                       "above 0",
                                       wanted.name, name.text),
                           ""});
    if (wanted.kind != ArgumentKind::kQuaternion) return;
    double square = 0;
    for (const NodeId node : given.value.nodes) {
      const auto number = graph_.constant_of(node);
      if (!number) return;
      square += *number * *number;
    }
    constexpr double kTolerance = 1e-6;
    if (std::abs(square - 1) > kTolerance)
      fail(given.offset,
           fmt::format("the quaternion '{}' of '{}' has length {:.6g}, not 1", wanted.name,
                       name.text, std::sqrt(square)),
           "the order is x, y, z, w");
  }

  ExpressionValue apply(const ExpressionFunction& function, const Token& name,
                        const std::vector<Argument>& arguments) {
    check_count(name, function.arguments.size(), arguments.size());
    std::vector<ExpressionValue> values;
    for (std::size_t i = 0; i < arguments.size(); ++i) {
      const ExpressionFunction::Argument& wanted = function.arguments[i];
      if (!fits(wanted.kind, arguments, i)) fail_at_argument(wanted, name, arguments, i);
      check_numbers(wanted, name, arguments[i]);
      values.push_back(plain(arguments[i].value));
    }
    if (!function.kink.empty())
      warnings_.push_back({name.offset, fmt::format("'{}' {}", name.text, function.kink), ""});
    return function.apply(graph_, values);
  }

  ExpressionValue look_up(const ExpressionScope::Table& table, const Token& name,
                          const std::vector<Argument>& arguments) {
    check_count(name, static_cast<std::size_t>(table.arguments), arguments.size());
    for (const Argument& argument : arguments)
      if (!argument.value.is_number())
        fail(argument.offset, fmt::format("'{}' is a table of numbers, and this is a {}", name.text,
                                          argument.value.type()));
    return number(graph_.table({table.index}, arguments.front().value.nodes[0],
                               arguments.back().value.nodes[0]));
  }

  std::string_view text_;
  ExpressionLexer lexer_;
  const ExpressionScope& scope_;
  ExpressionGraph& graph_;
  std::vector<ExpressionMessage>& warnings_;
  int depth_ = 0;
};

}  // namespace

ParsedExpression parse_expression(std::string_view text, const ExpressionScope& scope,
                                  ExpressionGraph& graph) {
  ParsedExpression parsed;
  if (text.size() > kMostExpressionBytes) {
    parsed.error = {static_cast<int>(kMostExpressionBytes),
                    fmt::format("an expression has at most {} bytes", kMostExpressionBytes),
                    "parts of it can be definitions with a name"};
    return parsed;
  }
  try {
    parsed.value = Parser(text, scope, graph, parsed.warnings).whole();
  } catch (const ExpressionError& error) {
    parsed.error = error.message;
  }
  return parsed;
}

}  // namespace conddp
