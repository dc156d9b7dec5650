#include "analysis/certificate/replay.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include <Eigen/Dense>

#include "base/exceeds.hpp"
#include "base/matrix_decompositions.hpp"
#include "ocp/knot/collocation_residual.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {
namespace {

/// Records violated limits, one instant after another.
class LimitWatch {
 public:
  void look(const System& system, const SystemData<double>& data, const double* x, int knot,
            double time, bool at_knot) {
    const auto* robot = system.as_multibody();
    if (robot == nullptr) return;
    instant_ = {knot, time, at_knot};
    joints(*robot, x);
    if (system.kind() != SystemKind::impulse)
      contacts(*robot, static_cast<const MultibodySystem::Data<double>&>(data));
  }

  std::vector<BrokenLimit> broken() const {
    std::vector<BrokenLimit> list;
    for (const auto& [name, entry] : excess_)
      if (entry.worst.excess > kSlack) {
        list.push_back(entry.worst);
        list.back().between = entry.at_knots < entry.worst.excess;
      }
    return list;
  }

 private:
  /// Slack for limits that a plan reaches exactly, up to rounding.
  static constexpr double kSlack = 1e-6;

  struct Instant {
    int knot;
    double time;
    bool at_knot;
  };
  struct Entry {
    BrokenLimit worst;
    double at_knots = 0;
  };

  void meet(const std::string& quantity, const char* unit, double excess) {
    if (!(excess > 0)) return;
    Entry& entry = excess_[quantity];
    if (instant_.at_knot) entry.at_knots = std::max(entry.at_knots, excess);
    if (exceeds(excess, entry.worst.excess))
      entry.worst = {quantity, unit, excess, instant_.knot, instant_.time, false};
  }

  void joints(const MultibodySystem& system, const double* x) {
    for (int j = 0; j < system.robot().joint_count(); ++j) {
      const auto q = system.position_index(j), v = system.velocity_index(j);
      if (!q || !v || system.robot().joints[j].type == JointType::floating) continue;
      const MultibodySystem::JointLimits limits = system.limits(j);
      const std::string& name = system.robot().joints[j].name;
      const bool slides = system.robot().joints[j].type == JointType::prismatic;
      meet("position of " + name, slides ? "m" : "rad",
           std::max(limits.lower - x[*q], x[*q] - limits.upper));
      meet("velocity of " + name, slides ? "m/s" : "rad/s", std::abs(x[*v]) - limits.max_velocity);
    }
  }

  /// Checks that no contact pulls: the ground cannot hold a foot back. Two frames can hold each
  /// other.
  void contacts(const MultibodySystem& system, const MultibodySystem::Data<double>& data) {
    for (int i = 0; i < system.contacts().count(); ++i) {
      const Contact& contact = system.contacts().contacts()[i];
      if (contact.kind == ContactKind::planar || contact.base) continue;
      const ContactData<double>& at = data.contacts.contacts[i];
      const Vector3<double> force =
          contact.axes == FrameAxes::local ? at.local.linear : contact_force_in_world(at).linear;
      meet("pull of " + contact.name, "N", -dot(force, contact.normal));
    }
  }

  Instant instant_{};
  std::map<std::string, Entry> excess_;
};

class Player {
 public:
  Player(const ShootingProblem& problem, const Trajectory& trajectory,
         const std::vector<Eigen::MatrixXd>& gains, int substeps, Eigen::VectorXd scale)
      : problem_(problem),
        trajectory_(trajectory),
        gains_(gains),
        substeps_(substeps),
        times_(problem.times(trajectory)),
        scale_(std::move(scale)) {}

  ReplayRun run(bool feedback, LimitWatch* watch) {
    ReplayRun result;
    Eigen::VectorXd x =
        Eigen::Map<const Eigen::VectorXd>(problem_.initial_state().data(), problem_.nx());
    for (int k = 0; k < problem_.knots(); ++k) {
      step(k, feedback, x, watch, result);
      if (!x.allFinite()) {
        result.lost_at = k;
        return result;
      }
      compare(k + 1, x, result);
    }
    return result;
  }

 private:
  Eigen::VectorXd control(int k, bool feedback, const Eigen::VectorXd& x, ReplayRun& result) {
    Eigen::VectorXd u = trajectory_.u(k);
    if (!feedback || u.size() == 0 || gains_.empty()) return u;
    Eigen::VectorXd off(problem_.ndx());
    problem_.manifold().difference(trajectory_.x(k).data(), x.data(), off.data());
    u += gains_[k] * off;
    const KnotModel& model = *problem_.knot(k).model;
    for (Eigen::Index i = 0; i < u.size(); ++i) {
      const double inside =
          std::max(model.control_lower()[i], std::min(u[i], model.control_upper()[i]));
      result.saturated += inside != u[i] && inside != trajectory_.u(k)[i];
      u[i] = inside;
    }
    return u;
  }

