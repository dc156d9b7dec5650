#pragma once

#include <optional>
#include <string>

namespace conddp {

/// The index of this process in an array of jobs, counted from 0.
struct ArrayIndex {
  std::string variable;      ///< environment variable of the index
  std::string text;          ///< value of the variable
  std::optional<int> index;  ///< nothing if the value is not a whole number
};

/// Reads the first of SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX (Kubernetes), PBS_ARRAY_INDEX and
/// AWS_BATCH_JOB_ARRAY_INDEX that is a number. Without a number, reads the first one that is set;
/// returns nothing if all are unset.
std::optional<ArrayIndex> array_index();

/// The names of these variables, for messages.
std::string array_index_variables();

}  // namespace conddp
