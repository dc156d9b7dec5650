#include "systems/expressions/scope.hpp"

#include <algorithm>
#include <array>
#include <span>

#include <fmt/format.h>

#include "base/text/utf8.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {
namespace {

struct ForeignWord {
  std::string_view word;
  std::string_view hint;
};

constexpr std::string_view kSteps =
    "there is no rounding and no remainder; smooth_step(a, width) is a step";
constexpr std::string_view kChoice = "write if(condition, a, b)";
constexpr std::string_view kPhaseTime = "the time of the phase is 'phase_time'";
constexpr std::string_view kFinalTime = "the time of the last node is 'final_time'";
constexpr std::string_view kLimit = "write smooth_min(smooth_max(a, lower, width), upper, width)";

constexpr ForeignWord kNames[] = {{"e", "the exponential function is exp(a)"},
                                  {"True", "conditions are comparisons: a < b"},
                                  {"False", "conditions are comparisons: a < b"},
                                  {"true", "conditions are comparisons: a < b"},
                                  {"false", "conditions are comparisons: a < b"},
                                  {"inf", "expressions have finite numbers"},
                                  {"t_phase", kPhaseTime},
                                  {"tf", kFinalTime},
                                  {"t_f", kFinalTime},
                                  {"t_final", kFinalTime}};

constexpr ForeignWord kFunctions[] = {{"ln", "write log(a), the natural logarithm"},
                                      {"log2", "write log(a)/log(2)"},
                                      {"exp2", "write 2^a"},
                                      {"square", "write a^2"},
                                      {"sqr", "write a^2"},
                                      {"power", "write a^b"},
                                      {"cbrt", "write a^(1/3)"},
                                      {"sec", "write 1/cos(a)"},
                                      {"csc", "write 1/sin(a)"},
                                      {"cot", "write 1/tan(a)"},
                                      {"arcsin", "write asin(a)"},
                                      {"arccos", "write acos(a)"},
                                      {"arctan", "write atan(a)"},
                                      {"arctan2", "write atan2(y, x)"},
                                      {"fabs", "write smooth_abs(a, width)"},
                                      {"sgn", "write 2*smooth_step(a, width) - 1"},
                                      {"step", "write smooth_step(a, width)"},
                                      {"heaviside", "write smooth_step(a, width)"},
                                      {"sigmoid", "write smooth_step(a, width)"},
                                      {"relu", "write smooth_max(a, 0, width)"},
                                      {"clip", kLimit},
                                      {"clamp", kLimit},
                                      {"sat", kLimit},
                                      {"where", kChoice},
                                      {"ifelse", kChoice},
                                      {"if_else", kChoice},
                                      {"norm_2", "write norm(v)"},
                                      {"sum", "write dot(v, [1, 1, 1])"},
                                      {"sumsqr", "write dot(v, v)"},
                                      {"floor", kSteps},
                                      {"ceil", kSteps},
                                      {"round", kSteps},
                                      {"mod", kSteps},
                                      {"fmod", kSteps}};

constexpr ForeignWord kOperators[] = {{"if", kChoice}, {"mod", kSteps}, {"div", kSteps}};

std::string_view find_hint(std::span<const ForeignWord> words, std::string_view word) {
  const auto found = std::ranges::find(words, word, &ForeignWord::word);
  return found == words.end() ? std::string_view() : found->hint;
}

constexpr std::array<std::string_view, 3> kWords = {"and", "or", "not"};

template <class Pairs>
auto find_in(Pairs& pairs, std::string_view name) {
  return std::find_if(pairs.begin(), pairs.end(),
                      [&](const auto& pair) { return pair.first == name; });
}

}  // namespace

bool is_expression_name(std::string_view text) {
  const bool digit = !text.empty() && text[0] >= '0' && text[0] <= '9';
  return !text.empty() && !digit && std::all_of(text.begin(), text.end(), is_name_part);
}

std::string ExpressionScope::defect_of(std::string_view name) const {
  if (!is_expression_name(name))
    return fmt::format(
        "'{}' is not a name of expressions: letters, digits and '_', no digit at first",
        printable(name));
  if (std::find(kWords.begin(), kWords.end(), name) != kWords.end())
    return fmt::format("'{}' is a word of the expression language", name);
  if (find_expression_function(name))
    return fmt::format("'{}' is a function of the expression language", name);
  if (find_expression_constant(name))
    return fmt::format("'{}' is a constant of the expression language", name);
  if (find(name) || find_table(name)) return fmt::format("the name '{}' is taken", name);
  return "";
}

void ExpressionScope::add(std::string name, ExpressionValue value) {
  values_.emplace_back(std::move(name), std::move(value));
}

void ExpressionScope::add_table(std::string name, int table, int arguments) {
  tables_.emplace_back(std::move(name), Table{table, arguments});
}

void ExpressionScope::explain(std::string name, std::string why) {
  explanations_.emplace_back(std::move(name), std::move(why));
}

std::string ExpressionScope::explanation_of(std::string_view name) const {
  const auto found = find_in(explanations_, name);
  return found == explanations_.end() ? "" : found->second;
}

const ExpressionValue* ExpressionScope::find(std::string_view name) const {
  const auto found = find_in(values_, name);
  return found == values_.end() ? nullptr : &found->second;
}

const ExpressionScope::Table* ExpressionScope::find_table(std::string_view name) const {
  const auto found = find_in(tables_, name);
  return found == tables_.end() ? nullptr : &found->second;
}

std::vector<std::string> ExpressionScope::value_names() const {
  std::vector<std::string> names;
  for (const auto& [name, value] : values_) names.push_back(name);
  for (const ExpressionConstant& constant : expression_constants())
    names.emplace_back(constant.name);
  return names;
}

std::vector<std::string> ExpressionScope::names_with_part(std::string_view part) const {
  std::vector<std::string> names;
  for (const auto& [name, value] : values_)
    if (std::ranges::find(value.parts, part, &ExpressionValue::Part::name) != value.parts.end())
      names.push_back(name);
  return names;
}

std::string_view ExpressionScope::part_at(std::string_view text) const {
  std::size_t longest = 0;
  for (const auto& [name, value] : values_)
    for (const ExpressionValue::Part& part : value.parts) {
      const std::size_t size = part.name.size();
      if (size <= longest || !text.starts_with(part.name)) continue;
      if (size == text.size() || !is_name_part(text[size])) longest = size;
    }
  return text.substr(0, longest);
}

std::vector<std::string> ExpressionScope::function_names() const {
  std::vector<std::string> names;
  for (const auto& [name, table] : tables_) names.push_back(name);
  for (const ExpressionFunction& function : expression_functions())
    names.emplace_back(function.name);
  return names;
}

std::string_view foreign_name_hint(std::string_view name) { return find_hint(kNames, name); }
std::string_view foreign_function_hint(std::string_view name) {
  return find_hint(kFunctions, name);
}
std::string_view foreign_operator_hint(std::string_view word) {
  return find_hint(kOperators, word);
}

}  // namespace conddp
