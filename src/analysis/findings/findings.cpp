#include "analysis/findings/findings.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "analysis/findings/contact_findings.hpp"
#include "systems/collocation_system.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// Limits and constraints that are met exactly are missed by rounding and by tolerances.
constexpr double kSlack = 1e-6;
/// What is violated between knots is told where it is more than at knots by this, in its unit.
constexpr double kBetween = 1e-4;
constexpr int kPartsOfAStep = 4;

class Search {
 public:
  Search(const ShootingProblem& problem, const Trajectory& trajectory, const FindingNames& names)
      : problem_(problem),
        trajectory_(trajectory),
        names_(names),
        times_(problem.times(trajectory)) {}

  std::vector<Finding> run() {
    for (int k = 0; k <= problem_.knots(); ++k) joints(k);
    for (int k = 0; k < problem_.knots(); ++k) efforts(k);
    for (auto& [name, effort] : efforts_) report(name, effort);
    find_in_contacts(problem_, trajectory_, names_, list_);
    rows();
    between();
    last_knot();
    thrusters();
    std::stable_sort(list_.begin(), list_.end(), [](const Finding& a, const Finding& b) {
      return a.kind != b.kind ? a.kind < b.kind : a.value > b.value;
    });
    return std::move(list_);
  }

 private:
  struct Effort {
    std::string unit;
    double limit = 0, beyond = 0, seconds = 0, all = 0;
    int knot = -1;
  };

  Finding& add(FindingKind kind, const std::string& subject, double value, std::string unit,
               int k) {
    Finding& f = list_.emplace_back();
    f.kind = kind;
    f.subject = subject;
    f.value = value;
    f.unit = std::move(unit);
    f.knot = k;
    f.time = k < 0 ? 0 : times_[k];
    return f;
  }

  /// The one of this kind and subject, with what it takes to be a new worst case.
  Finding* worst(FindingKind kind, const std::string& subject, double value, const char* unit,
                 int k) {
    if (!(value > kSlack)) return nullptr;
    for (Finding& f : list_)
      if (f.kind == kind && f.subject == subject) {
        if (value <= f.value) return nullptr;
        f.value = value;
        f.knot = k;
        f.time = times_[k];
        return &f;
      }
    return &add(kind, subject, value, unit, k);
  }

  void joints(int k) {
    const MultibodySystem* robot = problem_.knot(k).model->system().robot_inside();
    if (robot == nullptr) return;
    const auto x = trajectory_.x(k);
    for (int j = 0; j < robot->robot().joint_count(); ++j) {
      const Joint& joint = robot->robot().joints[j];
      const auto q = robot->position_index(j), v = robot->velocity_index(j);
      if (!q || !v || joint.type == JointType::floating) continue;
      const auto limits = robot->limits(j);
      const bool slides = joint.type == JointType::prismatic;
      const double off = std::max(limits.lower - x[*q], x[*q] - limits.upper);
      const char* unit = slides ? "m" : "rad";
      if (Finding* f = worst(FindingKind::position_limit, joint.name, off, unit, k)) {
        f->message =
            fmt::format("the position of '{}' is beyond its limit of {:.4g} {} by {:.3g}",
                        joint.name, x[*q] > limits.upper ? limits.upper : limits.lower, unit, off);
        f->remedy = "constraints: {NAME: {bounds: configuration, from: urdf}}";
      }
      unit = slides ? "m/s" : "rad/s";
      if (Finding* f = worst(FindingKind::velocity_limit, joint.name,
                             std::abs(x[*v]) - limits.max_velocity, unit, k)) {
        f->message = fmt::format("the velocity of '{}' is beyond its limit of {:.4g} {} by {:.3g}",
                                 joint.name, limits.max_velocity, unit,
                                 std::abs(x[*v]) - limits.max_velocity);
        f->remedy = "constraints: {NAME: {bounds: velocity, from: urdf}}";
      }
    }
  }

  void efforts(int k) {
    const MultibodySystem* robot = problem_.knot(k).model->system().robot_inside();
    if (robot == nullptr || problem_.takes_no_time(k)) return;
    const Actuation& actuation = robot->actuation();
    for (int i = 0; i < actuation.nu; ++i) {
      const double u = trajectory_.u(k)[i], step = times_[k + 1] - times_[k];
      const double limit = u > 0 ? actuation.upper[i] : actuation.lower[i];
      Effort& effort = efforts_[actuation.columns[i].name];
      effort.all += step;
      if (limit == 0 || !std::isfinite(limit)) continue;
      const double beyond = std::abs(u) - std::abs(limit);
      if (beyond < -kSlack * std::abs(limit)) continue;
      effort.unit = actuation.columns[i].unit;
      effort.seconds += step;
      if (effort.knot < 0 || beyond > effort.beyond) {
        effort.knot = k;
        effort.limit = limit;
        effort.beyond = std::max(beyond, 0.0);
      }
    }
  }

