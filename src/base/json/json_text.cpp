#include "base/json/json_text.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "base/json/number_block.hpp"

namespace conddp {
namespace {

/// The shortest digits that reproduce a number, and the count of digits before its point; negative
/// if zeros follow the point.
struct Digits {
  std::array<char, 24> digits;
  int count = 0;
  int point = 0;
};

/// `value` must be positive and finite.
Digits shortest_digits(double value) {
  std::array<char, 32> buffer;
  const char* const end =
      std::to_chars(buffer.begin(), buffer.end(), value, std::chars_format::scientific).ptr;
  const char* const exponent = std::find(buffer.cbegin(), end, 'e');
  Digits found;
  for (const char* c = buffer.data(); c < exponent; ++c)
    if (*c != '.') found.digits[found.count++] = *c;
  std::from_chars(exponent + (exponent[1] == '+' ? 2 : 1), end, found.point);
  ++found.point;
  return found;
}

/// Appends scientific notation such as "1e-09".
void append_scientific(const Digits& number, std::string& text) {
  text += number.digits[0];
  if (number.count > 1) (text += '.').append(number.digits.data() + 1, number.count - 1);
  const int exponent = number.point - 1;
  text += exponent < 0 ? "e-" : "e+";
  if (std::abs(exponent) < 10) text += '0';
  text += std::to_string(std::abs(exponent));
}

/// Limits of numbers without exponent: digits before the point, and zeros after it.
constexpr int kMostBefore = 15, kMostZeros = 3;
constexpr double kLargestPlain = 1e15, kSmallestPlain = 1e-4;

/// Appends a number that std::to_chars writes without exponent, the usual case. Otherwise returns
/// false.
bool append_plain(double value, std::string& text) {
  if (!(std::abs(value) >= kSmallestPlain && std::abs(value) < kLargestPlain)) return false;
  std::array<char, 32> buffer;
  const char* const end = std::to_chars(buffer.begin(), buffer.end(), value).ptr;
  const std::string_view shortest(buffer.data(), end - buffer.data());
  if (shortest.find('e') != shortest.npos) return false;
  text += shortest;
  if (shortest.find('.') == shortest.npos) text += ".0";
  return true;
}

/// Always writes a point or an exponent, to distinguish the number from an integer.
void append_number(double value, std::string& text) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  if (append_plain(value, text)) return;
  if (std::signbit(value)) text += '-';
  if (value == 0) {
    text += "0.0";
    return;
  }
  const Digits number = shortest_digits(std::abs(value));
  const char* const digits = number.digits.data();
  if (number.point > kMostBefore || number.point < -kMostZeros) {
    append_scientific(number, text);
  } else if (number.point <= 0) {
    text.append("0.").append(-number.point, '0').append(digits, number.count);
  } else if (number.point < number.count) {
    text.append(digits, number.point) += '.';
    text.append(digits + number.point, number.count - number.point);
  } else {
    text.append(digits, number.count).append(number.point - number.count, '0').append(".0");
  }
}

template <class Integer>
void append_integer(Integer value, std::string& text) {
  std::array<char, 24> buffer;
  text.append(buffer.data(), std::to_chars(buffer.begin(), buffer.end(), value).ptr);
}

bool is_plain(std::string_view string) {
  return std::all_of(string.begin(), string.end(),
                     [](char c) { return c >= ' ' && c < '\x7f' && c != '"' && c != '\\'; });
}

/// Treatment of bytes that are not UTF-8.
using BadBytes = OrderedJson::error_handler_t;

void append_string(const std::string& string, BadBytes bad, std::string& text) {
  if (is_plain(string))
    ((text += '"') += string) += '"';
  else
    text += OrderedJson(string).dump(-1, ' ', false, bad);
}

/// Appends a list of `count` numbers of a block.
void append_numbers(const NumberBlock& block, std::size_t first, std::size_t count,
                    std::string& text) {
  text += '[';
  for (std::size_t i = first; i < first + count; ++i) {
    if (i > first) text += ',';
    append_number(block.number(i), text);
  }
  text += ']';
}

/// Text before, between and after the rows of a table.
struct TableMarks {
  std::string before, between, behind;
};

void append_block(const NumberBlock& block, const TableMarks& marks, std::string& text) {
  if (!block.is_table()) return append_numbers(block, 0, block.size(), text);
  text += marks.before;
  for (std::size_t row = 0; row < block.size(); ++row) {
    if (row > 0) text += marks.between;
    append_numbers(block, row * block.columns(), block.columns(), text);
  }
  text += marks.behind;
}

/// Writes a value on one line, without blanks.
void append_compact(const OrderedJson& value, BadBytes bad, std::string& text) {
  using Type = OrderedJson::value_t;
  switch (value.type()) {
    case Type::number_float:
      return append_number(value.get_ref<const double&>(), text);
    case Type::number_integer:
      return append_integer(value.get_ref<const OrderedJson::number_integer_t&>(), text);
    case Type::number_unsigned:
      return append_integer(value.get_ref<const OrderedJson::number_unsigned_t&>(), text);
    case Type::string:
      return append_string(value.get_ref<const std::string&>(), bad, text);
    case Type::array:
    case Type::object:
      break;
    default:
      if (const auto block = NumberBlock::of(value))
        append_block(*block, {"[", ",", "]"}, text);
      else
        text += value.dump();
      return;
  }
  const bool object = value.is_object();
  char before = object ? '{' : '[';
  for (auto part = value.begin(); part != value.end(); ++part) {
    text += std::exchange(before, ',');
    if (object) {
      append_string(part.key(), bad, text);
      text += ':';
    }
    append_compact(*part, bad, text);
  }
  if (value.empty()) text += before;
  text += object ? '}' : ']';
}

bool is_flat(const OrderedJson& value) {
  return std::none_of(value.begin(), value.end(),
                      [](const OrderedJson& part) { return entries_of(part) || part.is_object(); });
}

/// True for scalars, empty values and flat lists. Flat objects in a list are table rows and also
/// stay on one line.
bool stays_on_one_line(const OrderedJson& value, bool in_list) {
  return !value.is_structured() || value.empty() ||
         (is_flat(value) && (value.is_array() || in_list));
}

void write(const OrderedJson& value, int indent, bool in_list, std::string& text) {
  constexpr BadBytes kBad = BadBytes::strict;
  if (const auto block = NumberBlock::of(value); block && block->size() > 0) {
    const std::string line = '\n' + std::string(indent, ' ');
    return append_block(*block, {'[' + line + "  ", ',' + line + "  ", line + ']'}, text);
  }
  if (stays_on_one_line(value, in_list)) return append_compact(value, kBad, text);
  text += value.is_array() ? "[\n" : "{\n";
  bool first = true;
  for (auto part = value.begin(); part != value.end(); ++part) {
    if (!first) text += ",\n";
    first = false;
    text.append(indent + 2, ' ');
    if (value.is_object()) {
      append_string(part.key(), kBad, text);
      text += ": ";
    }
    write(*part, indent + 2, value.is_array(), text);
  }
  (text += '\n').append(indent, ' ') += value.is_array() ? ']' : '}';
}

}  // namespace

std::string json_text(const OrderedJson& value) {
  std::string text;
  write(value, 0, false, text);
  text += '\n';
  return text;
}

std::string compact_json(const OrderedJson& value) {
  std::string text;
  append_compact(value, BadBytes::replace, text);
  return text;
}

OrderedJson eight_digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0 || value == std::round(value)) return value;
  const double scale = std::pow(10.0, 7 - std::floor(std::log10(std::abs(value))));
  const double rounded = std::round(value * scale) / scale;
  return std::isfinite(rounded) ? rounded : value;
}

}  // namespace conddp
