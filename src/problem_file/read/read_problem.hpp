#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/spec/spec.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// Reads a problem file. `overrides` are `key.path=value` settings that replace what the file
/// says. Returns nothing if there was an error; every error found is in `out`.
std::optional<ProblemSpec> read_problem(const std::filesystem::path& file,
                                        const std::vector<std::string>& overrides,
                                        Diagnostics& out);

/// The same from a text; relative paths are resolved against the folder of `file`, which need not
/// exist. The numbers that a homotopy moves are those at a share of its way: at 1 the problem
/// itself.
std::optional<ProblemSpec> read_problem_text(const std::string& text,
                                             const std::filesystem::path& file,
                                             const std::vector<std::string>& overrides,
                                             Diagnostics& out, double homotopy_share = 1);

/// A problem file as a tree, of which problems with different settings are read.
struct ProblemDocument {
  std::filesystem::path file;
  std::string text;    ///< of the file, without a byte-order mark
  std::string sha256;  ///< of the bytes that were read; empty: that of the text
  YamlNode root;       ///< its places lie in a text that the Diagnostics of its reader know
};

/// Parses a problem file, or a text that stands for one. Nothing with errors where it is not YAML;
/// a file that cannot be read is reported at `place`.
std::optional<ProblemDocument> load_problem(const std::filesystem::path& file, const Place& place,
                                            Diagnostics& out);
std::optional<ProblemDocument> parse_problem(std::string text, const std::filesystem::path& file,
                                             Diagnostics& out);

/// Reads the problem with settings in place of what the document says. `out` must know the texts of
/// the document and of the settings.
std::optional<ProblemSpec> read_problem(const ProblemDocument& document,
                                        const std::vector<Setting>& settings, Diagnostics& out,
                                        double homotopy_share = 1);

}  // namespace conddp
