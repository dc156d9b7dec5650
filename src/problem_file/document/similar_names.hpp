#pragma once

#include <vector>

#include "problem_file/yaml/setting.hpp"

namespace conddp {

/// What was reported of a document with settings, `after`, where an entry that the document lacks
/// is wrong, with the names that it has there as a hint: a setting with a misspelled name makes an
/// entry of its own. `before`: what had been reported when reading began.
Diagnostics with_similar_names(const Diagnostics& after, const Diagnostics& before,
                               const YamlNode& document, const std::vector<Setting>& settings);

}  // namespace conddp
