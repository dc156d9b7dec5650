#pragma once

#include <string>
#include <vector>

namespace conddp {

/// A command line that a POSIX shell reads as these words: what is more than letters, digits and
/// the signs of paths, settings and numbers stands in single quotes.
std::string shell_line(const std::vector<std::string>& words);

}  // namespace conddp
