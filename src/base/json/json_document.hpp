#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

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

}  // namespace conddp
