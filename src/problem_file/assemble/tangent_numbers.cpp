#include "problem_file/assemble/tangent_numbers.hpp"

#include <utility>

#include "problem_file/model/components.hpp"

namespace conddp {

std::vector<double> tangent_numbers(const std::optional<ComponentsSpec>& components,
                                    const BuiltProblem& built, Diagnostics& out) {
  auto numbers = resolve(components, tangent_names(*built.plant.system), 0.0, out);
  std::vector<double> tangent = numbers ? *std::move(numbers) : std::vector<double>();
  tangent.resize(built.problem->ndx(), 0.0);
  return tangent;
}

}  // namespace conddp
