#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace conddp {

/// A key or a choice of the problem file, and what other tools call it.
struct Synonyms {
  std::string_view ours;
  std::vector<std::string_view> theirs;
};

/// Those that are known of keys and words wherever they stand.
const std::vector<Synonyms>& synonyms();

/// What an unknown word may have meant, as a question: names of `accepted` that are written nearly
/// so, else those for which other tools use this word ('max' for 'upper'), by synonyms() and
/// `more`. Empty if there are none.
std::string meaning_question(std::string_view word, const std::vector<std::string>& accepted,
                             const std::vector<Synonyms>& more = {});

}  // namespace conddp