  void step(int k, bool feedback, Eigen::VectorXd& x, LimitWatch* watch, ReplayRun& result) {
    const KnotView& view = problem_.knot(k);
    auto& memory = memory_[view.model];
    if (!memory) memory = std::make_unique<ReplayStep>(*view.model);
    const System& system = memory->system();
    const Eigen::VectorXd u = control(k, feedback, x, result);
    const Step& knot_step = view.model->step();
    Eigen::VectorXd from = knot_step.first_control(x, u), to = from;
    const bool choice = problem_.phases()[view.phase].instant;
    const int steps = view.dt > 0 && !choice ? substeps_ : 1;
    const double dt = knot_step.time_step(view.dt, x.data()) / steps;
    for (int s = 0; s < steps; ++s) {
      const SystemData<double>& data = memory->look(x.data(), from.data());
      if (watch != nullptr && !choice)
        watch->look(system, data, x.data(), k, times_[k] + s * dt, s == 0);
      to += (u.head(to.size()) - to) / (steps - s);  // at last u itself
      memory->go({from.data(), to.data()}, dt, x.data());
      knot_step.hand_on(to.data(), x.data());
      from = to;
    }
    // Integrals come from the plan, because those of the replay's steps differ.
    for (const IntegralTerm& integral : knot_step.integrals())
      x[system_size(*view.model) + integral.number] =
          trajectory_.x(k + 1)[system_size(*view.model) + integral.number];
  }

  static int system_size(const KnotModel& model) { return model.system().nx(); }

  void compare(int k, const Eigen::VectorXd& x, ReplayRun& result) {
    Eigen::VectorXd off(problem_.ndx());
    problem_.manifold().difference(trajectory_.x(k).data(), x.data(), off.data());
    const int own = problem_.terminal().model->system().ndx();  // without augmented states
    Eigen::Index entry = 0;
    const double worst = off.head(own).cwiseAbs().maxCoeff(&entry);
    if (worst > result.deviation) {
      result.deviation = worst;
      result.knot = k;
      result.entry = static_cast<int>(entry);
    }
    result.final_state = worst;
    result.relative = std::max(result.relative,
                               off.head(own).cwiseAbs().cwiseQuotient(scale_.head(own)).maxCoeff());
  }

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const std::vector<Eigen::MatrixXd>& gains_;
  const int substeps_;
  const std::vector<double> times_;
  const Eigen::VectorXd scale_;  ///< deviation that counts as 1, by entry
  std::map<const KnotModel*, std::unique_ptr<ReplayStep>> memory_;
};

/// Deviations that count as 1 by entry: the ranges of motion, at least a hundredth of a unit.
Eigen::VectorXd ways(const ShootingProblem& problem, const Trajectory& trajectory) {
  constexpr double kSmallWay = 0.01;
  return motion_range(problem, trajectory).cwiseMax(kSmallWay);
}

/// True if the trajectory is finite, apart from the last state: nothing is replayed from there.
bool is_finite(const Trajectory& trajectory) {
  for (int k = 0; k < trajectory.knots(); ++k)
    if (!trajectory.x(k).allFinite() || !trajectory.u(k).allFinite()) return false;
  return true;
}

std::string why_impossible(const ShootingProblem& problem, const Trajectory& trajectory) {
  for (const Phase& phase : problem.phases()) {
    const bool jumps = phase.dt.front() == 0;
    if (phase.model->integrator() == Integrator::discrete && !jumps)
      return "a discrete system has no time between its knots";
    if (phase.model->system().as_stepping() != nullptr)
      return "contact-implicit steps are replayed by a simulator of contacts";
  }
  return is_finite(trajectory) ? "" : "the trajectory is not finite";
}

}  // namespace

/// A collocation step, whose slopes follow from the state and the actuators.
class CollocationStep {
 public:
  CollocationStep(const std::shared_ptr<const CollocationSystem>& system, Step step)
      : model_(std::move(step)),
        actuators_(system->actuators()),
        x_(model_.nx(), 0.0),
        w_(model_.nu(), 0.0) {
    model_.add_constraint(
        make_constraint("collocation",
                        collocation_residual(system, model_.ndx(), std::nullopt,
                                             model_.step().controls_in_state() > 0),
                        ConstraintKind::bounds));
    parameters_.assign(model_.parameter_count(), 0.0);
    work_ = std::make_unique<KnotWorkspace<double>>(model_);
  }

