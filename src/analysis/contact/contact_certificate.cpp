#include "analysis/contact/contact_certificate.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/contact/contact_mechanics.hpp"
#include "analysis/contact/contact_sweeps.hpp"
#include "robot/dynamics.hpp"

namespace conddp {
namespace {

/// Smallest range of motion of a state, a hundredth of its unit.
constexpr double kSmallSpan = 0.01;

class Player {
 public:
  explicit Player(const ContactMotion& motion, const std::vector<Eigen::MatrixXd>& gains)
      : motion_(motion), gains_(gains), simulator_(motion.plant) {
    span_.setConstant(2 * motion.plant.nv(), kSmallSpan);
    for (int k = 0; k <= motion.steps(); ++k)
      span_ = span_.cwiseMax(deviation(state(k), 0).cwiseAbs());
  }

  /// Counts the steps from planned states whose free solution by the simulator differs from the one
  /// in the plan's mode.
  int find_ambiguous(ReplayRun& worst) {
    int count = 0;
    for (int k = 0; k < motion_.steps(); ++k) {
      const ContactStep own = simulator_.step(motion_.start(k), planned(k));
      const ContactStep other = simulator_.step(motion_.start(k));
      if (own.status != StepStatus::solved || other.status != StepStatus::solved) continue;
      if ((own.v - other.v).lpNorm<Eigen::Infinity>() <= kSame) continue;
      ++count;
      Eigen::VectorXd x(other.q.size() + other.v.size());
      x << other.q, other.v;
      compare(k + 1, x, worst);
    }
    return count;
  }

  ReplayRun run(int substeps, bool each_anew, bool feedback) {
    ReplayRun result;
    Eigen::VectorXd x = state(0);
    for (int k = 0; k < motion_.steps(); ++k) {
      if (each_anew) x = state(k);
      if (!step(k, substeps, feedback, x, result)) {
        result.lost_at = motion_.first_knot + k;
        return result;
      }
      compare(k + 1, x, result);
    }
    return result;
  }

 private:
  /// Solutions of a step are the same if their velocities differ by less, rad/s or m/s. A plan may
  /// be off by this much if its pairs are at tolerance.
  static constexpr double kSame = 1e-4;

  /// End and forces of the planned step.
  ContactStep planned(int k) const {
    return {StepStatus::solved, motion_.q[k + 1], motion_.v[k + 1], motion_.forces[k]};
  }

  Eigen::VectorXd state(int node) const {
    Eigen::VectorXd x(motion_.plant.nq() + motion_.plant.nv());
    x << motion_.q[node], motion_.v[node];
    return x;
  }

  /// x ⊖ the planned state of a node: 2 nv numbers.
  Eigen::VectorXd deviation(const Eigen::VectorXd& x, int node) const {
    const int n = motion_.plant.nv();
    Eigen::VectorXd off(2 * n);
    configuration_difference(*motion_.plant.robot, motion_.q[node].data(), x.data(), off.data());
    off.tail(n) = x.tail(n) - motion_.v[node];
    return off;
  }

  bool step(int k, int substeps, bool feedback, Eigen::VectorXd& x, ReplayRun& result) {
    const int n = motion_.plant.nv(), nq = motion_.plant.nq();
    Eigen::VectorXd u = motion_.u[k];
    if (feedback) {
      u += gains_[motion_.first_knot + k].topLeftCorner(u.size(), 2 * n) * deviation(x, k);
      for (Eigen::Index i = 0; i < u.size(); ++i) {
        const double inside = std::clamp(u[i], motion_.u_lower[i], motion_.u_upper[i]);
        result.saturated += inside != u[i];
        u[i] = inside;
      }
    }
    for (int s = 0; s < substeps; ++s) {
      const StepStart start{x.head(nq), x.tail(n), motion_.applied(u), motion_.h[k] / substeps};
      const ContactStep taken =
          substeps == 1 ? simulator_.step(start, planned(k)) : simulator_.step(start);
      if (taken.status != StepStatus::solved) return false;
      x << taken.q, taken.v;
    }
    return x.allFinite();
  }

