#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <utility>

namespace conddp {

/// An error or a warning about an expression, with a byte offset into its text.
struct ExpressionMessage {
  int offset = 0;
  std::string message;
  std::string hint;  ///< may be empty
};

/// Aborts reading an expression; parse_expression() catches it.
struct ExpressionError : std::exception {
  explicit ExpressionError(ExpressionMessage what_is_wrong) : message(std::move(what_is_wrong)) {}
  const char* what() const noexcept override { return message.message.c_str(); }
  ExpressionMessage message;
};

/// A piece of an expression's text.
struct ExpressionToken {
  enum class Kind { kNumber, kName, kSymbol, kEnd };
  Kind kind = Kind::kEnd;
  int offset = 0;
  std::string_view text;  ///< empty at the end
  double number = 0;      ///< value of a kNumber

  bool is(std::string_view what) const {
    return (kind == Kind::kSymbol || kind == Kind::kName) && text == what;
  }
};

/// True if a character may be part of a name in expressions: a letter, a digit or '_'.
bool is_name_part(char c);

/// Splits an expression into numbers, names and symbols with a lookahead of one token. Throws
/// ExpressionError at anything else.
class ExpressionLexer {
 public:
  explicit ExpressionLexer(std::string_view text) : text_(text) { advance(); }

  const ExpressionToken& next() const { return next_; }
  /// Returns the next token and advances.
  ExpressionToken take();
  /// Called if '[' is next: returns the text up to ']' as a name, without surrounding spaces, and
  /// advances past the bracket. Returns kEnd if the bracket is not closed.
  ExpressionToken take_bracketed();

 private:
  void advance();
  void read_number();
  void read_symbol();

  std::string_view text_;
  int at_ = 0;
  ExpressionToken next_;
};

}  // namespace conddp
