#include "output/bench/best_known.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/json/json_document.hpp"

namespace conddp {
namespace {

constexpr std::string_view kBestKnownKeys[] = {"problems"};

double cost_of(const nlohmann::json& entry) {
  const nlohmann::json& cost = solution_member(entry, "cost");
  if (!cost.is_number()) throw MalformedSolution{"'cost' is not a number"};
  return cost;
}

}  // namespace

std::optional<BestKnown> load_best_known(const std::filesystem::path& file, Diagnostics& out) {
  const auto document = load_document(file, kBestKnownDocument, kBestKnownKeys, {}, out);
  if (!document) return std::nullopt;
  BestKnown known;
  std::string of;  // the entry being read
  try {
    const nlohmann::json& problems = solution_member(*document, "problems");
    if (!problems.is_object()) throw MalformedSolution{"'problems' has no names"};
    for (const auto& [name, entry] : problems.items()) {
      of = name;
      const std::string hash = solution_text(entry, "problem_sha256");
      known[hash] = cost_of(entry);
    }
  } catch (const MalformedSolution& e) {
    out.add({.file = file.string(),
             .path = of.empty() ? "" : "problems." + of,
             .message = fmt::format("the best known optima cannot be used: {}{}", e.what(),
                                    of.empty() ? "" : fmt::format(" ('{}')", of)),
             .hint = "'conddp schema best_known' says what the file has"});
    return std::nullopt;
  }
  return known;
}

}  // namespace conddp
