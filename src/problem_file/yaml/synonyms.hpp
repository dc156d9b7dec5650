#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// A key or a choice of the problem file with its names in other tools.
struct Synonyms {
  std::string_view ours;
  std::vector<std::string_view> theirs;
};

/// Synonyms of keys and words that apply anywhere in the file.
const std::vector<Synonyms>& synonyms();

/// Question that suggests a meaning of an unknown word. Suggests names of `accepted` with similar
/// spelling. Otherwise uses synonyms() and `more` to translate names of other tools ('max' to
/// 'upper'). Empty without a suggestion.
std::string meaning_question(std::string_view word, const std::vector<std::string>& accepted,
                             const std::vector<Synonyms>& more = {});

}  // namespace conddp
