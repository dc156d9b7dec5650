#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "support/random_numbers.hpp"

namespace conddp {

/// Parts of YAML in flow style, and random choices among them.
using Entries = std::vector<std::string>;

inline std::string flow_map(const Entries& entries) {
  return fmt::format("{{{}}}", fmt::join(entries, ", "));
}
inline std::string flow_list(const Entries& entries) {
  return fmt::format("[{}]", fmt::join(entries, ", "));
}
/// A number of four digits that every YAML reader accepts.
inline std::string number_text(double value) {
  std::string text = fmt::format("{:.4g}", value);
  if (const std::size_t e = text.find('e'); e != std::string::npos && text.find('.') > e)
    text.insert(e, ".0");
  return text;
}
inline std::string in_quotes(std::string_view name) { return fmt::format("\"{}\"", name); }
inline Entries all_in_quotes(const Entries& names) {
  Entries list;
  for (const std::string& name : names) list.push_back(in_quotes(name));
  return list;
}

template <class List>
const auto& pick(const List& list, RandomNumbers& random) {
  return list[static_cast<std::size_t>(random.index(static_cast<int>(std::size(list))))];
}
/// A random word of an enumerated key.
template <class Words>
std::string pick_word(const Words& words, RandomNumbers& random) {
  return std::string(pick(words, random).word);
}
/// Between one and `most` names in their order.
inline Entries pick_some(const Entries& names, std::size_t most, RandomNumbers& random) {
  Entries chosen;
  for (std::size_t i = 0; i < names.size() && chosen.size() < most; ++i)
    if (random.chance(std::min(0.9, 1.5 / static_cast<double>(names.size()))))
      chosen.push_back(names[i]);
  if (chosen.empty()) chosen.push_back(pick(names, random));
  return chosen;
}
/// A log-uniform number between two positive numbers.
inline double between_powers(double lower, double upper, RandomNumbers& random) {
  return lower * std::pow(upper / lower, random.uniform(0, 1));
}
inline Entries random_numbers(std::size_t n, double size, RandomNumbers& random) {
  Entries list;
  for (std::size_t i = 0; i < n; ++i) list.push_back(number_text(random.uniform(-size, size)));
  return list;
}

}  // namespace conddp
