#include "analysis/contact_rank.hpp"

#include <Eigen/Dense>

#include "systems/multibody.hpp"

namespace conddp {

ContactRank contact_rank(const ShootingProblem& problem, const Trajectory& trajectory, int k) {
  ContactRank found;
  if (k < 0 || k >= problem.knots() || !trajectory.x(k).allFinite()) return found;
  const auto* system = dynamic_cast<const MultibodySystem*>(&problem.knot(k).model->system());
  if (system == nullptr || system->contacts().empty()) return found;
  for (const Contact& contact : system->contacts().contacts())
    found.contacts.push_back(contact.name);
  found.rows = found.rank = system->contacts().rows();
  const auto data = system->create_data(double{});
  system->evaluate(trajectory.x(k).data(), trajectory.u(k).data(), *data);
  const auto& held = static_cast<const MultibodySystem::Data<double>&>(*data).contacts;
  if (!held.compliant) return found;
  const Eigen::Map<const Eigen::MatrixXd> G(held.G.data(), found.rows, found.rows);
  const double least = 10 * system->contacts().compliance();
  // A direction in which nothing can move, as out of the plane of a planar robot, takes no force.
  std::vector<int> moving;
  for (int i = 0; i < found.rows; ++i)
    if (G(i, i) > least) moving.push_back(i);
  const Eigen::MatrixXd some = G.selfadjointView<Eigen::Lower>().toDenseMatrix()(moving, moving);
  const Eigen::VectorXd moments =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(some, Eigen::EigenvaluesOnly).eigenvalues();
  found.rows = static_cast<int>(moving.size());
  found.rank = static_cast<int>((moments.array() > least).count());
  return found;
}

}  // namespace conddp
