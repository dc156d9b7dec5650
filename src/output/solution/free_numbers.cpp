#include "output/solution/free_numbers.hpp"

#include <algorithm>

#include "problem_file/assemble/problem_names.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {

std::vector<FreeNumber> free_numbers(const BuiltProblem& built, const Trajectory& trajectory) {
  const ShootingProblem& problem = *built.problem;
  const ControlBounds bounds(problem);
  const auto limit = [&](int choice) {
    if (choice >= problem.nu(0)) return "";
    const double value = trajectory.u(0)[choice];
    if (bounds.at_lower(0, choice, value)) return "lower";
    return bounds.at_upper(0, choice, value) ? "upper" : "";
  };
  std::vector<FreeNumber> list;
  const std::vector<double> times = problem.times(trajectory);
  int first = 0;
  for (const Phase& phase : problem.phases()) {
    const int next = first + phase.knots();
    if (const auto& free = phase.model->step().duration())
      list.push_back(
          {"duration/" + phase.name, times[next] - times[first], "s", limit(free->choice)});
    first = next;
  }
  const auto index_of = [](const std::vector<Column>& columns, const std::string& name) {
    return static_cast<int>(std::ranges::find(columns, name, &Column::name) - columns.begin());
  };
  for (const std::string& name : free_parameter_names(built)) {
    const int column = index_of(built.state_columns, name);
    const int choice = index_of(problem.phases().front().model->system().control_columns(), name);
    list.push_back({name, trajectory.x(problem.knots())[column], built.state_columns[column].unit,
                    limit(choice)});
  }
  return list;
}

}  // namespace conddp
