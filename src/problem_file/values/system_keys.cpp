#include "problem_file/values/system_keys.hpp"

#include "problem_file/spec/enum_names.hpp"
#include "problem_file/spec/system_fields.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {
namespace {

using Keys = std::vector<SystemKey>;

Keys keys_of(const DoubleIntegratorSpec& p) {
  return {{"dimension",
           "Number of independent axes",
           {{"type", "integer"}, {"minimum", 1}, {"maximum", 1000}, {"default", p.dimension}}}};
}

Keys keys_of(const LinearSpec& p) {
  const OrderedJson row = {{"type", "array"}, {"items", {{"type", "number"}}}};
  const OrderedJson matrix = {{"type", "array"}, {"items", row}};
  OrderedJson gives = {{"enum", OrderedJson::array()},
                       {"default", word_of(kLinearAnswerWords, p.gives)}};
  for (const auto& choice : kLinearAnswerWords) gives["enum"].push_back(choice.word);
  return {{"gives", "Whether A x + B u + c is the next state, or the rate of the state in time",
           std::move(gives)},
          {"A", "Square matrix by rows", matrix, true},
          {"B", "As many rows as A", matrix, true},
          {"c", "One number per row of A; zero by default", row}};
}

/// The accepted keys depend on each other; their schema is handwritten.
Keys keys_of(const ExpressionSystemSpec&) { return {}; }
Keys keys_of(const LibrarySystemSpec&) { return {}; }

template <class P>
Keys keys_of(const P& p) {
  Keys keys;
  for_each_field(p, [&](std::string_view key, std::string_view description, double value,
                        const NumberRange& range) {
    OrderedJson schema = range_schema(range);
    schema["default"] = value;
    keys.push_back({key, description, std::move(schema)});
  });
  return keys;
}

template <class... P>
std::vector<Keys> keys_of_all(const std::variant<P...>* /*names the types*/) {
  return {keys_of(P())...};
}

}  // namespace

std::vector<std::vector<SystemKey>> system_keys() {
  return keys_of_all(static_cast<const decltype(SystemSpec::parameters)*>(nullptr));
}

}  // namespace conddp