  /// Solves for the next state by Newton's method, starting from the slopes of the previous step.
  /// Returns NaN if it fails.
  std::vector<double> go(const double* x, const StepControl& u, double h) {
    const int unknown = model_.constraint_rows();
    const ConstraintTerm& term = model_.constraints().front();
    std::copy_n(x, model_.system().nx(), x_.begin());
    std::copy_n(u.begin, model_.step().tail(), x_.begin() + model_.system().nx());
    std::copy_n(u.end, actuators_, w_.begin());
    parameters_[term.parameters] = h;
    parameters_[term.active()] = 1;
    Eigen::MatrixXd by_slopes(unknown, unknown);
    Eigen::Map<Eigen::VectorXd> slopes(w_.data() + actuators_, unknown);
    for (int i = 0; i < kIterations; ++i) {
      model_.differentiate(KnotInput<double>{x_.data(), w_.data(), parameters_.data(), h, 1.0},
                           *work_, false);
      const Eigen::Map<const Eigen::VectorXd> off(work_->constraint.data(), unknown);
      if (off.lpNorm<Eigen::Infinity>() <= kRounding * (1 + h * slopes.lpNorm<Eigen::Infinity>()))
        return {work_->next().begin(), work_->next().begin() + model_.system().nx()};
      by_slopes.setZero();
      const auto& pattern = model_.constraint_pattern();
      const int first = model_.ndx() + actuators_;
      for (std::size_t e = 0; e < pattern.size(); ++e)
        if (const auto& [row, column] = pattern[e]; column >= first)
          by_slopes(row, column - first) = work_->constraint_jacobian[e];
      slopes -= by_slopes.partialPivLu().solve(off);
    }
    slopes.setZero();
    return std::vector<double>(model_.system().nx(), std::numeric_limits<double>::quiet_NaN());
  }

 private:
  static constexpr int kIterations = 30;
  static constexpr double kRounding = 1e-13;

  KnotModel model_;
  int actuators_;
  std::vector<double> x_, w_, parameters_;
  std::unique_ptr<KnotWorkspace<double>> work_;
};

namespace {

std::shared_ptr<const System> without_slopes(const KnotModel& model) {
  const CollocationSystem* collocation = model.system().as_collocation();
  return collocation ? collocation->inside() : model.shared_system();
}

}  // namespace

ReplayStep::ReplayStep(const KnotModel& model) : ReplayStep(model, model.integrator()) {}

ReplayStep::ReplayStep(const KnotModel& model, Integrator rule)
    : system_(without_slopes(model)),
      integrator_(rule),
      linear_(model.step().controls_in_state() > 0),
      data_(system_->create_data(double{})) {
  if (const auto collocation = info_of(rule).collocation) {
    const auto system = std::make_shared<const CollocationSystem>(system_, *collocation);
    implicit_ = std::make_unique<CollocationStep>(system, model.step().alike(system, rule));
  } else {
    work_.emplace(*system_, rule, false, linear_);
  }
}

ReplayStep::~ReplayStep() = default;

const SystemData<double>& ReplayStep::look(const double* x, const double* u) {
  system_->evaluate(x, u, *data_);
  return *data_;
}

void ReplayStep::go(const StepControl& u, double dt, double* x) {
  if (implicit_) {
    const std::vector<double> next = implicit_->go(x, u, dt);
    std::copy(next.begin(), next.end(), x);
    return;
  }
  integrate(*system_, integrator_, x, u.begin, dt, *data_, *work_, linear_ ? u.end : nullptr);
  std::copy(work_->next.begin(), work_->next.end(), x);
}

Eigen::VectorXd motion_range(const ShootingProblem& problem, const Trajectory& trajectory) {
  Eigen::VectorXd range = Eigen::VectorXd::Zero(problem.ndx()), off = range;
  for (int k = 0; k <= problem.knots(); ++k) {
    problem.manifold().difference(trajectory.x(0).data(), trajectory.x(k).data(), off.data());
    range = range.cwiseMax(off.cwiseAbs());
  }
  return range;
}

Replay replay(const ShootingProblem& problem, const Trajectory& trajectory,
              const std::vector<Eigen::MatrixXd>& gains, int substeps) {
  Replay result;
  result.impossible = why_impossible(problem, trajectory);
  if (!result.impossible.empty()) return result;
  result.substeps = substeps;
  Player player(problem, trajectory, gains, substeps, ways(problem, trajectory));
  LimitWatch watch;
  result.controls = player.run(false, nullptr);
  result.feedback = player.run(true, &watch);
  result.broken = watch.broken();
  return result;
}

double replay_error(const ShootingProblem& problem, const Trajectory& trajectory, int substeps) {
  if (!why_impossible(problem, trajectory).empty()) return std::numeric_limits<double>::infinity();
  const ReplayRun run =
      Player(problem, trajectory, {}, substeps, ways(problem, trajectory)).run(false, nullptr);
  return run.lost_at < 0 ? run.deviation : std::numeric_limits<double>::infinity();
}

std::optional<double> replay_with_feedback(const ShootingProblem& problem,
                                           const Trajectory& trajectory,
                                           const std::vector<Eigen::MatrixXd>& gains, int substeps,
                                           const Eigen::VectorXd& scale) {
  if (!why_impossible(problem, trajectory).empty()) return std::nullopt;
  const ReplayRun run = Player(problem, trajectory, gains, substeps, scale).run(true, nullptr);
  return run.lost_at < 0 ? run.relative : std::numeric_limits<double>::infinity();
}

}  // namespace conddp