  void compare(int node, const Eigen::VectorXd& x, ReplayRun& result) const {
    const Eigen::VectorXd off = deviation(x, node).cwiseAbs();
    Eigen::Index entry = 0;
    const double worst = off.maxCoeff(&entry);
    if (worst > result.deviation) {
      result.deviation = worst;
      result.knot = motion_.first_knot + node;
      result.entry = static_cast<int>(entry);
    }
    result.final_state = worst;
    result.relative = std::max(result.relative, off.cwiseQuotient(span_).maxCoeff());
  }

  const ContactMotion& motion_;
  const std::vector<Eigen::MatrixXd>& gains_;
  ContactSimulator simulator_;
  Eigen::VectorXd span_;
};

/// A force acts above this share of the weight.
constexpr double kActs = 1e-6;
/// A force lies inside the cone below this share of the available friction.
constexpr double kInside = 0.99;
constexpr int kSubsteps = 10;

class Measure {
 public:
  explicit Measure(const ContactMotion& motion)
      : motion_(motion),
        plant_(motion.plant),
        weight_(impulse_scale(plant_, 1)),
        mechanics_(plant_),
        data_(*plant_.robot) {}

  ContactMeasures measure() {
    out_.energy_start = energy(0);
    for (int k = 0; k < motion_.steps(); ++k) {
      k_ = k;
      const Eigen::VectorXd residual =
          stepping_residual(plant_, motion_.start(k), motion_.v[k + 1], motion_.forces[k]);
      Eigen::Index row = 0;
      const double worst = residual.cwiseAbs().maxCoeff(&row);
      out_.stepping.meet(worst / (motion_.h[k] * weight_), motion_.first_knot + k,
                         joint_of(static_cast<int>(row)));
      candidates();
      between();
      stops();
      frictions();
      works();
    }
    out_.energy_end = energy(motion_.steps());
    return out_;
  }

 private:
  std::string joint_of(int row) const {
    for (const Joint& joint : plant_.robot->joints)
      if (joint.v <= row && row < joint.v + joint.nv()) return joint.name;
    return {};
  }

  double energy(int node) {
    update_placements(*plant_.robot, motion_.q[node].data(), data_);
    update_velocities(*plant_.robot, motion_.v[node].data(), data_);
    update_composite_inertias(*plant_.robot, data_);
    return kinetic_energy(*plant_.robot, data_) + potential_energy(*plant_.robot, data_);
  }

  std::vector<double> gaps(const Eigen::VectorXd& q) {
    std::vector<double> list;
    for (const auto& instant : mechanics_.look(q.data())) list.push_back(instant.gap);
    return list;
  }

  /// Measures one rigid pair 0 ≤ f ⊥ φ ≥ 0.
  void pair(double f, double gap, const std::string& name) {
    out_.complementarity.meet(std::abs(std::min(f, gap)), knot(), name);
    out_.product.meet(std::abs(f * gap), knot(), name);
    out_.signs.meet(-f / weight_, knot(), name);
    if (f > kActs * weight_) out_.distant.meet(gap, knot(), name);
  }

  void friction(const Eigen::Vector2d& f, const Eigen::Vector2d& v, double budget, bool pyramid,
                const std::string& name) {
    out_.friction.meet((f - nearest_friction(f - v, budget, pyramid)).lpNorm<Eigen::Infinity>(),
                       knot(), name);
    const double used = pyramid ? f.cwiseAbs().sum() : f.norm();
    const double speed = pyramid ? v.lpNorm<Eigen::Infinity>() : v.norm();
    out_.cone.meet((f.norm() - budget) / weight_, knot(), name);
    out_.dissipation.meet(std::abs(f.dot(v) + budget * speed) / weight_, knot(), name);
    if (budget > kActs * weight_ && used < kInside * budget) out_.slip.meet(speed, knot(), name);
    out_.work.meet(motion_.h[k_] * f.dot(v), knot(), name);
    out_.work_contacts += motion_.h[k_] * f.dot(v);
  }

