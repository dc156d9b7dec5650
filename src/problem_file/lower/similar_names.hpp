#pragma once

#include <vector>

#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// Diagnostics of a document with settings, with hints about similar names. A setting with a
/// misspelled name creates a new entry. Errors in an entry that the document lacks therefore get
/// the names next to it as a hint. `before`: diagnostics before reading; `after`: after reading.
Diagnostics with_similar_names(const Diagnostics& after, const Diagnostics& before,
                               const YamlNode& document, const std::vector<Setting>& settings);

}  // namespace conddp
