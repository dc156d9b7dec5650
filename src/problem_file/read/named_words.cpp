#include "problem_file/read/named_words.hpp"

#include <fmt/format.h>

namespace conddp {

std::vector<std::pair<Name, std::string>> read_named_words(const YamlReader& reader) {
  std::vector<std::pair<Name, std::string>> words;
  if (reader.is_sequence()) {
    const auto names = reader.names();
    if (!names) return words;
    for (const Name& name : *names) words.emplace_back(name, "1");
    return words;
  }
  const auto entries = reader.named_entries("write {name: unit, ...} or [name, ...]");
  if (!entries) return words;
  for (const auto& [name, value] : *entries)
    if (value.is_null() || (value.is_scalar() && value.node().text.empty()))
      value.error(fmt::format("'{}' has no unit behind it", name.value),
                  "write the unit, or 1 where there is none");
    else if (!value.is_scalar())
      value.error(fmt::format("the unit of '{}' is one word", name.value),
                  fmt::format("write '{}: 1', or its unit; bounds stand below 'constraints' "
                              "('bounds: state' or 'bounds: control'), first values below "
                              "'initial_state'",
                              name.value));
    else if (auto word = value.text())
      words.emplace_back(name, std::move(*word));
  return words;
}

}  // namespace conddp
