#include "systems/expressions/scope.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/text/utf8.hpp"
#include "systems/expressions/functions.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {
namespace {

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

}  // namespace conddp
