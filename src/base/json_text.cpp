#include "base/json_text.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

bool is_flat(const OrderedJson& value) {
  return std::none_of(value.begin(), value.end(),
                      [](const OrderedJson& part) { return part.is_structured(); });
}

/// Objects inside a list are rows of a table and stay on one line.
void write(const OrderedJson& value, int indent, bool in_list, std::string& text) {
  if (!value.is_structured() || value.empty() ||
      (is_flat(value) && (value.is_array() || in_list))) {
    text += value.dump();
    return;
  }
  const std::string margin(indent + 2, ' ');
  text += value.is_array() ? "[\n" : "{\n";
  bool first = true;
  for (auto part = value.begin(); part != value.end(); ++part) {
    if (!first) text += ",\n";
    first = false;
    text += margin;
    if (value.is_object()) text += OrderedJson(part.key()).dump() + ": ";
    write(*part, indent + 2, value.is_array(), text);
  }
  text += '\n' + std::string(indent, ' ') + (value.is_array() ? ']' : '}');
}

}  // namespace

std::string json_text(const OrderedJson& value) {
  std::string text;
  write(value, 0, false, text);
  return text + '\n';
}

OrderedJson eight_digits(double value) {
  if (!std::isfinite(value)) return nullptr;
  if (value == 0 || value == std::round(value)) return value;
  const double scale = std::pow(10.0, 7 - std::floor(std::log10(std::abs(value))));
  const double rounded = std::round(value * scale) / scale;
  return std::isfinite(rounded) ? rounded : value;
}

}  // namespace conddp
