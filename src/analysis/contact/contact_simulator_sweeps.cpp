// Fallback of the simulator if pivoting fails: Newton's method around sweeps over the impulses.
#include <cmath>

#include "analysis/contact/contact_mechanics.hpp"
#include "analysis/contact/contact_simulator.hpp"
#include "analysis/contact/contact_sweeps.hpp"
#include "base/matrix_decompositions.hpp"

namespace conddp {

/// Rows of all impulses at an iterate: velocities (gaps over h) u = value + slope dv, and
/// generalized impulses pushᵀ p.
struct ContactSimulator::ImpulseRows {
  Eigen::VectorXd value, impulse, compliance;
  Eigen::MatrixXd slope, push;
  std::vector<ImpulseBound> bounds;

  double h;       ///< length of the step, s
  int count = 0;  ///< rows so far

  ImpulseRows(int most, int nv, double step)
      : value(Eigen::VectorXd::Zero(most)),
        impulse(value),
        compliance(value),
        slope(Eigen::MatrixXd::Zero(most, nv)),
        push(slope),
        h(step) {}

  /// Adds a row and returns its index.
  int add(double velocity, const Eigen::RowVectorXd& slope_of_it,
          const Eigen::RowVectorXd& push_of_it, double force) {
    value[count] = velocity;
    slope.row(count) = slope_of_it;
    push.row(count) = push_of_it;
    impulse[count] = h * force;
    return count++;
  }

  /// Drops unused rows.
  void shrink() {
    value.conservativeResize(count);
    impulse.conservativeResize(count);
    compliance.conservativeResize(count);
    slope.conservativeResize(count, Eigen::NoChange);
    push.conservativeResize(count, Eigen::NoChange);
  }
};

ContactSimulator::ImpulseRows ContactSimulator::impulse_rows(const StepStart& start,
                                                             const ContactStep& at) const {
  const ImplicitContacts& contacts = plant_.contacts;
  const int most = static_cast<int>(3 * contacts.candidates.size() + 2 * contacts.stops.size() +
                                    contacts.frictions.size());
  ImpulseRows rows(most, plant_.nv(), start.h);
  for (std::size_t c = 0; c < contacts.candidates.size(); ++c) add_candidate(c, at, rows);
  for (std::size_t s = 0; s < contacts.stops.size(); ++s) add_stop(s, start, at, rows);
  for (std::size_t f = 0; f < contacts.frictions.size(); ++f) {
    const int v = plant_.robot->joints[contacts.frictions[f].joint].v;
    const Eigen::RowVectorXd axis = Eigen::RowVectorXd::Unit(plant_.nv(), v);
    const int tangent = rows.add(at.v[v], axis, axis, at.forces.friction[f]);
    rows.bounds.push_back(
        {.tangent = tangent, .tangents = 1, .constant = start.h * contacts.frictions[f].limit});
  }
  rows.shrink();
  return rows;
}

void ContactSimulator::add_candidate(std::size_t c, const ContactStep& at,
                                     ImpulseRows& rows) const {
  const ContactCandidate& candidate = plant_.contacts.candidates[c];
  const double h = rows.h;
  ImpulseBound bound{.friction = candidate.friction,
                     .pyramid = plant_.contacts.friction == FrictionModel::polyhedron};
  bound.normal = rows.add(gap_[c] / h, slope_[c].row(0), rows_[c].row(0), at.forces.contact(0, c));
  if (candidate.stiffness) rows.compliance[bound.normal] = 1 / (*candidate.stiffness * h * h);
  bound.tangents = tangent_count(plant_.contacts, candidate);
  if (bound.tangents > 0) bound.tangent = rows.count;
  for (int t = 1; t <= bound.tangents; ++t)
    rows.add(rows_[c].row(t).dot(at.v), slope_[c].row(t), rows_[c].row(t), at.forces.contact(t, c));
  rows.bounds.push_back(bound);
}

void ContactSimulator::add_stop(std::size_t s, const StepStart& start, const ContactStep& at,
                                ImpulseRows& rows) const {
  const JointStop& stop = plant_.contacts.stops[s];
  const Joint& joint = plant_.robot->joints[stop.joint];
  for (const double sign : {1.0, -1.0}) {
    const Eigen::RowVectorXd axis = sign * Eigen::RowVectorXd::Unit(plant_.nv(), joint.v);
    const double limit = sign > 0 ? stop.lower : stop.upper;
    if (!std::isfinite(limit)) continue;
    const double gap = sign * (start.q[joint.q] + rows.h * at.v[joint.v] - limit);
    const double force = sign > 0 ? at.forces.stop_lower[s] : at.forces.stop_upper[s];
    rows.bounds.push_back({.normal = rows.add(gap / rows.h, axis, axis, force)});
  }
}

/// Forces for impulses in the order of impulse_rows.
StepForces ContactSimulator::forces_of_rows(const Eigen::VectorXd& p, double h) const {
  StepForces f(plant_.contacts);
  int row = 0;
  for (std::size_t c = 0; c < plant_.contacts.candidates.size(); ++c)
    for (int r = 0; r <= tangent_count(plant_.contacts, plant_.contacts.candidates[c]); ++r)
      f.contact(r, c) = p[row++] / h;
  for (std::size_t s = 0; s < plant_.contacts.stops.size(); ++s) {
    if (std::isfinite(plant_.contacts.stops[s].lower)) f.stop_lower[s] = p[row++] / h;
    if (std::isfinite(plant_.contacts.stops[s].upper)) f.stop_upper[s] = p[row++] / h;
  }
  for (Eigen::Index d = 0; d < f.friction.size(); ++d) f.friction[d] = p[row++] / h;
  return f;
}

ContactStep ContactSimulator::step_by_sweeps(const StepStart& start, const ContactStep& from) {
  const double scale = impulse_scale(plant_, start.h);
  ContactStep at = from, best = from;
  for (int k = 0; k < options_.max_iterations; ++k) {
    linearize(start, at, true);
    ImpulseRows rows = impulse_rows(start, at);
    if (!A_.allFinite() || !impulse_.allFinite() || !rows.value.allFinite()) return best;
    const double motion =
        (impulse_ - rows.push.transpose() * rows.impulse).lpNorm<Eigen::Infinity>() / scale;
    const Eigen::VectorXd u = rows.value + rows.compliance.cwiseProduct(rows.impulse);
    at.residual = std::max(motion, impulse_residual(u, rows.bounds, scale, rows.impulse));
    const bool better = at.residual < best.residual;
    if (better) best = at;
    if (best.residual <= options_.tolerance && (!better || best.residual <= kRounding)) break;

    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(A_);
    const Eigen::MatrixXd pushed = lu.solve(rows.push.transpose());
    const Eigen::VectorXd free = lu.solve(impulse_);
    Eigen::MatrixXd D = rows.slope * pushed;
    D.diagonal() += rows.compliance;
    sweep_impulses(D, rows.value - rows.slope * free, rows.bounds, scale, rows.impulse);
    at.v += pushed * rows.impulse - free;
    const Eigen::VectorXd reach = start.h * at.v;
    move_configuration(*plant_.robot, start.q.data(), reach.data(), at.q.data());
    at.forces = forces_of_rows(rows.impulse, start.h);
    ++at.iterations;
    if (!at.v.allFinite() || !at.forces.finite()) return best;
  }
  return best;
}

}  // namespace conddp
