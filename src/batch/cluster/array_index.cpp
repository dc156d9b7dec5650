#include "batch/cluster/array_index.hpp"

#include <cstdlib>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/text/strict_number.hpp"

namespace conddp {
namespace {

constexpr const char* kVariables[] = {"SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX",
                                      "PBS_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_INDEX"};

}  // namespace

std::optional<ArrayIndex> array_index() {
  std::optional<ArrayIndex> wrong;
  for (const char* variable : kVariables) {
    const char* value = std::getenv(variable);
    if (value == nullptr) continue;
    const ArrayIndex found{variable, value, parse_count(value)};
    if (found.index) return found;
    if (!wrong) wrong = found;
  }
  return wrong;
}

std::string array_index_variables() { return fmt::format("{}", fmt::join(kVariables, ", ")); }

}  // namespace conddp
