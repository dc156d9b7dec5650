#include "analysis/contact/contact_motion.hpp"

#include <algorithm>
#include <cmath>

#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// One candidate over all steps.
struct Track {
  std::vector<bool> closed, near, slips;
};

/// Flips runs of `value` that are shorter than `shortest` and lie between others, if `allowed` is
/// true for each of their steps.
template <class Allowed>
void drop_short_runs(std::vector<bool>& steps, bool value, int shortest, Allowed allowed) {
  const int n = static_cast<int>(steps.size());
  for (int first = 0; first < n;) {
    const auto begin = steps.begin() + first;
    const int end = static_cast<int>(std::find(begin, steps.end(), !*begin) - steps.begin());
    bool drop = steps[first] == value && first > 0 && end < n && end - first < shortest;
    for (int k = first; drop && k < end; ++k) drop = allowed(k);
    if (drop) std::fill(steps.begin() + first, steps.begin() + end, !value);
    first = end;
  }
}

std::vector<Track> tracks(const ContactMotion& motion, const ContactSequenceOptions& options) {
  const int count = static_cast<int>(motion.plant.contacts.candidates.size());
  const double force = options.share * impulse_scale(motion.plant, 1);
  std::vector<Track> all(count);
  ContactMechanics<double> mechanics(motion.plant);
  std::vector<bool> touches(count);
  for (int k = 0; k <= motion.steps(); ++k) {
    const auto& instants = mechanics.look(motion.q[k].data());
    for (int c = 0; c < count; ++c) {
      if (k > 0) {
        const Eigen::VectorXd& v = motion.v[k];
        const Eigen::Map<const Eigen::MatrixXd> rows(instants[c].rows.data(), v.size(), 3);
        all[c].slips.push_back((rows.rightCols<2>().transpose() * v).norm() > options.slip);
      }
      touches[c] = instants[c].gap <= options.gap;
      if (k == motion.steps()) continue;
      all[c].near.push_back(touches[c]);
      all[c].closed.push_back(touches[c] && motion.forces[k].contact(0, c) > force);
    }
  }
  for (Track& track : all) {
    drop_short_runs(track.closed, false, options.shortest, [&](int k) { return track.near[k]; });
    drop_short_runs(track.closed, true, options.shortest, [](int) { return true; });
  }
  return all;
}

/// A stretch without steps yet; `before` are the closed candidates of the previous one.
ContactStretch stretch_from(int k, const std::vector<bool>& closed,
                            const std::vector<bool>& before) {
  ContactStretch stretch{.first = k, .closed = closed};
  stretch.slides.assign(closed.size(), false);
  stretch.pushes.resize(closed.size());
  for (std::size_t c = 0; c < closed.size(); ++c)
    stretch.landing.push_back(closed[c] && !before[c]);
  return stretch;
}

/// Candidates that are closed in a step.
std::vector<bool> closed_in(const std::vector<Track>& all, int k) {
  std::vector<bool> closed;
  for (const Track& track : all) closed.push_back(track.closed[k]);
  return closed;
}

/// Counts a step with a push by an open candidate.
void add_push(double force, ContactStretch::Push& push) {
  ++push.steps;
  push.largest = std::max(push.largest, force);
}

/// Components along the normal and the tangents.
Eigen::Vector3d force_of(const SteppingLayout::Candidate& at, const Eigen::VectorXd& w) {
  Eigen::Vector3d force(w[at.force], 0, 0);
  for (int i = 0; i < at.friction.count; i += 2)
    force[1 + i / 2] = w[at.friction.force[i]] - w[at.friction.force[i + 1]];
  for (int i = 0; at.cone.present && i < 2; ++i) force[1 + i] = w[at.cone.force[i]];
  return force;
}

/// Extracts the forces from the controls of a step.
StepForces forces_of(const SteppingSystem& system, const Eigen::VectorXd& w) {
  const SteppingLayout& layout = system.layout();
  const ImplicitContacts& contacts = system.contacts();
  StepForces forces(contacts);
  for (std::size_t c = 0; c < layout.candidates.size(); ++c)
    forces.contact.col(c) = force_of(layout.candidates[c], w);
  for (const SteppingLayout::Stop& stop : layout.stops)
    for (std::size_t s = 0; s < contacts.stops.size(); ++s)
      if (contacts.stops[s].joint == stop.joint)
        (stop.upper ? forces.stop_upper : forces.stop_lower)[s] = w[stop.force];
  for (std::size_t f = 0; f < layout.frictions.size(); ++f)
    forces.friction[f] = w[layout.frictions[f].force[0]] - w[layout.frictions[f].force[1]];
  return forces;
}

}  // namespace

std::optional<ContactMotion> contact_motion(const ShootingProblem& problem,
                                            const Trajectory& trajectory) {
  const int first = problem.phases().front().instant ? 1 : 0;
  const KnotModel& model = *problem.knot(first).model;
  const auto* system = model.system().as_stepping();
  if (system == nullptr) return std::nullopt;
  ContactMotion motion;
  motion.first_knot = first;
  motion.plant = contact_plant(system->multibody(), system->contacts());
  const int nq = system->nq(), nv = system->nv(), actuators = system->layout().actuators;
  const auto bounds = [&](const auto& all) {
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(all.data(), actuators));
  };
  motion.u_lower = bounds(model.control_lower());
  motion.u_upper = bounds(model.control_upper());
  for (int k = first; k <= problem.knots(); ++k) {
    motion.q.push_back(trajectory.x(k).head(nq));
    motion.v.push_back(trajectory.x(k).segment(nq, nv));
    if (k == problem.knots()) break;
    motion.h.push_back(
        problem.knot(k).model->step().time_step(problem.knot(k).dt, trajectory.x(k).data()));
    motion.u.push_back(trajectory.u(k).head(actuators));
    motion.forces.push_back(forces_of(*system, trajectory.u(k)));
  }
  return motion;
}

bool ContactStretch::lands() const {
  return std::find(landing.begin(), landing.end(), true) != landing.end();
}

std::vector<ContactStretch> contact_sequence(const ContactMotion& motion,
                                             const ContactSequenceOptions& options) {
  const std::vector<Track> all = tracks(motion, options);
  const int count = static_cast<int>(all.size());
  const double force = options.share * impulse_scale(motion.plant, 1);
  std::vector<ContactStretch> list;
  for (int k = 0; k < motion.steps(); ++k) {
    const std::vector<bool> closed = closed_in(all, k);
    if (list.empty() || list.back().closed != closed)
      list.push_back(stretch_from(k, closed, list.empty() ? closed : list.back().closed));
    ContactStretch& stretch = list.back();
    ++stretch.steps;
    for (int c = 0; c < count; ++c) {
      if (closed[c] && all[c].slips[k]) stretch.slides[c] = true;
      const double pushing = motion.forces[k].contact(0, c);
      if (!closed[c] && pushing > force) add_push(pushing, stretch.pushes[c]);
    }
  }
  return list;
}

}  // namespace conddp
