#include "analysis/contact/simulated_contacts.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace conddp {
namespace {

/// Residual up to which a step that did not converge is taken all the same, as a share of the
/// weight's impulse: no motion shows it.
constexpr double kGoodEnough = 1e-4;

}  // namespace

SimulatedContacts::SimulatedContacts(const ContactPlant& plant, double dt,
                                     std::vector<int> contact_of, int remembered)
    : plant_(plant),
      dt_(dt),
      contact_of_(std::move(contact_of)),
      remembered_(remembered),
      simulator_(plant) {}

void SimulatedContacts::step(double /*time*/, double length, const double* u, double* x) {
  const int nq = plant_.nq(), nv = plant_.nv();
  const std::vector<double> applied = plant_.applied(u);
  const ContactStep taken = simulator_.step(
      {Eigen::Map<const Eigen::VectorXd>(x, nq), Eigen::Map<const Eigen::VectorXd>(x + nq, nv),
       Eigen::Map<const Eigen::VectorXd>(applied.data(), nv), length});
  closed_ = 0;
  if (taken.status != StepStatus::solved && !(taken.residual <= kGoodEnough)) {
    std::fill_n(x, nq + nv + remembered_, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  std::copy_n(taken.q.data(), nq, x);
  std::copy_n(taken.v.data(), nv, x + nq);
  std::copy_n(u, remembered_, x + nq + nv);
  for (std::size_t c = 0; c < contact_of_.size(); ++c)
    if (taken.forces.contact(0, c) > 0) closed_ |= std::uint32_t{1} << contact_of_[c];
}

}  // namespace conddp
