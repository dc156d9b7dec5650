#include "systems/expressions/lexer.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "base/text/strict_number.hpp"
#include "base/text/utf8.hpp"

namespace conddp {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr std::array<std::string_view, 17> kSymbols = {
    "<=", ">=", "<", ">", "+", "-", "*", "/", "^", "(", ")", "[", "]", ",", ".", "{", "}"};

/// An operator of other languages, and a hint about its spelling here.
struct Foreign {
  std::string_view text;
  std::string_view hint;
};
constexpr std::array<Foreign, 17> kForeign = {{{"**", "a power is written a^b"},
                                               {"==", "numbers are compared by <, <=, > or >="},
                                               {"!=", "numbers are compared by <, <=, > or >="},
                                               {"=", "an expression has no '='"},
                                               {"&&", "write 'and'"},
                                               {"||", "write 'or'"},
                                               {"!", "write 'not'"},
                                               {"?", "write if(condition, a, b)"},
                                               {"%", "there is no remainder"},
                                               {";", "arguments are separated by ','"},
                                               {"\u2212", "write '-'"},
                                               {"\u00b7", "write '*'"},
                                               {"\u00d7", "write '*'"},
                                               {"\u00b2", "write '^2'"},
                                               {"\u00b3", "write '^3'"},
                                               {"\u03c0", "write 'pi'"},
                                               {"\u2264", "write '<='"}}};

/// True if a non-empty text begins with a digit, or with a point followed by a digit.
bool begins_number(std::string_view text) {
  return is_digit(text[0]) || (text[0] == '.' && text.size() > 1 && is_digit(text[1]));
}

int skip_digits(std::string_view text, int at) {
  const int size = static_cast<int>(text.size());
  while (at < size && (is_digit(text[at]) || text[at] == '.')) ++at;
  return at;
}

/// Position of the digits of an exponent that starts at `at`; the size of the text if none starts
/// there.
int find_exponent(std::string_view text, int at) {
  const int size = static_cast<int>(text.size());
  const auto has = [&](int i, std::string_view characters) {
    return i < size && characters.find(text[i]) != characters.npos;
  };
  if (!has(at, "eE")) return size;
  const int digits = has(at + 1, "+-") ? at + 2 : at + 1;
  return has(digits, "0123456789") ? digits : size;
}

}  // namespace

bool is_name_part(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || is_digit(c);
}

ExpressionToken ExpressionLexer::take() {
  const ExpressionToken token = next_;
  advance();
  return token;
}

ExpressionToken ExpressionLexer::take_bracketed() {
  std::size_t first = static_cast<std::size_t>(at_), last = text_.find(']', first);
  if (last == std::string_view::npos) return {.offset = static_cast<int>(text_.size())};
  at_ = static_cast<int>(last) + 1;
  while (first < last && is_space(text_[first])) ++first;
  while (last > first && is_space(text_[last - 1])) --last;
  advance();
  return {.kind = ExpressionToken::Kind::kName,
          .offset = static_cast<int>(first),
          .text = text_.substr(first, last - first)};
}

void ExpressionLexer::advance() {
  const int size = static_cast<int>(text_.size());
  while (at_ < size && is_space(text_[at_])) ++at_;
  next_ = {.offset = at_};
  if (at_ == size) return;
  if (begins_number(text_.substr(at_))) return read_number();
  if (!is_name_part(text_[at_])) return read_symbol();
  int end = at_;
  while (end < size && is_name_part(text_[end])) ++end;
  next_.kind = ExpressionToken::Kind::kName;
  next_.text = text_.substr(at_, end - at_);
  at_ = end;
}

void ExpressionLexer::read_number() {
  const int size = static_cast<int>(text_.size());
  int end = skip_digits(text_, at_);
  if (const int exponent = find_exponent(text_, end); exponent < size)
    end = skip_digits(text_, exponent);
  const std::string_view digits = text_.substr(at_, end - at_);
  const ParsedNumber parsed = parse_number(digits);
  if (!parsed.value) throw ExpressionError({at_, parsed.defect, ""});
  if (end < size && is_name_part(text_[end]))
    throw ExpressionError({end, fmt::format("'{}' right behind a number", text_[end]),
                           "a product is written with '*'"});
  next_.kind = ExpressionToken::Kind::kNumber;
  next_.text = digits;
  next_.number = *parsed.value;
  at_ = end;
}

void ExpressionLexer::read_symbol() {
  const std::string_view rest = text_.substr(at_);
  const auto begins = [&](std::string_view symbol) { return rest.starts_with(symbol); };
  for (const Foreign& foreign : kForeign)
    if (begins(foreign.text))
      throw ExpressionError(
          {at_, fmt::format("unexpected '{}'", foreign.text), std::string(foreign.hint)});
  const auto symbol = std::find_if(kSymbols.begin(), kSymbols.end(), begins);
  if (symbol == kSymbols.end()) {
    std::size_t end = 1;
    while (end < rest.size() && !starts_character(rest[end])) ++end;
    throw ExpressionError(
        {at_, fmt::format("unexpected character '{}'", printable(rest.substr(0, end))), ""});
  }
  next_.kind = ExpressionToken::Kind::kSymbol;
  next_.text = *symbol;
  at_ += static_cast<int>(symbol->size());
}

}  // namespace conddp
