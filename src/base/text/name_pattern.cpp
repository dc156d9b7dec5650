#include "base/text/name_pattern.hpp"

#include <fnmatch.h>

namespace conddp {

std::size_t fit(const std::string& pattern, const std::string& name) {
  if (name.empty()) return 0;
  if (pattern == name) return std::string::npos;
  if (!is_pattern(pattern)) return 0;
  return fnmatch(pattern.c_str(), name.c_str(), FNM_NOESCAPE) == 0 ? pattern.size() : 0;
}

bool fits(const std::string& pattern, const std::string& name) { return fit(pattern, name) > 0; }

bool is_pattern(const std::string& name) { return name.find('*') != std::string::npos; }

}  // namespace conddp
