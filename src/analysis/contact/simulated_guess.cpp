#include "analysis/contact/simulated_guess.hpp"

#include <algorithm>

#include "analysis/contact/contact_motion.hpp"
#include "analysis/contact/contact_simulator.hpp"
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

}  // namespace

std::optional<Trajectory> simulated_guess(const ShootingProblem& problem, const Trajectory& guess) {
  const auto motion = contact_motion(problem, guess);
  if (!motion) return std::nullopt;
  const int first = motion->first_knot;
  const SteppingSystem& system = *problem.knot(first).model->system().as_stepping();
  ContactSimulator simulator(motion->plant);
  StepWriter writer(system, motion->plant);
  Trajectory simulated = guess;
  StepStart start = motion->start(0);
  for (int k = 0; k < motion->steps(); ++k) {
    start.applied = motion->applied(motion->u[k]);
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
