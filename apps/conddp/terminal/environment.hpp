#pragma once

#include <string_view>

namespace conddp {

/// Environment variables read by conddp.
struct EnvironmentInfo {
  const char* name;
  std::string_view meaning;
};
inline constexpr EnvironmentInfo kNoColor{"NO_COLOR", "if not empty, nothing is colored"};
inline constexpr EnvironmentInfo kTerm{
    "TERM", "if 'dumb' or empty, nothing is colored and no progress is shown"};
/// Read by processor_check.cpp, before all other code.
inline constexpr EnvironmentInfo kInstructions{
    "CONDDP_INSTRUCTIONS",
    "'avx2' or 'avx512' forces one path of a conddp that has both; unset, the widest is taken"};
inline constexpr EnvironmentInfo kEnvironment[] = {kNoColor, kTerm, kInstructions};

}  // namespace conddp