  void report(const std::string& name, const Effort& effort) {
    if (effort.knot < 0) return;
    const bool beyond = effort.beyond > kSlack * std::max(1.0, std::abs(effort.limit));
    Finding& f = add(FindingKind::effort_limit, name, beyond ? effort.beyond : effort.seconds,
                     beyond ? effort.unit : "s", effort.knot);
    if (beyond) {
      f.message = fmt::format("{} is {:.3g} {} beyond its limit of {:.3g}", name, effort.beyond,
                              effort.unit, effort.limit);
      f.remedy = "constraints: {NAME: {bounds: control, from: urdf}}";
    } else {
      f.message = fmt::format("{} is at its limit of {:.3g} {} for {:.3g} s of {:.3g} s", name,
                              effort.limit, effort.unit, effort.seconds, effort.all);
    }
  }

  std::string name_of(const NodeConstraint& c) const {
    return (c.node == problem_.knots() ? "terminal/" : "") + c.term->name;
  }

  /// Which row of a constraint with named rows is violated, the worst one.
  void rows() {
    for (const auto* constraints : {&problem_.constraints(), &problem_.soft_constraints()})
      for (const NodeConstraint& c : *constraints) {
        const auto names = names_.rows.find(name_of(c));
        if (names == names_.rows.end() || c.lower == nullptr ||
            static_cast<int>(names->second.size()) != c.term->rows)
          continue;
        evaluate(c.node, trajectory_.x(c.node));
        const Eigen::VectorXd values = values_of(c);
        for (int i = 0; i < c.term->rows; ++i) {
          const double off = std::max(c.lower[i] - values[i], values[i] - c.upper[i]);
          const std::string subject = names->second[i] + " (" + name_of(c) + ")";
          if (Finding* f = worst(FindingKind::constraint_row, subject, off, "m", c.node)) {
            f->message = fmt::format("'{}' is violated by {:.3g} m by {}", name_of(c), off,
                                     names->second[i]);
          }
        }
      }
  }

  /// The constraints of a node at a state, with its controls.
  void evaluate(int k, const Eigen::VectorXd& x) {
    const KnotView& view = problem_.knot(k);
    auto& work = memory_[view.model];
    if (!work) work = std::make_unique<KnotWorkspace<double>>(*view.model);
    const double* u = k < problem_.knots() ? trajectory_.u(k).data() : nullptr;
    view.model->evaluate(KnotInput<double>{x.data(), u, view.parameters, view.dt, view.cost_scale},
                         *work);
  }
  /// g of one of them, as evaluated.
  Eigen::VectorXd values_of(const NodeConstraint& c) const {
    return Eigen::Map<const Eigen::VectorXd>(
        memory_.at(problem_.knot(c.node).model)->constraint.data() + c.term->row, c.term->rows);
  }

  /// Inequalities of the state along the straight way from one node to the next.
  void between() {
    const int ndx = problem_.ndx();
    std::map<std::string, double> at_knots;
    std::vector<const NodeConstraint*> watched;
    Eigen::VectorXd way(ndx), x(problem_.nx());
    int evaluated = -1;
    for (const NodeConstraint& c : problem_.constraints()) {
      if (!c.term->has_bounds() || c.is_soft() || c.term->depends_on_control(ndx)) continue;
      bool inequality = false;
      for (int i = 0; i < c.term->rows; ++i) inequality |= c.lower[i] < c.upper[i];
      if (!inequality) continue;
      watched.push_back(&c);
      if (c.node != evaluated) evaluate(evaluated = c.node, trajectory_.x(c.node));
      const Eigen::VectorXd values = values_of(c);
      double& most = at_knots[c.term->name];
      most = std::max(most, distance_to_set(*c.term, values.data(), c.lower, c.upper));
    }
    for (std::size_t first = 0, last = 0; first < watched.size(); first = last) {
      const int k = watched[first]->node;
      while (last < watched.size() && watched[last]->node == k) ++last;
      if (k == problem_.knots() || problem_.takes_no_time(k)) continue;
      problem_.manifold().difference(trajectory_.x(k).data(), trajectory_.x(k + 1).data(),
                                     way.data());
      for (int part = 1; part < kPartsOfAStep; ++part) {
        const Eigen::VectorXd dx = way * (static_cast<double>(part) / kPartsOfAStep);
        problem_.manifold().integrate(trajectory_.x(k).data(), dx.data(), x.data());
        evaluate(k, x);
        for (std::size_t i = first; i < last; ++i) look_between(*watched[i], at_knots);
      }
    }
  }

  void look_between(const NodeConstraint& c, const std::map<std::string, double>& at_knots) {
    const double usual = at_knots.at(c.term->name);
    const Eigen::VectorXd values = values_of(c);
    const double off = distance_to_set(*c.term, values.data(), c.lower, c.upper);
    if (off <= usual + kBetween) return;
    Finding* f = worst(FindingKind::between_knots, c.term->name, off, "", c.node);
    if (f == nullptr) return;
    f->message =
        fmt::format("'{}' is violated by {:.3g}{} between knots {} and {}, by {:.1e} at knots",
                    c.term->name, off, offender(c, values), c.node, c.node + 1, usual);
    f->remedy = "more knots, or wider distances";
  }

