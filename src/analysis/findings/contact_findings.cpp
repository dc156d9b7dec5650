#include "analysis/findings/contact_findings.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "base/exceeds.hpp"
#include "robot/frames.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// Drift above which a contact is reported, m.
constexpr double kDrift = 1e-3;
/// Above this kd h, a velocity is gone after a step.
constexpr double kFull = 0.95;
/// Forces below this share of the weight do not count for friction.
constexpr double kLight = 1e-3;

const MultibodySystem* robot_at(const ShootingProblem& problem, int k) {
  return problem.knot(k).model->system().as_multibody();
}

/// Distance that a frame has moved along the directions held by its contact, m.
double moved(const Contact& contact, const SE3<double>& from, const SE3<double>& to) {
  const Vector3<double> way = to.p - from.p;
  const auto along = [&](const Vector3<double>& direction) {
    return dot(way, contact.axes == FrameAxes::local ? from.R * direction : direction);
  };
  if (contact.kind == ContactKind::normal) return std::abs(along(contact.normal));
  if (contact.kind == ContactKind::planar)
    return std::hypot(along(contact.normal), along(contact.tangent));
  return std::sqrt(squared_norm(way));
}

class Watch {
 public:
  Watch(const ShootingProblem& problem, const Trajectory& trajectory, const NodeValues& values,
        const FindingNames& names, std::vector<Finding>& list)
      : problem_(problem),
        trajectory_(trajectory),
        values_(values),
        names_(names),
        list_(list),
        times_(problem.times(trajectory)) {}

  void run() {
    for (int k = 0; k < problem_.knots(); ++k) {
      const MultibodySystem* system = robot_at(problem_, k);
      if (system == nullptr) continue;
      const auto& contacts = system->contacts().contacts();
      if (contacts.empty()) continue;
      for (std::size_t c = 0; c < contacts.size(); ++c)
        if (!problem_.takes_no_time(k) && !held_before(k, contacts[c].name))
          stance(k, contacts[c].name);
      const std::span<const HeldContact> held = values_.contacts(k);
      for (std::size_t c = 0; c < contacts.size(); ++c) forces(k, *system, contacts[c], held[c]);
    }
    report();
    ranks();
  }

 private:
  struct Worst {
    double value = 0;
    int knot = -1;
    bool impulse = false;
  };
  struct Drift : Worst {
    int first = 0, last = 0;  ///< nodes of the stance
    Contact contact;
    double speed = 0;     ///< at the touch-down, over the step before, m/s
    bool placed = false;  ///< the stance begins where kp draws the contact, at the initial place
  };

  static int index_of(const MultibodySystem* system, const std::string& name) {
    if (system == nullptr) return -1;
    for (int c = 0; c < system->contacts().count(); ++c)
      if (system->contacts().contacts()[c].name == name) return c;
    return -1;
  }
  bool held_before(int k, const std::string& name) const {
    return k > 0 && !problem_.takes_no_time(k - 1) &&
           index_of(robot_at(problem_, k - 1), name) >= 0;
  }

  /// Measures the drift of a stance from its first knot to the last consecutive one.
  void stance(int first, const std::string& name) {
    Drift drift;
    drift.first = first;
    SE3<double> start = SE3<double>::identity();
    for (int k = first; k < problem_.knots(); ++k) {
      const MultibodySystem* system = robot_at(problem_, k);
      const int c = index_of(system, name);
      if (c < 0 || (k > first && problem_.takes_no_time(k))) break;
      if (k == first) {
        drift.contact = system->contacts().contacts()[c];
        start = pose(*system, drift.contact, k);
        drift.speed = approach(*system, drift.contact, k, start);
      }
      const SE3<double> now = pose(*system, system->contacts().contacts()[c], k + 1);
      drift.last = k + 1;
      double& longest = longest_steps_[name];
      longest = std::max(
          {longest, times_[k + 1] - times_[k], problem_.times()[k + 1] - problem_.times()[k]});
      if (const double way = moved(drift.contact, start, now); exceeds(way, drift.value)) {
        drift.value = way;
        drift.knot = k + 1;
      }
    }
    if (drift.value <= kDrift) return;
    drift.placed = drift.contact.kp == 0
                       ? first == 0
                       : moved(drift.contact, drift.contact.reference, start) <= drift.value;
    Drift& worst = drifts_[name];
    if (exceeds(drift.value, worst.value)) worst = drift;
  }

  /// Speed of a contact that closes at a node without an impulse, from the step before.
  double approach(const MultibodySystem& system, const Contact& contact, int node,
                  const SE3<double>& there) {
    if (node == 0 || problem_.takes_no_time(node - 1)) return 0;
    return moved(contact, pose(system, contact, node - 1), there) /
           (times_[node] - times_[node - 1]);
  }

