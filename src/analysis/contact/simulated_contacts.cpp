#include "analysis/contact/simulated_contacts.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace conddp {
namespace {

/// Largest residual of an unsolved step that is still accepted, as a share of the weight's impulse.
constexpr double kGoodEnough = 1e-4;
/// Gap below which a candidate is near, m: more than the lift of feet.
constexpr double kNear = 0.2;

ContactPlant with_candidates(ContactPlant plant, const std::vector<std::size_t>& chosen) {
  std::vector<ContactCandidate> some;
  for (const std::size_t c : chosen) some.push_back(plant.contacts.candidates[c]);
  plant.contacts.candidates = std::move(some);
  return plant;
}

}  // namespace

SimulatedContacts::SimulatedContacts(const ContactPlant& plant, double dt,
                                     std::vector<int> contact_of, int remembered)
    : plant_(plant),
      dt_(dt),
      contact_of_(std::move(contact_of)),
      remembered_(remembered),
      mechanics_(plant_),
      forces_(3 * (1 + *std::ranges::max_element(contact_of_))) {}

void SimulatedContacts::use(std::vector<std::size_t> candidates) {
  if (simulator_ && candidates == near_) return;
  near_ = std::move(candidates);
  simulator_.emplace(with_candidates(plant_, near_));
}

/// Candidates that are near in a configuration, and those of `more`.
std::vector<std::size_t> SimulatedContacts::near(const double* q,
                                                 const std::vector<std::size_t>& more, double gap) {
  std::vector<std::size_t> found;
  const auto& instants = mechanics_.look(q);
  for (std::size_t c = 0; c < instants.size(); ++c)
    if (!(instants[c].gap > gap) || std::binary_search(more.begin(), more.end(), c))
      found.push_back(c);
  return found;
}

ContactStep SimulatedContacts::step(const StepStart& start) {
  use(near(start.q.data(), {}, kNear));
  for (;;) {
    ContactStep taken = simulator_->step(start);
    if (!taken.q.allFinite()) return taken;
    std::vector<std::size_t> needed = near(taken.q.data(), near_, 0);
    if (needed.size() == near_.size()) return taken;
    use(std::move(needed));
  }
}

std::string_view SimulatedContacts::failure() const {
  return failed_ ? "the simulator of contacts found no solution of the step" : "";
}

void SimulatedContacts::step(double /*time*/, double length, const double* u, double* x) {
  const int nq = plant_.nq(), nv = plant_.nv();
  const std::vector<double> applied = plant_.applied(u);
  const ContactStep taken =
      step({Eigen::Map<const Eigen::VectorXd>(x, nq), Eigen::Map<const Eigen::VectorXd>(x + nq, nv),
            Eigen::Map<const Eigen::VectorXd>(applied.data(), nv), length});
  closed_ = 0;
  std::ranges::fill(forces_, std::numeric_limits<double>::quiet_NaN());
  failed_ = taken.status != StepStatus::solved && !(taken.residual <= kGoodEnough);
  if (failed_) {
    std::fill_n(x, nq + nv + remembered_, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  std::copy_n(taken.q.data(), nq, x);
  std::copy_n(taken.v.data(), nv, x + nq);
  std::copy_n(u, remembered_, x + nq + nv);
  find_contacts(taken);
}

/// Records the contacts that a step has closed, and sums the forces of each contact's candidates.
void SimulatedContacts::find_contacts(const ContactStep& taken) {
  const auto& instants = mechanics_.look(taken.q.data());
  for (std::size_t i = 0; i < near_.size(); ++i) {
    if (!(taken.forces.contact(0, i) > 0)) continue;
    const std::size_t candidate = near_[i];
    const int contact = contact_of_[candidate];
    double* sum = forces_.data() + 3 * contact;
    if ((closed_ >> contact & 1) == 0) std::fill_n(sum, 3, 0.0);
    closed_ |= std::uint32_t{1} << contact;
    const int directions =
        1 + tangent_count(plant_.contacts, plant_.contacts.candidates[candidate]);
    for (int d = 0; d < directions; ++d)
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += taken.forces.contact(d, i) * instants[candidate].directions[d][axis];
  }
}

}  // namespace conddp
