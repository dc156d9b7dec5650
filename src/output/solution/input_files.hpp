#pragma once

#include <vector>

#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Input files of a problem besides its own file.
struct InputFiles {
  std::vector<InputFile> robots, data;
};

InputFiles input_files(const BuiltProblem& built);

/// A list of {"file", "sha256"}.
OrderedJson files_json(const std::vector<InputFile>& files);

}  // namespace conddp
