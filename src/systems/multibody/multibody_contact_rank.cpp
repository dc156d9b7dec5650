#include "base/matrix_decompositions.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

namespace {

/// A contact participates in a unit vector of forces if one of its components exceeds this.
constexpr double kTakesPart = 0.05;
/// Bounds on scaled eigenvalues. Below the first, forces are due to rounding; below the second,
/// they change too fast with the posture for solvers.
constexpr double kIdle = 1e-5, kSoft = 1e-2;

/// Rows whose forces have an effect: their diagonal entry of G exceeds ten times the compliance.
std::vector<int> moving_rows(const Eigen::MatrixXd& G, double compliance) {
  std::vector<int> moving;
  for (int i = 0; i < G.rows(); ++i)
    if (G(i, i) > 10 * compliance) moving.push_back(i);
  return moving;
}

/// The contacts that participate in forces without effect.
std::vector<std::string> contacts_in(const ContactSet& contacts, const Eigen::MatrixXd& forces) {
  std::vector<std::string> names;
  if (forces.cols() == 0) return names;
  for (int i = 0; i < contacts.count(); ++i) {
    const Contact& contact = contacts.contacts()[i];
    if (forces.middleRows(contacts.offset(i), contact.rows()).cwiseAbs().maxCoeff() > kTakesPart)
      names.push_back(contact.name);
  }
  return names;
}

}  // namespace

ContactRank MultibodySystem::contact_rank(const double* x) const {
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

  const std::vector<int> moving = moving_rows(G, contacts.compliance());
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
  found.redundant = contacts_in(contacts, forces);
  return found;
}

}  // namespace conddp
