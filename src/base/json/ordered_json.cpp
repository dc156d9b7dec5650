#include "base/json/ordered_json.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

namespace conddp {
namespace {

/// Limits of numbers without exponent, as in the JSON library.
constexpr double kSmallestPlain = 1e-4, kLargestPlain = 1e15;

/// Always writes a point or an exponent, to distinguish the number from an integer.
void append_number(double value, std::string& text) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  const double size = std::abs(value);
  const bool plain = size == 0 || (size >= kSmallestPlain && size < kLargestPlain);
  std::array<char, 32> buffer;
  const char* const end =
      std::to_chars(buffer.begin(), buffer.end(), value,
                    plain ? std::chars_format::fixed : std::chars_format::scientific)
          .ptr;
  const std::string_view shortest(buffer.data(), end - buffer.data());
  text += shortest;
  if (plain && shortest.find('.') == shortest.npos) text += ".0";
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
                      [](const OrderedJson& part) { return part.is_structured(); });
}

/// True for scalars, empty values and flat lists. Flat objects in a list are table rows and also
/// stay on one line.
bool stays_on_one_line(const OrderedJson& value, bool in_list) {
  return !value.is_structured() || value.empty() ||
         (is_flat(value) && (value.is_array() || in_list));
}

void write(const OrderedJson& value, int indent, bool in_list, std::string& text) {
  constexpr BadBytes kBad = BadBytes::strict;
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
