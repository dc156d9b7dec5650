#include <Eigen/Dense>

#include "systems/multibody/multibody.hpp"

namespace conddp {

ContactRank MultibodySystem::contact_rank(const double* x) const {
  constexpr double kTakesPart = 0.05;  // of a unit vector of forces
  // Scaled eigenvalues: below the first one forces are rounding, below the second one they change
  // faster with the posture than solvers can follow.
  constexpr double kIdle = 1e-5, kSoft = 1e-2;
  ContactRank found;
  if (contacts_.empty()) return found;
  const ContactSet& contacts = contacts_;
  found.rows = found.rank = contacts.rows();
  const auto data = create_data(double{});
  const std::vector<double> u(nu(), 0.0);
  evaluate(x, u.data(), *data);
  const auto& held = static_cast<const Data<double>&>(*data).contacts;
  const Eigen::Map<const Eigen::MatrixXd> lower(held.G.data(), found.rows, found.rows);
  const Eigen::MatrixXd G = lower.selfadjointView<Eigen::Lower>();
  if (!G.allFinite()) return found;

  const double least = 10 * contacts.compliance();
  std::vector<int> moving;
  for (int i = 0; i < found.rows; ++i)
    if (G(i, i) > least) moving.push_back(i);
  found.rows = found.rank = static_cast<int>(moving.size());
  if (moving.empty()) return found;
  const Eigen::VectorXd size = G.diagonal()(moving).cwiseSqrt();
  const Eigen::MatrixXd scaled =
      size.cwiseInverse().asDiagonal() * G(moving, moving) * size.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> modes(scaled);
  const Eigen::VectorXd& values = modes.eigenvalues();  // ascending
  const int idle = static_cast<int>((values.array() <= kIdle).count());
  const int soft = static_cast<int>((values.array() < kSoft).count());
  found.rank = found.rows - idle;
  if (soft == 0) return found;

  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(contacts.rows(), soft);
  directions(moving, Eigen::all) = size.asDiagonal() * modes.eigenvectors().leftCols(soft);
  const Eigen::VectorXd raise = (kSoft - values.head(soft).array()).matrix();
  found.softness = directions * raise.asDiagonal() * directions.transpose();
  Eigen::MatrixXd forces = Eigen::MatrixXd::Zero(contacts.rows(), idle);
  forces(moving, Eigen::all) = modes.eigenvectors().leftCols(idle);
  for (int i = 0; i < contacts.count() && idle > 0; ++i) {
    const Contact& contact = contacts.contacts()[i];
    if (forces.middleRows(contacts.offset(i), contact.rows()).cwiseAbs().maxCoeff() > kTakesPart)
      found.redundant.push_back(contact.name);
  }
  return found;
}

}  // namespace conddp
