#include "analysis/contact_rank.hpp"

#include <Eigen/Dense>

#include "systems/multibody.hpp"

namespace conddp {

ContactRank contact_rank(const System& system, const double* x) {
  constexpr double kTakesPart = 0.05;  // of a unit vector of forces
  ContactRank found;
  const auto* body = dynamic_cast<const MultibodySystem*>(&system);
  if (body == nullptr || body->contacts().empty()) return found;
  const ContactSet& contacts = body->contacts();
  found.rows = found.rank = contacts.rows();
  const auto data = body->create_data(double{});
  const std::vector<double> u(body->nu(), 0.0);
  body->evaluate(x, u.data(), *data);
  const auto& held = static_cast<const MultibodySystem::Data<double>&>(*data).contacts;
  const Eigen::Map<const Eigen::MatrixXd> G(held.G.data(), found.rows, found.rows);
  const Eigen::MatrixXd all = G.selfadjointView<Eigen::Lower>();
  if (!held.compliant || !all.allFinite()) return found;

  const double least = 10 * contacts.compliance();
  std::vector<int> moving;
  for (int i = 0; i < found.rows; ++i)
    if (all(i, i) > least) moving.push_back(i);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(all(moving, moving));
  found.rows = static_cast<int>(moving.size());
  found.rank = static_cast<int>((modes.eigenvalues().array() > least).count());
  // In ascending order: the idle directions come first.
  Eigen::MatrixXd idle = Eigen::MatrixXd::Zero(contacts.rows(), found.rows - found.rank);
  idle(moving, Eigen::all) = modes.eigenvectors().leftCols(idle.cols());
  for (int i = 0; i < contacts.count() && idle.cols() > 0; ++i) {
    const Contact& contact = contacts.contacts()[i];
    if (idle.middleRows(contacts.offset(i), contact.rows()).cwiseAbs().maxCoeff() > kTakesPart)
      found.redundant.push_back(contact.name);
  }
  return found;
}

}  // namespace conddp
