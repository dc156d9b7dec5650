#include "analysis/contact/contact_simulator.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/QR>

#include "analysis/contact/contact_mechanics.hpp"
#include "base/matrix_decompositions.hpp"

namespace conddp {
namespace {

/// Adds a little compliance if pivoting meets a tie that rounding decides wrongly. Newton's
/// iterations see how little it changes.
std::optional<Eigen::VectorXd> solve_nearly(Eigen::MatrixXd M, const Eigen::VectorXd& q) {
  const double size = M.size() == 0 ? 0 : M.cwiseAbs().maxCoeff();
  double added = 0;
  for (const double share : {0.0, 1e-13, 1e-12, 1e-11, 1e-10}) {
    M.diagonal().array() += share * size - added;
    added = share * size;
    if (auto z = solve_lcp(M, q)) return z;
  }
  return std::nullopt;
}

/// A slower contact counts as sticking when its pyramid is turned, m/s.
constexpr double kSlip = 1e-10;
/// Below the residual kNearStep, a contact that slips faster than kClearSlip keeps slipping.
constexpr double kNearStep = 1e-3, kClearSlip = 1e-6;

}  // namespace

std::string_view to_string(StepStatus status) {
  switch (status) {
    case StepStatus::solved:
      return "solved";
    case StepStatus::unsolved:
      return "unsolved";
    case StepStatus::no_contact:
      return "no contact forces found";
    case StepStatus::not_finite:
      break;
  }
  return "not finite";
}

/// Equations at an iterate, solved for the velocity change by impulses z: dv = pushed z − free.
struct ContactSimulator::Response {
  ContactPairs pairs;
  Eigen::MatrixXd pushed;
  Eigen::VectorXd free;

