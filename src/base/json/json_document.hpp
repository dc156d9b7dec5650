#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// A kind of JSON that conddp writes.
struct DocumentKind {
  std::string_view family;  ///< of its formats, before the number of the version
  std::string_view word;    ///< what messages call it
};
inline constexpr DocumentKind kSolutionDocument{"conddp.solution/", "solution"};
inline constexpr DocumentKind kLoopDocument{"conddp.mpc/", "closed loop"};
inline constexpr DocumentKind kBenchDocument{"conddp.bench/", "benchmark"};
inline constexpr DocumentKind kBestKnownDocument{"conddp.best_known/", "list of best known optima"};

/// The keys of whoever wants all entries of a document.
inline constexpr std::span<const std::string_view> kEverything{};

/// Reads the entries `keys` (and `format`) of a document from its text; the others are passed over
/// without being kept, since gains and multipliers of a long solution would fill the memory.
/// Refused with their places: what is no JSON, is nested too deeply, is too long, or has a key
/// twice, and another format than the one that this version writes. Which entries there are, and of
/// what shape, is left to the caller.
std::optional<nlohmann::json> parse_document(const std::string& text, const std::string& name,
                                             const DocumentKind& kind,
                                             std::span<const std::string_view> keys,
                                             Diagnostics& out);

/// The same from a file; `place` is where the file is named.
std::optional<nlohmann::json> load_document(const std::filesystem::path& file,
                                            const DocumentKind& kind,
                                            std::span<const std::string_view> keys,
                                            const Place& place, Diagnostics& out);

/// The same where the document may be of several kinds, which is_of() tells apart.
std::optional<nlohmann::json> load_document(const std::filesystem::path& file,
                                            std::span<const DocumentKind> kinds,
                                            std::span<const std::string_view> keys,
                                            const Place& place, Diagnostics& out);

/// Whether a document that was read is of a kind.
bool is_of(const DocumentKind& kind, const nlohmann::json& document);

}  // namespace conddp
