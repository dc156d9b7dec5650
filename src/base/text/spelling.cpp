#include "base/text/spelling.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include <fnmatch.h>

namespace conddp {

// No library on both Debian 12 and Ubuntu 22.04 has an edit distance for C++, so this is the
// textbook recurrence of the optimal string alignment distance in three rows.
int edit_distance(std::string_view a, std::string_view b) {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  const auto same = [&](char x, char y) { return lower(x) == lower(y); };
  std::vector<int> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::swap(before, last);
    std::swap(last, row);
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + !same(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && same(a[i - 1], b[j - 2]) && same(a[i - 2], b[j - 1]))
        row[j] = std::min(row[j], before[j - 2] + 1);
    }
  }
  return row[b.size()];
}

std::string counted(std::size_t count, std::string_view what) {
  return std::to_string(count) + ' ' + std::string(what) + (count == 1 ? "" : "s");
}

std::string listed(const std::vector<std::string>& names, std::size_t shown) {
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, names.size()); ++i)
    text += (i > 0 ? ", " : "") + names[i];
  if (names.size() > shown) text += " and " + std::to_string(names.size() - shown) + " more";
  return text;
}

std::vector<std::string> similar_names(std::string_view name,
                                       const std::vector<std::string>& candidates) {
  constexpr std::size_t kLongest = 128;  // the distance is quadratic in the length
  if (name.size() > kLongest) return {};
  const int reach = std::clamp(static_cast<int>(name.size()) / 3, 1, 3);
  std::vector<std::pair<int, std::string>> found;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > kLongest) continue;
    const int distance = edit_distance(name, candidate);
    // A name without a letter in common is not a misspelling.
    const int letters = static_cast<int>(std::max(name.size(), candidate.size()));
    if (distance <= reach && distance < letters) found.emplace_back(distance, candidate);
  }
  std::sort(found.begin(), found.end());
  if (found.size() > 3) found.resize(3);
  std::vector<std::string> names;
  for (auto& [distance, candidate] : found) names.push_back(std::move(candidate));
  return names;
}

namespace {

/// Candidates that end in the name after a separator, such as a robot's names with its prefix.
std::vector<std::string> prefixed_names(std::string_view name,
                                        const std::vector<std::string>& candidates) {
  std::vector<std::string> found;
  for (const std::string& candidate : candidates) {
    if (candidate.size() <= name.size() || !candidate.ends_with(name)) continue;
    const char before = candidate[candidate.size() - name.size() - 1];
    if (before == '/' || before == '_') found.push_back(candidate);
  }
  if (found.size() > 3) found.resize(3);
  return found;
}

}  // namespace

std::string name_hint(std::string_view name, const std::vector<std::string>& candidates,
                      std::string_view what) {
  std::vector<std::string> near = prefixed_names(name, candidates);
  if (near.empty()) near = similar_names(name, candidates);
  if (!near.empty()) {
    std::string hint = "did you mean '" + near[0] + "'";
    for (std::size_t i = 1; i < near.size(); ++i) hint += " or '" + near[i] + "'";
    return hint + "?";
  }
  if (candidates.empty()) return "there are no " + std::string(what);
  return std::string(what) + ": " + listed(candidates, 8);
}

std::size_t fit(const std::string& pattern, const std::string& name) {
  if (name.empty()) return 0;
  if (pattern == name) return std::string::npos;
  if (!is_pattern(pattern)) return 0;
  return fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0 ? pattern.size() : 0;
}

bool fits(const std::string& pattern, const std::string& name) { return fit(pattern, name) > 0; }

bool is_pattern(const std::string& name) { return name.find('*') != std::string::npos; }

}  // namespace conddp