  /// Matrix and offset of the complementarity problem w = matrix z + offset.
  Eigen::MatrixXd matrix() const { return pairs.slope * pushed + pairs.coupling; }
  Eigen::VectorXd offset() const { return pairs.value - pairs.slope * free; }
};

/// Impulses and the response to them. No response if a number is not finite; no z without a
/// solution.
struct ContactSimulator::Pivoted {
  std::optional<Response> response;
  std::optional<Eigen::VectorXd> z;
};

ContactSimulator::ContactSimulator(const ContactPlant& plant, ContactSimulatorOptions options)
    : plant_(plant),
      options_(options),
      slopes_(plant_),
      pyramid_(Eigen::VectorXd::Zero(plant.contacts.candidates.size())),
      heading_(Eigen::Matrix2Xd::Zero(2, plant.contacts.candidates.size())) {
  for (const ContactCandidate& candidate : plant_.contacts.candidates) {
    const int tangents = tangent_count(plant_.contacts, candidate);
    pairs_ += tangents == 0 ? 1 : 2 + 2 * tangents;
  }
  for (const JointStop& stop : plant_.contacts.stops)
    pairs_ += (stop.lower > -kUnlimited) + (stop.upper < kUnlimited);
  pairs_ += 3 * static_cast<int>(plant_.contacts.frictions.size());
}

/// Evaluates values and slopes with respect to v at the iterate, one dual direction at a time.
void ContactSimulator::linearize(const StepStart& start, const ContactStep& at, bool with_forces) {
  const int n = plant_.nv();
  const std::size_t count = plant_.contacts.candidates.size();
  gap_.resize(count);
  rows_.assign(count, Eigen::Matrix3Xd::Zero(3, n));
  slope_.assign(count, Eigen::Matrix3Xd::Zero(3, n));
  A_.resize(n, n);
  impulse_.resize(n);
  using D = Dual<double>;
  for (int i = 0; i < n; ++i) {
    std::vector<D> v(n);
    for (int j = 0; j < n; ++j) v[j] = D(at.v[j], i == j ? 1.0 : 0.0);
    const auto& instants = slopes_.end(start, v.data());
    std::vector<D> pushed(n, D(0.0));
    if (with_forces) slopes_.add_forces(start.h, at.forces, pushed);
    for (std::size_t c = 0; c < count; ++c) {
      gap_[c] = instants[c].gap.v;
      for (int r = 0; r < 3; ++r) {
        D velocity(0.0);
        for (int j = 0; j < n; ++j) {
          velocity = velocity + instants[c].rows[r * n + j] * v[j];
          rows_[c](r, j) = instants[c].rows[r * n + j].v;
        }
        slope_[c](r, i) = velocity.d;
      }
      slope_[c](0, i) = instants[c].gap.d / start.h;
    }
    const std::vector<D>& needed = slopes_.free_impulse(start, v.data());
    for (int j = 0; j < n; ++j) {
      impulse_[j] = needed[j].v;
      A_(j, i) = needed[j].d - pushed[j].d;
    }
  }
}

ContactPairs ContactSimulator::assemble(const StepStart& start, const ContactStep& at,
                                        bool with_slopes) const {
  ContactPairs pairs(pairs_, plant_.nv());
  for (std::size_t c = 0; c < plant_.contacts.candidates.size(); ++c)
    add_contact(c, start, at, with_slopes, pairs);
  const auto joint = [&](int index) {
    Eigen::RowVectorXd axis = Eigen::RowVectorXd::Zero(plant_.nv());
    axis[plant_.robot->joints[index].v] = 1;
    return axis;
  };
  for (const JointStop& stop : plant_.contacts.stops) {
    const Eigen::RowVectorXd axis = joint(stop.joint);
    const double q = start.q[plant_.robot->joints[stop.joint].q] + start.h * axis.dot(at.v);
    for (const bool lower : {true, false}) {
      const double limit = lower ? stop.lower : stop.upper, sign = lower ? 1 : -1;
      if (std::isfinite(limit)) pairs.add(sign * (q - limit) / start.h, sign * axis, sign * axis);
    }
  }
  for (const JointFriction& dry : plant_.contacts.frictions) {
    const Eigen::RowVectorXd axis = joint(dry.joint);
    pairs.add_friction(axis, axis, at.v, {.constant = dry.limit * start.h});
  }
  return pairs;
}

void ContactSimulator::add_contact(std::size_t c, const StepStart& start, const ContactStep& at,
                                   bool with_slopes, ContactPairs& pairs) const {
  const ContactCandidate& candidate = plant_.contacts.candidates[c];
  const int tangents = tangent_count(plant_.contacts, candidate);
  const int normal =
      pairs.add(gap_[c] / start.h, (with_slopes ? slope_ : rows_)[c].row(0), rows_[c].row(0));
  if (candidate.stiffness)
    pairs.coupling(normal, normal) = 1 / (*candidate.stiffness * start.h * start.h);
  if (tangents == 0) return;
  if (keeps_slipping(c)) {
    // Friction follows the normal force; the pairs of the pyramid rest.
    pairs.push.row(normal) -=
        candidate.friction * heading_.col(c).transpose() * rows_[c].bottomRows<2>();
    pairs.rest(2 * tangents + 1);
    return;
  }
  const Eigen::MatrixXd turn = pyramid_turn(c, tangents);
  const Eigen::MatrixXd basis = turn * rows_[c].middleRows(1, tangents);
  pairs.add_friction(basis, with_slopes ? turn * slope_[c].middleRows(1, tangents) : basis, at.v,
                     {.factor = candidate.friction, .normal = normal});
}

/// Rotation from the first tangents of a candidate to the edges of its pyramid.
Eigen::MatrixXd ContactSimulator::pyramid_turn(std::size_t c, int tangents) const {
  if (tangents == 2) return Eigen::Rotation2Dd(-pyramid_[c]).toRotationMatrix();
  return Eigen::MatrixXd::Identity(tangents, tangents);
}

/// The forces for impulses z.
StepForces ContactSimulator::forces(const Eigen::VectorXd& z, double h) const {
  StepForces f(plant_.contacts);
  int row = 0;
  for (std::size_t c = 0; c < plant_.contacts.candidates.size(); ++c) {
    const int tangents = tangent_count(plant_.contacts, plant_.contacts.candidates[c]);
    f.contact(0, c) = z[row++] / h;
    if (tangents == 0) continue;
    for (int t = 0; t < tangents; ++t, row += 2) f.contact(1 + t, c) = (z[row] - z[row + 1]) / h;
    ++row;
    if (keeps_slipping(c))
      f.contact.col(c).tail<2>() =
          -plant_.contacts.candidates[c].friction * f.contact(0, c) * heading_.col(c);
    else if (tangents == 2)
      f.contact.col(c).tail<2>() = Eigen::Rotation2Dd(pyramid_[c]) * f.contact.col(c).tail<2>();
  }
  for (std::size_t s = 0; s < plant_.contacts.stops.size(); ++s) {
    const JointStop& stop = plant_.contacts.stops[s];
    if (std::isfinite(stop.lower)) f.stop_lower[s] = z[row++] / h;
    if (std::isfinite(stop.upper)) f.stop_upper[s] = z[row++] / h;
  }
  for (std::size_t d = 0; d < plant_.contacts.frictions.size(); ++d, row += 3)
    f.friction[d] = (z[row] - z[row + 1]) / h;
  return f;
}

/// Inverse of forces(); the slips are those of v.
Eigen::VectorXd ContactSimulator::impulses(const StepForces& forces, const Eigen::VectorXd& v,
                                           double h) const {
  Eigen::VectorXd z = Eigen::VectorXd::Zero(pairs_);
  int row = 0;
  const auto friction = [&](const Eigen::VectorXd& force, const Eigen::VectorXd& slip) {
    for (Eigen::Index t = 0; t < force.size(); ++t) {
      z[row++] = h * std::max(force[t], 0.0);
      z[row++] = h * std::max(-force[t], 0.0);
    }
    z[row++] = slip.cwiseAbs().maxCoeff();
  };
  for (std::size_t c = 0; c < plant_.contacts.candidates.size(); ++c) {
    const int tangents = tangent_count(plant_.contacts, plant_.contacts.candidates[c]);
    z[row++] = h * std::max(forces.contact(0, c), 0.0);
    if (tangents == 0) continue;
    if (keeps_slipping(c)) {
      row += 2 * tangents + 1;
      continue;
    }
    const Eigen::MatrixXd turn = pyramid_turn(c, tangents);
    friction(turn * forces.contact.col(c).segment(1, tangents),
             turn * rows_[c].middleRows(1, tangents) * v);
  }
  for (std::size_t s = 0; s < plant_.contacts.stops.size(); ++s) {
    const JointStop& stop = plant_.contacts.stops[s];
    if (std::isfinite(stop.lower)) z[row++] = h * std::max(forces.stop_lower[s], 0.0);
    if (std::isfinite(stop.upper)) z[row++] = h * std::max(forces.stop_upper[s], 0.0);
  }
  for (std::size_t d = 0; d < plant_.contacts.frictions.size(); ++d) {
    const int joint = plant_.robot->joints[plant_.contacts.frictions[d].joint].v;
    friction(forces.friction.segment(d, 1), v.segment(joint, 1));
  }
  return z;
}

/// Turns the pyramids of a cone to the common direction of slip and force, which is the slip
/// without friction at that contact. Near a solution, slipping contacts keep slipping, against the
/// heading of the last slip: nearly parallel pyramids have other solutions close to it. Returns the
/// largest angle between a slip and its pyramid or heading.
double ContactSimulator::turn_pyramids(const StepStart& start, const ContactStep& at,
                                       double residual) {
  double off = 0;
  if (plant_.contacts.friction != FrictionModel::cone) return off;
  std::vector<std::pair<std::size_t, Eigen::Vector2d>> slips;
  for (std::size_t c = 0; c < plant_.contacts.candidates.size(); ++c) {
    if (tangent_count(plant_.contacts, plant_.contacts.candidates[c]) != 2) continue;
    const Eigen::Matrix2Xd tangents = rows_[c].bottomRows<2>();
    const Eigen::Vector2d slip = tangents * at.v, force = at.forces.contact.col(c).tail<2>();
    const bool bears = at.forces.contact(0, c) > 0;
    if (bears) off = std::max(off, angle_off(c, slip));
    const Eigen::Matrix2d mobility =
        start.h * tangents * A_.partialPivLu().solve(tangents.transpose());
    const Eigen::Vector2d along = slip - 0.5 * mobility.trace() * force;
    if (along.norm() > 0) pyramid_[c] = std::atan2(along.y(), along.x());
    if (bears && slip.norm() > kClearSlip) slips.emplace_back(c, slip.normalized());
  }
  heading_.setZero();
  if (residual + off < kNearStep)
    for (const auto& [c, heading] : slips) heading_.col(c) = heading;
  return off;
}

/// Angle between a slip and the pyramid or heading of its contact.
double ContactSimulator::angle_off(std::size_t c, const Eigen::Vector2d& slip) const {
  const double angle = std::atan2(slip.y(), slip.x());
  if (keeps_slipping(c)) {
    const double turn = angle - std::atan2(heading_(1, c), heading_(0, c));
    return std::abs(std::remainder(turn, 2 * std::numbers::pi));
  }
  // A quarter turn yields the same pyramid.
  return slip.norm() > kSlip ? std::abs(std::remainder(angle - pyramid_[c], std::numbers::pi / 2))
                             : 0;
}

/// A_ plus the change of friction as the headings of slipping contacts turn.
Eigen::MatrixXd ContactSimulator::turning_slope(const StepStart& start,
                                                const ContactStep& at) const {
  Eigen::MatrixXd slope = A_;
  for (std::size_t c = 0; c < rows_.size(); ++c) {
    if (!keeps_slipping(c)) continue;
    const Eigen::Vector2d heading = heading_.col(c);
    const double speed = heading.dot(rows_[c].bottomRows<2>() * at.v);
    const double impulse =
        start.h * plant_.contacts.candidates[c].friction * at.forces.contact(0, c);
    const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - heading * heading.transpose();
    slope +=
        impulse / speed * rows_[c].bottomRows<2>().transpose() * across * slope_[c].bottomRows<2>();
  }
  return slope;
}

/// Residual of the equations at the iterate with impulses z, after linearize() at this iterate.
double ContactSimulator::residual(const StepStart& start, const ContactStep& at,
                                  const Eigen::VectorXd& z) const {
  const double scale = impulse_scale(plant_, start.h);
  const ContactPairs pairs = assemble(start, at, false);
  const Eigen::VectorXd w = pairs.value + pairs.coupling * z;
  double worst = (impulse_ - pairs.push.transpose() * z).cwiseAbs().maxCoeff() / scale;
  for (int i = 0; i < pairs_; ++i) {
    const double gap =
        pairs.budget[i] ? std::min(w[i] / scale, z[i]) : std::min(w[i], z[i] / scale);
    worst = std::max(worst, std::abs(gap));
  }
  return worst;
}

ContactStep ContactSimulator::step(const StepStart& start) {
  ContactStep taken = step_by_pivoting(start);
  if (taken.status == StepStatus::solved || taken.status == StepStatus::not_finite) return taken;
  ContactStep from{StepStatus::unsolved,        start.q,          start.v,
                   StepForces(plant_.contacts), taken.iterations, kUnlimited};
  const ContactStep swept = step_by_sweeps(start, from);
  if (!(swept.residual < taken.residual)) return taken;
  taken = swept;
  if (taken.residual <= options_.tolerance) taken.status = StepStatus::solved;
  return taken;
}

ContactStep ContactSimulator::step(const StepStart& start, const ContactStep& near) {
  const ContactStep taken = step_in_mode(start, near);
  return taken.status == StepStatus::solved ? taken : step(start);
}

/// Moves an iterate by dv, with impulses z.
void ContactSimulator::move(const StepStart& start, const Eigen::VectorXd& z,
                            const Eigen::VectorXd& dv, ContactStep& at) {
  at.v += dv;
  const Eigen::VectorXd reach = start.h * at.v;
  move_configuration(*plant_.robot, start.q.data(), reach.data(), at.q.data());
  at.forces = forces(z, start.h);
  ++at.iterations;
}

/// Returns nullopt if a number is not finite.
std::optional<ContactSimulator::Response> ContactSimulator::respond(const StepStart& start,
                                                                    const ContactStep& at,
                                                                    bool with_slopes) const {
  Response response{assemble(start, at, with_slopes), {}, {}};
  const ContactPairs& pairs = response.pairs;
  if (!A_.allFinite() || !impulse_.allFinite() || !pairs.value.allFinite()) return std::nullopt;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(turning_slope(start, at));
  // Without pairs the solve is skipped: even for no columns it would read the first one.
  response.pushed.resize(A_.rows(), pairs.push.rows());
  if (response.pushed.size() > 0) response.pushed = lu.solve(pairs.push.transpose());
  response.free = lu.solve(impulse_);
  return response;
}

/// Moves an iterate and measures it there. Iterations continue to the last digits while Newton's
/// method still gains some.
ContactSimulator::Progress ContactSimulator::advance(const StepStart& start,
                                                     const Eigen::VectorXd& z,
                                                     const Response& response, ContactStep& at,
                                                     ContactStep& best) {
  move(start, z, response.pushed * z - response.free, at);
  if (!at.v.allFinite() || !at.forces.finite()) return Progress::lost;
  linearize(start, at, true);
  const double before = at.residual;
  at.residual = residual(start, at, z);
  at.residual += turn_pyramids(start, at, at.residual);
  if (!(at.residual < kUnlimited)) return Progress::lost;
  if (at.residual < best.residual) best = at;
  const bool stalls = best.residual <= options_.tolerance && at.residual >= 0.1 * before;
  return stalls || best.residual <= kRounding ? Progress::ends : Progress::goes_on;
}

/// Pairs whose z may be positive at an iterate; the smaller entry of each pair vanishes.
std::vector<int> ContactSimulator::find_active(const StepStart& start,
                                               const ContactStep& at) const {
  const double scale = impulse_scale(plant_, start.h);
  const Eigen::VectorXd z = impulses(at.forces, at.v, start.h);
  const ContactPairs pairs = assemble(start, at, false);
  const Eigen::VectorXd w = pairs.value + pairs.coupling * z;
  std::vector<bool> chosen(pairs_);
  for (int i = 0; i < pairs_; ++i)
    chosen[i] = pairs.budget[i] ? z[i] > w[i] / scale : z[i] / scale > w[i];
  // If a contact slips, an edge against the slip gives the speed, even without a force.
  for (int b = 0; b < pairs_; ++b)
    if (pairs.budget[b] && chosen[b])
      if (const auto edge = pairs.slowest_edge(b, w)) chosen[*edge] = true;
  std::vector<int> active;
  for (int i = 0; i < pairs_; ++i)
    if (chosen[i]) active.push_back(i);
  return active;
}

/// Newton's method with the pairs split as in `near`: the smaller entry of each pair vanishes. The
/// least-squares solution of the remaining equations also solves them if contacts share a load.
ContactStep ContactSimulator::step_in_mode(const StepStart& start, const ContactStep& near) {
  ContactStep at{StepStatus::unsolved, start.q, near.v, near.forces, 0, kUnlimited};
  const Eigen::VectorXd reach = start.h * at.v;
  move_configuration(*plant_.robot, start.q.data(), reach.data(), at.q.data());
  pyramid_.setZero();
  heading_.setZero();
  linearize(start, at, true);
  turn_pyramids(start, at, 0);
  const std::vector<int> active = find_active(start, at);
  ContactStep best = at;
  for (int k = 0; k < options_.max_iterations; ++k) {
    const auto response = respond(start, at, true);
    if (!response) break;
    Eigen::VectorXd z = Eigen::VectorXd::Zero(pairs_);
    if (!active.empty()) {
      const Eigen::MatrixXd some = response->matrix()(active, active);
      const Eigen::VectorXd wanted = -response->offset()(active);
      const Eigen::VectorXd found = some.completeOrthogonalDecomposition().solve(wanted);
      z(active) = found;
    }
    if (advance(start, z, *response, at, best) != Progress::goes_on) break;
  }
  if (best.residual <= options_.tolerance) best.status = StepStatus::solved;
  return best;
}

ContactStep ContactSimulator::step_by_pivoting(const StepStart& start) {
  ContactStep at{StepStatus::unsolved,        start.q, start.v,
                 StepForces(plant_.contacts), 0,       kUnlimited};
  const auto give_up = [&](StepStatus status) {
    ContactStep still{status, start.q, start.v, StepForces(plant_.contacts), at.iterations};
    still.residual = kUnlimited;
    return still;
  };
  if (!start.q.allFinite() || !start.v.allFinite() || !start.applied.allFinite())
    return give_up(StepStatus::not_finite);
  pyramid_.setZero();
  heading_.setZero();
  ContactStep best = at;
  linearize(start, at, true);
  for (int k = 0; k < options_.max_iterations; ++k) {
    const bool careful = k >= options_.max_iterations / 2;
    Pivoted pivoted = pivot(start, at, careful);
    if (!pivoted.response) return give_up(StepStatus::not_finite);
    if (!pivoted.z) return best.residual < kUnlimited ? best : give_up(StepStatus::no_contact);
    const Progress progress = advance(start, *pivoted.z, *pivoted.response, at, best);
    if (progress == Progress::lost) return give_up(StepStatus::not_finite);
    if (progress == Progress::ends) break;
  }
  if (best.residual <= options_.tolerance) best.status = StepStatus::solved;
  return best;
}

/// Finds impulses by pivoting, first with the derivatives of the force directions, then without
/// them. If `careful`, it omits them at once.
ContactSimulator::Pivoted ContactSimulator::pivot(const StepStart& start, const ContactStep& at,
                                                  bool careful) {
  Pivoted pivoted;
  for (const bool exact : {true, false}) {
    if (exact && careful) continue;
    if (!exact) linearize(start, at, false);
    pivoted.response = respond(start, at, exact);
    if (!pivoted.response) break;
    pivoted.z = solve_nearly(pivoted.response->matrix(), pivoted.response->offset());
    if (pivoted.z) break;
  }
  return pivoted;
}

}  // namespace conddp
