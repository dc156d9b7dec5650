#pragma once

#include <optional>
#include <string>

namespace conddp {

/// The place of this process in an array of jobs, counted from 0.
struct ArrayIndex {
  std::string variable;      ///< of the environment, which says it
  std::string text;          ///< what it says
  std::optional<int> index;  ///< nothing where the text is no whole number
};

/// From the first of SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX (Kubernetes), PBS_ARRAY_INDEX and
/// AWS_BATCH_JOB_ARRAY_INDEX that the environment has as a number, else that it has at all. Nothing
/// where it has none.
std::optional<ArrayIndex> array_index();

/// The names of these variables, for people.
std::string array_index_variables();

}  // namespace conddp