  /// Pose of a contact's frame in its base at a node, taken from the knot if the contact is held
  /// there.
  SE3<double> pose(const MultibodySystem& system, const Contact& contact, int node) {
    if (node < problem_.knots())
      if (const int c = index_of(robot_at(problem_, node), contact.name); c >= 0)
        return values_.contacts(node)[c].in_base;
    MultibodySystem::Data<double>& data = data_of(system);
    system.update_kinematics(trajectory_.x(node).data(), data);
    return relative_placement(system.robot(), data.robot, contact.pair());
  }

  MultibodySystem::Data<double>& data_of(const MultibodySystem& system) {
    auto& data = memory_[&system];
    if (!data) data = system.create_data(double{});
    return static_cast<MultibodySystem::Data<double>&>(*data);
  }

  /// A small share of the weight, or of the momentum at 1 m/s.
  static double light_force(const RobotModel& robot, bool impulse) {
    double mass = 0;
    for (const Joint& joint : robot.joints) mass += joint.inertia.mass;
    const double gravity = std::sqrt(squared_norm(robot.gravity));
    return kLight * mass * (impulse || gravity == 0 ? 1 : gravity);
  }

  /// What a contact with the world needs from the ground. Two frames can hold each other.
  void forces(int k, const MultibodySystem& system, const Contact& contact, const HeldContact& at) {
    if (contact.base) return;
    const Vector3<double> force = at.force.linear;
    const Vector3<double> normal =
        contact.axes == FrameAxes::local ? at.world.R * contact.normal : contact.normal;
    const double up = dot(force, normal);
    const bool impulse = system.kind() == SystemKind::impulse;
    const double light = light_force(system.robot(), impulse);
    if (-up > light) meet(pulls_[contact.name], -up, k, impulse);
    if (contact.kind == ContactKind::normal || up <= light) return;
    meet(demands_[contact.name], std::sqrt(squared_norm(force - up * normal)) / up, k, impulse);
  }

  static void meet(Worst& worst, double value, int k, bool impulse) {
    if (exceeds(value, worst.value)) worst = {value, k, impulse};
  }

  void report() {
    for (const auto& [name, drift] : drifts_) add_drift(name, drift);
    add_demands();
    add_pulls();
  }

  void add_demands() {
    // The greatest demand is reported even if the ground meets it.
    const Worst* greatest = nullptr;
    for (const auto& [name, demand] : demands_)
      if (exceeds(demand.value, greatest ? greatest->value : 0)) greatest = &demand;
    for (const auto& [name, demand] : demands_) {
      const std::optional<double> has = friction_of(name);
      const bool beyond = has && demand.value > *has * (1 + 1e-6);
      if (beyond || &demand == greatest) add_demand(name, demand, has, beyond);
    }
  }

  /// Friction coefficient of a contact according to the file.
  std::optional<double> friction_of(const std::string& name) const {
    const auto known = names_.friction.find(name);
    return known == names_.friction.end() ? std::nullopt : std::optional(known->second);
  }

  void add_pulls() {
    for (const auto& [name, pull] : pulls_) {
      Finding f{FindingKind::pull, name, pull.value, pull.impulse ? "Ns" : "N"};
      f.message = fmt::format("the contact '{}' pulls with {:.3g} {}", name, f.value, f.unit);
      f.remedy = pull.impulse ? impulse_remedy(name) : cone_remedy(name);
      add(std::move(f), pull.knot);
    }
  }

  /// `has`: the friction coefficient, if known.
  void add_demand(const std::string& name, const Worst& demand, std::optional<double> has,
                  bool beyond) {
    Finding f{FindingKind::friction_demand, name, demand.value, "1"};
    f.message = fmt::format("the contact '{}' needs a coefficient of friction of {:.3g}", name,
                            demand.value);
    if (has) f.message += fmt::format(", {:.3g} {}", *has, beyond ? "is what it has" : "are there");
    if (beyond)
      f.remedy = demand.impulse
                     ? impulse_remedy(name) + ", a touch-down with less speed along the ground"
                     : cone_remedy(name);
    add(std::move(f), demand.knot);
  }

  /// Remedy that the file does not contain yet. Empty if a constraint already enforces the cone
  /// throughout; it is violated then.
  std::string cone_remedy(const std::string& contact) const {
    const auto found = names_.cones.find(contact);
    if (found == names_.cones.end()) return "a constraint or cost 'friction_cone' on it";
    const FindingNames::Cone* cost = nullptr;
    for (const FindingNames::Cone& cone : found->second) {
      if (cone.constraint && cone.throughout) return "";
      if (!cone.constraint && cone.throughout) cost = &cone;
    }
    if (cost != nullptr)
      return fmt::format("a larger weight of the cost '{}', or a constraint 'friction_cone'",
                         cost->name);
    const FindingNames::Cone& some = found->second.front();
    return fmt::format("the {} '{}' at all knots", some.constraint ? "constraint" : "cost",
                       some.name);
  }

