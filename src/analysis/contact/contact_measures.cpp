#include "analysis/contact/contact_measures.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/contact/contact_sweeps.hpp"
#include "analysis/contact/rigid_step.hpp"
#include "robot/dynamics.hpp"

namespace conddp {
namespace {

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

}  // namespace conddp
