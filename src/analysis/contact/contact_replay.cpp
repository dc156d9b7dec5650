#include "analysis/contact/contact_replay.hpp"

#include <algorithm>
#include <cmath>

#include "analysis/contact/rigid_step.hpp"

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

}  // namespace conddp
