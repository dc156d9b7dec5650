#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json_fwd.hpp>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// A kind of JSON document that conddp writes.
struct DocumentKind {
  std::string_view family;  ///< of its formats, without the version number
  std::string_view word;    ///< name in messages
};
inline constexpr DocumentKind kSolutionDocument{"conddp.solution/", "solution"};
inline constexpr DocumentKind kLoopDocument{"conddp.mpc/", "closed loop"};
inline constexpr DocumentKind kBenchDocument{"conddp.bench/", "benchmark"};
inline constexpr DocumentKind kBestKnownDocument{"conddp.best_known/", "list of best known optima"};

/// Selects all entries of a document.
inline constexpr std::span<const std::string_view> kEverything{};

/// Reads the entries `keys` (and `format`) of a document from its text. Other entries are skipped,
/// because the gains and multipliers of a long solution would fill the memory. Reports an error
/// with its place for invalid JSON, excessive nesting or length, duplicate keys, and any format
/// other than the one that this version writes. The caller checks which entries exist and their
/// types.
std::optional<nlohmann::json> parse_document(const std::string& text, const std::string& name,
                                             const DocumentKind& kind,
                                             std::span<const std::string_view> keys,
                                             Diagnostics& out);

/// Same as above, from a file; `place` is where an input names the file.
std::optional<nlohmann::json> load_document(const std::filesystem::path& file,
                                            const DocumentKind& kind,
                                            std::span<const std::string_view> keys,
                                            const Place& place, Diagnostics& out);

/// Same as above, for several possible kinds, which is_of() distinguishes.
std::optional<nlohmann::json> load_document(const std::filesystem::path& file,
                                            std::span<const DocumentKind> kinds,
                                            std::span<const std::string_view> keys,
                                            const Place& place, Diagnostics& out);

/// True if a document is of the given kind.
bool is_of(const DocumentKind& kind, const nlohmann::json& document);

/// Thrown if the structure of a document does not match the format that conddp writes.
struct MalformedSolution : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A required member of an object. `Json` is nlohmann's type, with or without key order.
template <class Json>
const Json& solution_member(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (!object.is_object() || found == object.end())
    throw MalformedSolution{fmt::format("'{}' is missing", key)};
  return *found;
}

/// A member that must be text; below, one that must be a list.
template <class Json>
std::string solution_text(const Json& object, const char* key) {
  const Json& value = solution_member(object, key);
  if (!value.is_string()) throw MalformedSolution{fmt::format("'{}' is not text", key)};
  return value.template get<std::string>();
}
template <class Json>
const Json& solution_list(const Json& object, const char* key) {
  const Json& value = solution_member(object, key);
  if (!value.is_array()) throw MalformedSolution{fmt::format("'{}' is not a list", key)};
  return value;
}

}  // namespace conddp
