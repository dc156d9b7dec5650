#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "problem_file/spec/spec.hpp"

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

}  // namespace conddp
