#include "batch/cluster/array_index.hpp"

#include <charconv>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace conddp {
namespace {

constexpr const char* kVariables[] = {"SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX",
                                      "PBS_ARRAY_INDEX", "AWS_BATCH_JOB_ARRAY_INDEX"};

std::optional<int> whole_number(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || number < 0) return std::nullopt;
  return number;
}

}  // namespace

std::optional<ArrayIndex> array_index() {
  for (const char* variable : kVariables)
    if (const char* value = std::getenv(variable))
      if (const auto index = whole_number(value)) return ArrayIndex{variable, *index};
  return std::nullopt;
}

std::string array_index_variables() { return fmt::format("{}", fmt::join(kVariables, ", ")); }

}  // namespace conddp