  void candidates() {
    const std::vector<double> before = gaps(motion_.q[k_]);
    const auto& instants = mechanics_.look(motion_.q[k_ + 1].data());
    const Eigen::VectorXd& v = motion_.v[k_ + 1];
    for (std::size_t c = 0; c < instants.size(); ++c) {
      const ContactCandidate& candidate = plant_.contacts.candidates[c];
      const ContactInstant<double>& at = instants[c];
      const Eigen::Vector3d force = motion_.forces[k_].contact.col(c);
      const double soft = candidate.stiffness ? force[0] / *candidate.stiffness : 0;
      pair(force[0], at.gap + soft, candidate.name);
      if (!candidate.stiffness) out_.penetration.meet(-at.gap, knot(), candidate.name);
      // The work follows from the change of the gap: its final speed differs by the path's
      // curvature.
      const double work = force[0] * (at.gap - before[c]);
      if (!candidate.stiffness) out_.work.meet(work, knot(), candidate.name);
      out_.work_contacts += work;
      const int tangents = tangent_count(plant_.contacts, candidate);
      if (tangents == 0) continue;
      const Eigen::Map<const Eigen::MatrixXd> rows(at.rows.data(), v.size(), 3);
      const Eigen::Vector2d slip = rows.rightCols<2>().transpose() * v;
      friction(force.tail<2>(), slip, candidate.friction * force[0],
               plant_.contacts.friction == FrictionModel::polyhedron, candidate.name);
    }
  }

  /// Measures gaps along the straight path of a step, or along the screw of a floating base.
  void between() {
    Eigen::VectorXd whole(plant_.nv()), q = motion_.q[k_];
    configuration_difference(*plant_.robot, q.data(), motion_.q[k_ + 1].data(), whole.data());
    for (int s = 1; s < kSubsteps; ++s) {
      const Eigen::VectorXd part = static_cast<double>(s) / kSubsteps * whole;
      move_configuration(*plant_.robot, motion_.q[k_].data(), part.data(), q.data());
      const std::vector<double> gap = gaps(q);
      for (std::size_t c = 0; c < gap.size(); ++c)
        if (!plant_.contacts.candidates[c].stiffness)
          out_.between.meet(-gap[c], knot(), plant_.contacts.candidates[c].name);
    }
  }

  void stops() {
    for (std::size_t s = 0; s < plant_.contacts.stops.size(); ++s) {
      const JointStop& stop = plant_.contacts.stops[s];
      const Joint& joint = plant_.robot->joints[stop.joint];
      const double before = motion_.q[k_][joint.q], q = motion_.q[k_ + 1][joint.q];
      const auto side = [&](double force, double limit, double sign) {
        if (!std::isfinite(limit)) return;
        const double gap = sign * (q - limit);
        pair(force, gap, "stop of " + joint.name);
        out_.penetration.meet(-gap, knot(), "stop of " + joint.name);
        out_.work.meet(force * sign * (q - before), knot(), "stop of " + joint.name);
        out_.work_contacts += force * sign * (q - before);
      };
      side(motion_.forces[k_].stop_lower[s], stop.lower, 1);
      side(motion_.forces[k_].stop_upper[s], stop.upper, -1);
    }
  }

  void frictions() {
    for (std::size_t i = 0; i < plant_.contacts.frictions.size(); ++i) {
      const JointFriction& dry = plant_.contacts.frictions[i];
      const Joint& joint = plant_.robot->joints[dry.joint];
      friction({motion_.forces[k_].friction[i], 0}, {motion_.v[k_ + 1][joint.v], 0}, dry.limit,
               false, "friction of " + joint.name);
    }
  }

