#include "problem_file/build/problem_identity.hpp"

#include "base/files/sha256.hpp"

namespace conddp {

std::string problem_sha256(const ProblemSpec& spec, const BuiltProblem& built) {
  std::string all = spec.definition;
  for (const PlantPart& part : built.plant.parts) all += '\n' + part.sha256;
  for (const InputFile& file : built.data_files) all += '\n' + file.sha256;
  return sha256(all);
}

}  // namespace conddp
