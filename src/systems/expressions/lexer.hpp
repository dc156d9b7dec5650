#pragma once

#include <exception>
#include <string>
#include <string_view>
#include <utility>

namespace conddp {

/// What is wrong with an expression, or worth knowing, and at which byte of its text.
struct ExpressionMessage {
  int offset = 0;
  std::string message;
  std::string hint;  ///< may be empty
};

/// Ends the reading of an expression; only parse_expression() meets it.
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
  double number = 0;      ///< of kNumber

  bool is(std::string_view what) const {
    return (kind == Kind::kSymbol || kind == Kind::kName) && text == what;
  }
};

/// Whether a character may be in a name of expressions: a letter, a digit or '_'.
bool is_name_part(char c);

/// Cuts an expression into numbers, names and symbols, one ahead. Throws ExpressionError at what
/// is none of these.
class ExpressionLexer {
 public:
  explicit ExpressionLexer(std::string_view text) : text_(text) { advance(); }

  const ExpressionToken& next() const { return next_; }
  /// The next token, which it leaves behind.
  ExpressionToken take();
  /// Where '[' is next: the text up to ']' as a name, without spaces around, and leaves all behind.
  /// kEnd where nothing closes it.
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
