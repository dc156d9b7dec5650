#include "analysis/contact/simulated_contacts.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "analysis/contact/contact_motion.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// Writes the controls w of one step as SteppingLayout arranges them.
class StepWriter {
 public:
  StepWriter(const SteppingSystem& system, const ContactPlant& plant)
      : layout_(system.layout()), contacts_(plant.contacts), mechanics_(plant) {}

  void write(const StepStart& start, const ContactStep& step, Eigen::Ref<Eigen::VectorXd> w) {
    w.segment(layout_.acceleration, layout_.nv) = (step.v - start.v) / start.h;
    const auto& instants = mechanics_.look(step.q.data());
    for (std::size_t c = 0; c < layout_.candidates.size(); ++c)
      write_contact(c, instants[c], step, w);
    for (const SteppingLayout::Stop& stop : layout_.stops) write_stop(stop, step, w);
    for (std::size_t f = 0; f < layout_.frictions.size(); ++f)
      write_friction(layout_.frictions[f], contacts_.frictions[f].limit,
                     {step.forces.friction[f], 0}, {step.v[layout_.friction_velocities[f]], 0}, w);
  }

 private:
  void write_contact(std::size_t c, const ContactInstant<double>& at, const ContactStep& step,
                     Eigen::Ref<Eigen::VectorXd> w) {
    const SteppingLayout::Candidate& candidate = layout_.candidates[c];
    const ContactCandidate& pair = contacts_.candidates[c];
    const Eigen::Vector3d force = step.forces.contact.col(c);
    const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> rows(
        at.rows.data(), 3, step.v.size());
    const Eigen::Vector2d slip = (rows * step.v).tail(2), tangential = force.tail(2);
    w[candidate.force] = force[0];
    w[candidate.gap] = at.gap + (pair.stiffness ? force[0] / *pair.stiffness : 0);
    const double limit = pair.friction * force[0];
    if (candidate.friction.count > 0)
      write_friction(candidate.friction, limit, tangential, slip, w);
    if (!candidate.cone.present) return;
    const double speed = slip.norm();
    const Eigen::Vector2d rest =
        speed > 0 ? Eigen::Vector2d(slip / speed) : Eigen::Vector2d::Zero();
    const Eigen::Vector2d use = limit > 0 ? Eigen::Vector2d(-tangential / limit) : rest;
    for (int i = 0; i < 2; ++i) {
      w[candidate.cone.force[i]] = tangential[i];
      w[candidate.cone.use[i]] = use[i];
    }
    w[candidate.cone.speed] = speed;
    w[candidate.cone.rest] = std::max(0.0, 1 - use.squaredNorm());
  }

  /// A pyramid: the part of the force along ± each tangent, and the largest slip.
  static void write_friction(const FrictionIndices& f, double limit, const Eigen::Vector2d& force,
                             const Eigen::Vector2d& slip, Eigen::Ref<Eigen::VectorXd> w) {
    const double fastest = slip.head(f.count / 2).lpNorm<Eigen::Infinity>();
    for (int i = 0; i < f.count; ++i) {
      const double sign = i % 2 == 0 ? 1 : -1;
      w[f.force[i]] = std::max(0.0, sign * force[i / 2]);
      w[f.slip[i]] = fastest + sign * slip[i / 2];
    }
    w[f.gamma] = fastest;
    w[f.rest] = std::max(0.0, limit - force.head(f.count / 2).lpNorm<1>());
  }

  void write_stop(const SteppingLayout::Stop& stop, const ContactStep& step,
                  Eigen::Ref<Eigen::VectorXd> w) const {
    for (std::size_t s = 0; s < contacts_.stops.size(); ++s)
      if (contacts_.stops[s].joint == stop.joint)
        w[stop.force] = (stop.upper ? step.forces.stop_upper : step.forces.stop_lower)[s];
    const double off = step.q[stop.position] - stop.limit;
    w[stop.distance] = stop.upper ? -off : off;
  }

  const SteppingLayout& layout_;
  const ImplicitContacts& contacts_;
  ContactMechanics<double> mechanics_;
};

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

std::optional<Trajectory> simulated_guess(const ShootingProblem& problem, const Trajectory& guess,
                                          const Feedback* policy) {
  const auto motion = contact_motion(problem, guess);
  if (!motion) return std::nullopt;
  const int first = motion->first_knot;
  const SteppingSystem& system = *problem.knot(first).model->system().as_stepping();
  ContactSimulator simulator(motion->plant);
  StepWriter writer(system, motion->plant);
  Trajectory simulated = guess;
  StepStart start = motion->start(0);
  Eigen::VectorXd difference(problem.ndx());
  for (int k = 0; k < motion->steps(); ++k) {
    Eigen::VectorXd u = motion->u[k];
    if (policy != nullptr) {
      problem.manifold().difference(guess.x(first + k).data(), simulated.x(first + k).data(),
                                    difference.data());
      u += policy->K[first + k].topRows(u.size()) * difference;
      u = u.cwiseMax(motion->u_lower).cwiseMin(motion->u_upper);
      simulated.u(first + k).head(u.size()) = u;
    }
    start.applied = motion->applied(u);
    start.h = motion->h[k];
    ContactStep step = simulator.step(start);
    if (step.status != StepStatus::solved) return std::nullopt;
    writer.write(start, step, simulated.u(first + k));
    start.q = std::move(step.q);
    start.v = std::move(step.v);
    auto x = simulated.x(first + k + 1);
    x.head(start.q.size()) = start.q;
    x.segment(start.q.size(), start.v.size()) = start.v;
  }
  return simulated;
}

}  // namespace conddp