  /// " m by forearm - table", where rows have names.
  std::string offender(const NodeConstraint& c, const Eigen::VectorXd& values) const {
    const auto names = names_.rows.find(name_of(c));
    if (names == names_.rows.end() || static_cast<int>(names->second.size()) != c.term->rows)
      return {};
    int row = 0;
    double most = 0;
    for (int i = 0; i < c.term->rows; ++i)
      if (const double off = std::max(c.lower[i] - values[i], values[i] - c.upper[i]); off > most) {
        most = off;
        row = i;
      }
    return " m by " + names->second[row];
  }

  /// Controls that change in the last step as they do nowhere in their phase before.
  void last_knot() {
    constexpr int kFewestKnots = 6;
    constexpr double kFactor = 3, kShare = 0.2;
    const int N = problem_.knots();
    int first = N - 1;
    while (first > 0 && problem_.knot(first - 1).phase == problem_.knot(N - 1).phase) --first;
    const System& system = problem_.knot(N - 1).model->system();
    if (N - first < kFewestKnots || problem_.takes_no_time(N - 1)) return;
    for (int i = 0; i < system.actuators(); ++i) {
      double most = 0, low = trajectory_.u(first)[i], high = low;
      for (int k = first + 1; k < N; ++k) {
        const double u = trajectory_.u(k)[i];
        if (k < N - 1) most = std::max(most, std::abs(u - trajectory_.u(k - 1)[i]));
        low = std::min(low, u);
        high = std::max(high, u);
      }
      const double jump = std::abs(trajectory_.u(N - 1)[i] - trajectory_.u(N - 2)[i]);
      if (jump <= kFactor * most || jump <= kShare * (high - low) || jump <= kSlack) continue;
      const Column& column = system.control_columns()[i];
      Finding& f = add(FindingKind::last_knot, column.name, jump, column.unit, N - 1);
      f.message = fmt::format("{} jumps by {:.3g} {} at the last knot, by {:.3g} at most before",
                              column.name, jump, column.unit, most);
      f.remedy = "smaller weights of terminal costs, a cost 'control_rate', or more time";
    }
  }

  /// Bodies that nothing but thrusters drives, and about which axes those cannot turn them.
  void thrusters() {
    const MultibodySystem* robot = problem_.knot(0).model->system().robot_inside();
    if (robot == nullptr) return;
    for (int k = 0; k < problem_.knots(); ++k)
      if (const auto* held = problem_.knot(k).model->system().robot_inside();
          held == nullptr || !held->contacts().empty() ||
          problem_.knot(k).model->system().as_stepping() != nullptr)
        return;
    const Actuation& actuation = robot->actuation();
    const Eigen::Map<const Eigen::MatrixXd> B(actuation.B.data(), robot->nv(), actuation.nu);
    for (int j = 0; j < robot->robot().joint_count(); ++j) {
      const Joint& joint = robot->robot().joints[j];
      const auto row = robot->velocity_row(j);
      if (joint.type != JointType::floating || !row) continue;
      const bool moves_others =
          j + 1 < robot->robot().joint_count() && robot->robot().root[j + 1] == j;
      const Eigen::MatrixXd force = B.middleRows(*row, 3);
      if (moves_others || force.isZero(0)) continue;
      const Vector3<double> c = (1 / joint.inertia.mass) * joint.inertia.moment;
      Eigen::Matrix3d arm;
      arm << 0, -c.z, c.y, c.z, 0, -c.x, -c.y, c.x, 0;
      const Eigen::MatrixXd torque = B.middleRows(*row + 3, 3) - arm * force;
      // Rounding is measured by the forces, at a metre.
      Eigen::JacobiSVD<Eigen::MatrixXd> svd(torque);
      const int rank = static_cast<int>(
          (svd.singularValues().array() > 1e-9 * force.cwiseAbs().maxCoeff()).count());
      if (rank == 3) continue;
      std::string axes;
      for (int i = 0; i < 3; ++i)
        if (torque.row(i).cwiseAbs().maxCoeff() < 1e-9 * force.cwiseAbs().maxCoeff())
          axes += (axes.empty() ? "" : ", ") + std::string(1, "xyz"[i]);
      Finding& f = add(FindingKind::thrusters, joint.name, 3 - rank, "1", -1);
      f.message = fmt::format(
          "the thrusters cannot turn the body of '{}' about {}", joint.name,
          axes.empty() ? fmt::format("{} of 3 directions", 3 - rank) : "its axes " + axes);
      f.remedy = "thrusters off the centre of mass in other directions, or with a torque_ratio";
    }
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const FindingNames& names_;
  const std::vector<double> times_;
  std::map<const KnotModel*, std::unique_ptr<KnotWorkspace<double>>> memory_;
  std::map<std::string, Effort> efforts_;
  std::vector<Finding> list_;
};

}  // namespace

std::vector<Finding> find_in_motion(const ShootingProblem& problem, const Trajectory& trajectory,
                                    const FindingNames& names) {
  for (int k = 0; k <= problem.knots(); ++k)
    if (!trajectory.x(k).allFinite() || (k < problem.knots() && !trajectory.u(k).allFinite()))
      return {};
  return Search(problem, trajectory, names).run();
}

}  // namespace conddp
