#pragma once

#include <string>
#include <vector>

namespace conddp {

/// A command line that a POSIX shell splits into these words. Words with characters other than
/// letters, digits and those of paths, settings and numbers are in single quotes.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace conddp
