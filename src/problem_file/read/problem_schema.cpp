#include "problem_file/read/problem_schema.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem_file/lower/free_parameters.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {

const std::string_view kAutoMeaning =
    "the default, by the problem: ipddp and ipopt for contact-implicit problems, altro, proxddp "
    "and "
    "ipopt one after the other where there are constraints besides bounds on the control, else "
    "box_fddp and ipopt (conddp check says which)";

namespace {

/// True for the schema of a number, or of a list of numbers.
bool is_numeric(const OrderedJson& schema) {
  if (!schema.contains("type")) return false;
  const OrderedJson& type = schema["type"];
  const auto has = [&](const char* word) {
    return type == word || (type.is_array() && std::ranges::find(type, word) != type.end());
  };
  return has("number") || has("integer") ||
         (has("array") && schema.contains("items") && is_numeric(schema["items"]));
}

/// Accepts a formula, "=2*mass", in place of a number or a list of numbers.
void accept_formulas(OrderedJson& part) {
  if (part.is_object() && is_numeric(part)) {
    OrderedJson& type = part["type"];
    if (!type.is_array()) type = OrderedJson::array({type});
    if (std::ranges::find(type, "string") == type.end()) {
      type.push_back("string");
      part["pattern"] = "^=";
    }
  }
  if (part.is_array())
    for (OrderedJson& item : part) accept_formulas(item);
  if (!part.is_object()) return;
  for (auto& [key, value] : part.items())
    if (key != "default" && key != "examples" && key != "enum" && key != "const")
      accept_formulas(value);
}

std::string flat(const OrderedJson& value) {
  if (value.is_number_float() && value.get<double>() == std::round(value.get<double>()))
    return fmt::format("{:.0f}", value.get<double>());
  if (!value.is_structured()) return value.dump();
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty() ? "" : ", ") +
            (value.is_object() ? OrderedJson(key).dump() + ": " : std::string()) + flat(item);
  return value.is_object() ? "{" + text + "}" : "[" + text + "]";
}

/// `head`: length of the key before the value.
std::string folded(const OrderedJson& value, std::size_t indent, std::size_t head) {
  constexpr std::size_t kWidth = 120;
  std::string line = flat(value);
  if (!value.is_structured() || indent + head + line.size() < kWidth) return line;
  std::string text;
  for (const auto& [key, item] : value.items()) {
    const std::string name = value.is_object() ? OrderedJson(key).dump() + ": " : "";
    text += fmt::format("{}{:{}}{}{}", text.empty() ? "\n" : ",\n", "", indent + 2, name,
                        folded(item, indent + 2, name.size()));
  }
  const std::string end = fmt::format("\n{:{}}", "", indent);
  return value.is_object() ? "{" + text + end + "}" : "[" + text + end + "]";
}

}  // namespace

OrderedJson problem_schema() {
  SchemaDefinitions definitions = value_definitions();
  map_schema<FreeParameter>(definitions);
  OrderedJson schema = {{"$schema", "http://json-schema.org/draft-07/schema#"},
                        {"$id", "https://conddp.invalid/schemas/problem.schema.json"}};
  schema.update(map_schema<ProblemSpec>(definitions));
  schema["definitions"] = std::move(definitions);
  accept_formulas(schema);
  return schema;
}

std::string schema_text(const OrderedJson& schema) { return folded(schema, 0, 0) + "\n"; }

}  // namespace conddp
