#include "problem_file/data/warm_start.hpp"

namespace conddp {

void set_warm_start(const std::filesystem::path& file, const Place& place, ProblemSpec& spec) {
  std::error_code error;
  std::filesystem::path path = std::filesystem::absolute(file, error);
  if (error) path = file;  // reading the file reports the error
  const DataFileSpec data{{path.string(), place}, path, {}};
  spec.guess = {.states = GuessSpec::States::kFile,
                .states_place = place,
                .states_file = data,
                .controls = GuessSpec::Controls::kFile,
                .controls_place = place,
                .controls_file = data};
  if (path.extension() == ".json") spec.guess.multipliers_file = data;
}

}  // namespace conddp