  void works() {
    const Eigen::VectorXd& v = motion_.v[k_ + 1];
    out_.work_controls += motion_.h[k_] * motion_.applied(motion_.u[k_]).dot(v);
    for (int i = 0; i < plant_.nv(); ++i)
      out_.work_damping -= motion_.h[k_] * mechanics_.resistance(i, v[i]) * v[i];
  }

  /// The current step, as the problem counts.
  int knot() const { return motion_.first_knot + k_; }

  const ContactMotion& motion_;
  const ContactPlant& plant_;
  double weight_;
  ContactMechanics<double> mechanics_;
  RobotData<double> data_;
  ContactMeasures out_;
  int k_ = 0;
};

}  // namespace

ContactReplay replay_contacts(const ContactMotion& motion,
                              const std::vector<Eigen::MatrixXd>& gains, int substeps) {
  Player player(motion, gains);
  ContactReplay replay;
  replay.substeps = substeps;
  replay.each_step = player.run(1, true, false);
  replay.ambiguous_steps = player.find_ambiguous(replay.ambiguous);
  replay.each_step_fine = player.run(substeps, true, false);
  replay.controls = player.run(1, false, false);
  replay.controls_fine = player.run(substeps, false, false);
  const bool has_gains =
      static_cast<int>(gains.size()) == motion.first_knot + motion.steps() &&
      std::any_of(gains.begin(), gains.end(), [](const auto& K) { return !K.isZero(0); });
  if (has_gains) replay.feedback_fine = player.run(substeps, false, true);
  return replay;
}

void WorstFigure::meet(double candidate, int at, const std::string& name) {
  if (std::isnan(value) || candidate <= value) return;
  value = candidate;
  knot = at;
  what = name;
}

Eigen::VectorXd ContactMotion::applied(const Eigen::VectorXd& controls) const {
  const std::vector<double> force = plant.applied(controls.data());
  return Eigen::Map<const Eigen::VectorXd>(force.data(), plant.nv());
}

ContactMeasures measure_contacts(const ContactMotion& motion) { return Measure(motion).measure(); }

ContactCertificate certify_contacts(const ContactMotion& motion) {
  ContactCertificate result{
      measure_contacts(motion), contact_sequence(motion), {}, motion.first_knot, {}};
  for (const ContactCandidate& candidate : motion.plant.contacts.candidates)
    result.candidates.push_back(candidate.name);
  return result;
}

std::vector<Check> contact_checks(
    const ContactMotion& motion, const ContactMeasures& measures,
    const SolverOptions::Tolerances& tolerances,
    const std::function<std::string(int knot, const std::string& what)>& place) {
  std::vector<Check> checks;
  const auto add = [&](const char* name, const WorstFigure& worst, double tolerance) {
    Check check{name};
    check.claimed = 0;
    check.found = worst.value;
    check.tolerance = tolerance;
    check.holds = worst.value <= tolerance;
    if (!check.holds && worst.knot >= 0) check.place = place(worst.knot, worst.what);
    checks.push_back(std::move(check));
  };
  // Errors that the tolerances of the solve allow.
  const double weight = impulse_scale(motion.plant, 1);
  const double shortest =
      motion.h.empty() ? 1 : *std::min_element(motion.h.begin(), motion.h.end());
  add("contact stepping", measures.stepping,
      std::max(1e-8, (tolerances.constraint +
                      tolerances.gap * motion.plant.robot->total_mass() / shortest) /
                         weight));
  const double pair = std::max(1e-6, tolerances.constraint);
  add("contact complementarity", measures.complementarity, pair);
  add("contact penetration", measures.penetration, pair);
  add("contact pull", measures.signs, pair);
  add("contact friction", measures.friction, pair);
  add("contact friction cone", measures.cone, pair);
  add("contact dissipation", measures.dissipation, 2 * pair);
  add("force at a distance", measures.distant, 1e-4);
  return checks;
}

}  // namespace conddp
