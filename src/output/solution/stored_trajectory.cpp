#include "output/solution/stored_trajectory.hpp"

#include <limits>

#include "base/json/solution_members.hpp"
#include "ocp/problem/control_columns.hpp"

namespace conddp {
namespace {

template <class Row>
void copy(const OrderedJson& from, Row out) {
  if (!from.is_array() || static_cast<Eigen::Index>(from.size()) != out.size())
    throw MalformedSolution{"it has other states or controls than its problem"};
  for (Eigen::Index i = 0; i < out.size(); ++i)
    out[i] = from[i].is_number() ? from[i].get<double>() : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

Trajectory stored_trajectory(const OrderedJson& document, const ShootingProblem& problem) {
  Trajectory trajectory = problem.create_trajectory();
  const OrderedJson& stored = solution_member(document, "trajectory");
  const OrderedJson &x = solution_list(stored, "x"), &u = solution_list(stored, "u");
  if (static_cast<int>(x.size()) != problem.knots() + 1 ||
      static_cast<int>(u.size()) != problem.knots())
    throw MalformedSolution{"it has another number of knots than its problem"};
  for (int k = 0; k <= problem.knots(); ++k) copy(x[k], trajectory.x(k));
  const ControlColumns columns(problem);
  for (int k = 0; k < problem.knots(); ++k) copy(columns.own_entries(k, u[k]), trajectory.u(k));
  return trajectory;
}

}  // namespace conddp
