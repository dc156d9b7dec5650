#include "problem_file/assemble/contact_guess.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/residuals/stepping_residual.hpp"
#include "problem_file/motion/holding_forces.hpp"

namespace conddp {
namespace {

/// Distance of guessed forces and slacks from their bounds.
constexpr double kInside = 0.01;
/// A step is held if the residual is at most this fraction of the weight.
constexpr double kHeld = 1e-3;

class ContactGuess {
 public:
  ContactGuess(const std::shared_ptr<const SteppingSystem>& system, const ShootingProblem& problem,
               Trajectory& trajectory)
      : system_(*system),
        layout_(system->layout()),
        problem_(problem),
        trajectory_(trajectory),
        equations_(stepping_residual(system, problem.ndx())),
        data_(system->create_data(double{})),
        rows_(equations_->size()) {}

  /// Calls settle(k, w), which sets the forces, for each step after its accelerations are set from
  /// the guessed states. Then sets the slacks.
  template <class Settle>
  void fill(Settle settle) {
    const int nq = system_.nq(), nv = system_.nv();
    for (int k = 0; k < problem_.knots(); ++k) {
      const KnotView& knot = problem_.knot(k);
      if (problem_.phases()[knot.phase].instant) continue;
      auto w = trajectory_.u(k);
      for (const auto& [z, s] : layout_.pairs) w[z] = w[s] = kInside;
      w.segment(layout_.acceleration, nv) =
          (trajectory_.x(k + 1).segment(nq, nv) - trajectory_.x(k).segment(nq, nv)) / knot.dt;
      settle(k, w);
      set_slacks(k, w);
    }
  }

  /// Moves values on their bound slightly off it.
  void keep_inside(Eigen::Ref<Eigen::VectorXd> w) const {
    for (const auto& [z, s] : layout_.pairs) w[z] = std::max(kInside, w[z]);
  }

 private:
  /// After the equations of motion, each row is linear in one slack, with slope 1.
  void set_slacks(int k, Eigen::Ref<Eigen::VectorXd> w) {
    equations_->evaluate({trajectory_.x(k).data(), w.data(), &problem_.knot(k).dt, *data_},
                         rows_.data());
    const double* row = rows_.data() + system_.nv();
    const auto set = [&](int slack) { w[slack] = std::max(kInside, w[slack] - *row++); };
    const auto set_friction = [&](const FrictionIndices& f) {
      for (int i = 0; i < f.count; ++i) set(f.slip[i]);
      if (f.count > 0) set(f.rest);
    };
    for (std::size_t i = 0; i < layout_.candidates.size(); ++i) {
      const SteppingLayout::Candidate& c = layout_.candidates[i];
      set(c.gap);
      set_friction(c.friction);
      if (!c.cone.present) continue;
      set_cone(c, system_.contacts().candidates[i].friction, row, w);
      row += ConeIndices::kRows;
    }
    for (const SteppingLayout::Stop& stop : layout_.stops) set(stop.distance);
    for (const FrictionIndices& f : layout_.frictions) set_friction(f);
  }

  /// Sets friction from the guessed slip, slightly inside the cone, or from the guessed force if
  /// slip is negligible. `row` points at the slip along the first tangent.
  static void set_cone(const SteppingLayout::Candidate& at, double friction, const double* row,
                       Eigen::Ref<Eigen::VectorXd> w) {
    const ConeIndices& cone = at.cone;
    const double slip = std::hypot(row[0], row[1]);
    w[cone.speed] = std::max(slip * (1 + kInside), kInside);
    w[cone.rest] = 1;
    for (int i = 0; i < 2; ++i) {
      const double force = w[cone.force[i]];
      w[cone.use[i]] = slip < kInside && force != 0 ? -force / (friction * w[at.force])
                                                    : -row[i] / w[cone.speed];
      w[cone.force[i]] = -friction * w[at.force] * w[cone.use[i]];
      w[cone.rest] -= w[cone.use[i]] * w[cone.use[i]];
    }
    w[cone.rest] = std::max(kInside, w[cone.rest]);
  }

  const SteppingSystem& system_;
  const SteppingLayout& layout_;
  const ShootingProblem& problem_;
  Trajectory& trajectory_;
  std::shared_ptr<const Residual> equations_;
  std::unique_ptr<SystemData<double>> data_;
  std::vector<double> rows_;
};

}  // namespace

void guess_contacts(const std::shared_ptr<const SteppingSystem>& system,
                    const ShootingProblem& problem, Trajectory& trajectory) {
  ContactGuess(system, problem, trajectory).fill([](int, const auto&) {});
}

HeldGuess guess_held_contacts(const std::shared_ptr<const SteppingSystem>& system,
                              const ShootingProblem& problem, double product,
                              Trajectory& trajectory) {
  const RobotModel& robot = system->multibody().robot();
  const double gravity = std::sqrt(squared_norm(robot.gravity));
  const double weight = robot.total_mass() * (gravity > 0 ? gravity : 9.81);
  HoldingForces forces(system, problem.ndx(), product);
  HeldGuess held;
  ContactGuess guess(system, problem, trajectory);
  guess.fill([&](int k, Eigen::Ref<Eigen::VectorXd> w) {
    const KnotModel& model = *problem.knot(k).model;
    const double left = forces.find(trajectory.x(k).data(), problem.knot(k).dt,
                                    model.control_lower(), model.control_upper(), w);
    guess.keep_inside(w);
    ++held.steps;
    held.unheld += left > kHeld * weight;
    if (left <= held.worst) return;
    held.worst = left;
    held.worst_knot = k;
  });
  return held;
}

}  // namespace conddp