  /// Remedy for impulses: costs and constraints apply only to the impulses that they name.
  std::string impulse_remedy(const std::string& contact) const {
    constexpr std::size_t kNamed = 4;
    std::vector<std::string> phases;
    for (const Phase& phase : problem_.phases())
      if (const System& system = phase.model->system();
          system.kind() == SystemKind::impulse && index_of(system.as_multibody(), contact) >= 0)
        phases.push_back(phase.name);
    const bool more = phases.size() > kNamed;
    phases.resize(std::min(phases.size(), kNamed));
    return fmt::format("a constraint or cost 'friction_cone' with 'phases: {}{}{}{}'",
                       phases.size() > 1 ? "[" : "", fmt::join(phases, ", "), more ? ", ..." : "",
                       phases.size() > 1 ? "]" : "");
  }

  void add_drift(const std::string& name, const Drift& drift) {
    Finding f{FindingKind::drift, name, drift.value, "m"};
    f.message = fmt::format(
        "the contact '{}' drifts by {:.1f} mm while it is held from {:.3g} s to {:.3g} s with kd "
        "{:g}",
        name, 1e3 * drift.value, times_[drift.first], times_[drift.last], drift.contact.kd);
    f.remedy = drift_remedy(name, drift);
    add(std::move(f), drift.knot);
  }

  /// A contact that is made at velocity v moves on by v / kd, by steps of Euler's rules by
  /// v h (1 − r)/r, r = kd h, because a step of h leaves them (1 − r) v. With kd = 1/h this is
  /// zero, and the remaining drift is the error of the step itself. One kd is for all stances, and
  /// for the steps of the file where durations are free.
  std::string drift_remedy(const std::string& name, const Drift& drift) const {
    const int order = info_of(problem_.knot(drift.first).model->integrator()).order;
    const double kd = drift.contact.kd, step = longest_steps_.at(name);
    if (order > 1 && 2 * drift.speed > kd * drift.value)
      return fmt::format("{} where it touches down, at {:.2g} m/s", kImpulseRemedy, drift.speed);
    const auto known = names_.contact_keys.find(name);
    const std::string key = known == names_.contact_keys.end() ? "contacts." + name : known->second;
    if (kd * step < kFull) return fmt::format("{}.baumgarte: {{kd: {:.3g}}}", key, 1 / step);
    std::string remedy = fmt::format("a smaller dt with {}.baumgarte.kd: 1/dt", key);
    if (drift.placed)
      remedy += fmt::format(", or {}{}.baumgarte.kp", drift.contact.kp > 0 ? "a larger " : "", key);
    return remedy;
  }

  void ranks() {
    const Phase* before = nullptr;
    for (int k = 0; k < problem_.knots(); ++k) {
      const Phase& phase = problem_.phases()[problem_.knot(k).phase];
      if (&phase == before) continue;
      before = &phase;
      const ContactRank found =
          problem_.knot(k).model->system().contact_rank(trajectory_.x(k).data());
      if (found.redundant.empty()) continue;
      const std::string names = fmt::format("{}", fmt::join(found.redundant, ", "));
      Finding f{FindingKind::redundant_contacts, names,
                static_cast<double>(found.rows - found.rank), "1"};
      f.message = fmt::format(
          "the contacts {} of phase '{}' are redundant: of all {} rows {} are independent, and the "
          "smallest forces are used",
          names, phase.name, found.rows, found.rank);
      add(std::move(f), k);
    }
  }

  void add(Finding f, int k) {
    f.knot = k;
    f.time = times_[k];
    list_.push_back(std::move(f));
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const NodeValues& values_;
  const FindingNames& names_;
  std::vector<Finding>& list_;
  const std::vector<double> times_;
  std::map<const MultibodySystem*, std::unique_ptr<SystemData<double>>> memory_;
  std::map<std::string, Worst> demands_, pulls_;
  std::map<std::string, Drift> drifts_;
  std::map<std::string, double> longest_steps_;  ///< of all knots that hold the contact, s
};

}  // namespace

void find_in_contacts(const ShootingProblem& problem, const Trajectory& trajectory,
                      const NodeValues& values, const FindingNames& names,
                      std::vector<Finding>& list) {
  Watch(problem, trajectory, values, names, list).run();
}

}  // namespace conddp
