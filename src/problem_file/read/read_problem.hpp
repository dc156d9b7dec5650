#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/model/spec.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// Reads a problem file. `overrides`: `key.path=value` settings that replace values of the file.
/// Returns nothing if there was an error; every error found is in `out`.
std::optional<ProblemSpec> read_problem(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides,
                                        Diagnostics& out);

struct ReadOptions {
  double homotopy_share = 1;  ///< numbers of a homotopy take their values there on its path
  std::string_view last;      ///< last rewriting of the specification; empty: all
};

/// The same from a text. Relative paths are resolved against the folder of `file`, which need not
/// exist.
std::optional<ProblemSpec> read_problem_text(const std::string& text,
                                             const std::filesystem::path& file,
                                             const std::vector<std::string>& overrides,
                                             Diagnostics& out, const ReadOptions& options = {});

/// A problem file as a tree; problems with different settings can be read from it.
struct ProblemDocument {
  std::filesystem::path file;
  std::string text;    ///< of the file without byte-order mark
  std::string sha256;  ///< of the bytes read; empty: that of the text
  YamlNode root;       ///< its places refer to a text in the Diagnostics of its reader
};

/// Parses a problem file, or a text in its place. Empty with errors if it is not YAML; an
/// unreadable file is reported at `place`.
std::optional<ProblemDocument> load_problem(const std::filesystem::path& file, const Place& place,
                                            Diagnostics& out);
std::optional<ProblemDocument> parse_problem(std::string text, const std::filesystem::path& file,
                                             Diagnostics& out);

/// Reads the problem with settings that replace values of the document. `out` must contain the
/// texts of the document and of the settings.
std::optional<ProblemSpec> read_problem(const ProblemDocument& document,
                                        const std::vector<Setting>& settings, Diagnostics& out,
                                        const ReadOptions& options = {});
/// The same with settings of the command line; nothing without a document.
std::optional<ProblemSpec> read_problem(const std::optional<ProblemDocument>& document,
                                        const std::vector<std::string>& overrides, Diagnostics& out,
                                        const ReadOptions& options = {});

/// A problem file after a rewriting of its document (document_rewritings). Empty with an error if
/// it cannot be rewritten.
std::optional<YamlNode> rewritten_document(const std::string& text,
                                           const std::filesystem::path& file,
                                           const std::vector<std::string>& overrides,
                                           std::string_view rewriting, Diagnostics& out);

}  // namespace conddp
