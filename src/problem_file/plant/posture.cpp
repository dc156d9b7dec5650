#include "problem_file/plant/posture.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>

#include <Eigen/Dense>
#include <fmt/format.h>

#include "base/random_numbers.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Contacts and goals as one least-squares problem in the positions of some joints.
class Gaps {
 public:
  Gaps(const MultibodySystem& system, const std::vector<PostureGoal>& goals,
       const std::vector<int>& joints)
      : system_(system), goals_(goals), data_(system), column_(system.ndx(), -1) {
    for (std::size_t i = 0; i < joints.size(); ++i)
      column_[*system.velocity_row(joints[i])] = static_cast<int>(i);
    int rows = system.contacts().rows();
    for (const PostureGoal& goal : goals) rows += goal.residual->size();
    error.resize(rows);
    jacobian = MatrixXd::Zero(rows, static_cast<Eigen::Index>(joints.size()));
  }

  VectorXd error;     ///< zero where a row is within its bounds
  MatrixXd jacobian;  ///< of the error, by the joints

  /// Sets error and Jacobian at a state.
  void set(const std::vector<double>& x) {
    system_.update_kinematics(x.data(), data_);
    jacobian.setZero();
    set_contacts();
    int row = system_.contacts().rows();
    for (const PostureGoal& goal : goals_) {
      set_goal(goal, x, row);
      row += goal.residual->size();
    }
  }
  std::vector<double> norms() const {
    std::vector<double> norms;
    const ContactSet& set = system_.contacts();
    for (int i = 0; i < set.count(); ++i)
      norms.push_back(error.segment(set.offset(i), set.contacts()[i].rows()).norm());
    int row = set.rows();
    for (const PostureGoal& goal : goals_) {
      norms.push_back(error.segment(row, goal.residual->size()).norm());
      row += goal.residual->size();
    }
    return norms;
  }

 private:
  void set_contacts() {
    const ContactSet& set = system_.contacts();
    if (set.count() == 0) return;
    set.update(system_.robot(), data_.robot, system_.nv(), data_.contacts);
    for (int i = 0; i < set.count(); ++i)
      contact_error(set.contacts()[i], data_.contacts.contacts[i], &error[set.offset(i)]);
    const Eigen::Map<const MatrixXd> transposed(data_.contacts.response.data(), system_.nv(),
                                                set.rows());
    for (int v = 0; v < system_.nv(); ++v)
      if (column_[v] >= 0) jacobian.col(column_[v]).head(set.rows()) = transposed.row(v);
  }

  void set_goal(const PostureGoal& goal, const std::vector<double>& x, int row) {
    const Residual& residual = *goal.residual;
    const ResidualInput<double> in{x.data(), nullptr, goal.parameters.data(), data_};
    derivatives_.resize(residual.jacobian_size());
    double* const values = error.data() + row;
    residual.differentiate(in, values, derivatives_.data());
    const double* packed = derivatives_.data();
    for (const RowBlock& block : residual.blocks()) {
      for (const int column : block.columns)
        for (int i = 0; i < block.rows; ++i, ++packed)
          if (column_[column] >= 0) jacobian(row + i, column_[column]) = *packed;
      row += block.rows;
    }
    for (int i = 0; i < residual.size(); ++i) {
      const double value = values[i];
      values[i] = value - std::clamp(value, goal.lower, goal.upper);
      if (values[i] == 0 && goal.lower < goal.upper)
        jacobian.row(values + i - error.data()).setZero();
    }
  }

  const MultibodySystem& system_;
  const std::vector<PostureGoal>& goals_;
  MultibodySystem::Data<double> data_;
  std::vector<int> column_;  ///< column of the Jacobian of each tangent coordinate, or −1
  std::vector<double> derivatives_;
};

class Search {
 public:
  Search(const MultibodySystem& system, const std::vector<PostureGoal>& goals,
         const std::vector<int>& joints, const std::vector<double>& x)
      : gaps_(system, goals, joints), x_(x) {
    const auto count = static_cast<Eigen::Index>(joints.size());
    lower_.resize(count), upper_.resize(count);
    for (std::size_t i = 0; i < joints.size(); ++i) {
      at_.push_back(*system.position_index(joints[i]));
      const auto limits = system.limits(joints[i]);
      lower_[i] = limits.lower, upper_[i] = limits.upper;
    }
    start_ = positions().cwiseMax(lower_).cwiseMin(upper_);
  }

  Posture run() {
    constexpr int kStarts = 20;
    q_ = start_;
    Posture best = descended({1e-2, 1e-4, 1e-6, 0});
    if (best.found()) return best;
    UniformNumbers random(1);
    double gap = gaps_.error.norm(), motion = 0;
    for (int i = 1; i < kStarts; ++i) {
      // The way back to the start must not end where the first one did.
      q_ = anywhere(random);
      Posture other = descended({0});
      const VectorXd far = q_;
      if (Posture back = descended({1e-4, 1e-6, 0}); back.found() || !other.found())
        other = std::move(back);
      else
        q_ = far, evaluate();
      const double its_gap = gaps_.error.norm(), its_motion = (q_ - start_).norm();
      if (best.found() ? !other.found() || its_motion >= motion : its_gap >= gap) continue;
      best = std::move(other);
      gap = its_gap, motion = its_motion;
    }
    return best;
  }

 private:
  VectorXd positions() const {
    VectorXd q(at_.size());
    for (std::size_t i = 0; i < at_.size(); ++i) q[i] = x_[at_[i]];
    return q;
  }

  /// Random positions within the limits. In place of a limit that is not finite: π from the start.
  VectorXd anywhere(UniformNumbers& random) const {
    VectorXd q = start_;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      const double low = std::isfinite(lower_[i]) ? lower_[i] : start_[i] - std::numbers::pi;
      const double high = std::isfinite(upper_[i]) ? upper_[i] : start_[i] + std::numbers::pi;
      q[i] = low + (high - low) * random.next();
    }
    return q;
  }

  /// Sets the gaps and their derivatives at q_.
  void evaluate() {
    for (std::size_t i = 0; i < at_.size(); ++i) x_[at_[i]] = q_[i];
    gaps_.set(x_);
  }

  /// The end of descents from q_ with these shares of the motion, one after the other.
  Posture descended(std::initializer_list<double> shares) {
    for (const double share : shares) descend(share);
    return {x_, gaps_.norms()};
  }

  /// Half of the squared gaps plus the share times the squared motion.
  double cost(double share) const {
    return (gaps_.error.squaredNorm() + share * (q_ - start_).squaredNorm()) / 2;
  }

  /// Levenberg's method with Marquardt's choice of the damping, from and to q_.
  void descend(double share) {
    constexpr int kMostSteps = 100;
    constexpr double kNoStep = 1e-12, kLeast = 1e-12, kMost = 1e6;
    double damping = 1e-3;
    evaluate();
    for (int i = 0; i < kMostSteps && damping < kMost; ++i) {
      const VectorXd from = q_;
      const double before = cost(share);
      q_ = (from + step(share, damping)).cwiseMax(lower_).cwiseMin(upper_);
      if ((q_ - from).norm() < kNoStep) {
        q_ = from;
        break;
      }
      evaluate();
      if (cost(share) < before) {
        damping = std::max(damping / 10, kLeast);
      } else {
        q_ = from;
        damping *= 10;
        evaluate();
      }
    }
  }

  /// The step of the damped quadratic model. Joints that press on a limit, or would exceed it, stay
  /// there or go to it.
  VectorXd step(double share, double damping) const {
    const VectorXd gradient = gaps_.jacobian.transpose() * gaps_.error + share * (q_ - start_);
    MatrixXd hessian = gaps_.jacobian.transpose() * gaps_.jacobian;
    hessian.diagonal().array() += share + damping;
    VectorXd step = VectorXd::Zero(q_.size());
    std::vector<bool> held(q_.size());
    for (Eigen::Index i = 0; i < q_.size(); ++i)
      held[i] = gradient[i] > 0 ? q_[i] <= lower_[i] : q_[i] >= upper_[i];
    for (bool more = true; more;) {
      MatrixXd free = hessian;
      VectorXd rest = -gradient - hessian * step;
      for (Eigen::Index i = 0; i < q_.size(); ++i) {
        if (!held[i]) continue;
        free.row(i).setZero(), free.col(i).setZero();
        free(i, i) = 1, rest[i] = 0;
      }
      const VectorXd whole = step + free.ldlt().solve(rest);
      more = false;
      for (Eigen::Index i = 0; i < q_.size(); ++i) {
        const double q = q_[i] + whole[i];
        if (held[i] || (q >= lower_[i] && q <= upper_[i])) continue;
        held[i] = more = true;
        step[i] = (q < lower_[i] ? lower_[i] : upper_[i]) - q_[i];
      }
      if (!more) step = whole;
    }
    return step;
  }

  Gaps gaps_;
  std::vector<double> x_;
  std::vector<int> at_;  ///< places of the joints' positions in the state
  VectorXd lower_, upper_, start_, q_;
};

}  // namespace

bool Posture::found() const {
  return std::ranges::all_of(gaps, [](double gap) { return gap < kMet; });
}

Posture find_posture(const MultibodySystem& system, const std::vector<PostureGoal>& goals,
                     const std::vector<int>& joints, const std::vector<double>& x) {
  return Search(system, goals, joints, x).run();
}

std::vector<double> posture_gaps(const MultibodySystem& system,
                                 const std::vector<PostureGoal>& goals,
                                 const std::vector<double>& x) {
  Gaps gaps(system, goals, {});
  gaps.set(x);
  return gaps.norms();
}

std::vector<int> movable_joints(const MultibodySystem& system, int first, int count) {
  std::vector<int> joints;
  for (int j = first; j < first + count; ++j) {
    const JointType type = system.robot().joints[j].type;
    const bool moves = type == JointType::revolute || type == JointType::prismatic;
    if (moves && system.position_index(j)) joints.push_back(j);
  }
  return joints;
}

std::string changed_joints(const MultibodySystem& system, const std::vector<double>& from,
                           const std::vector<double>& to) {
  constexpr double kSame = 1e-7;  // rad or m
  std::string list;
  for (const int j : movable_joints(system, 0, system.robot().joint_count())) {
    const int at = *system.position_index(j);
    if (std::abs(to[at] - from[at]) < kSame) continue;
    list += fmt::format("{}{}: {:.10g}", list.empty() ? "{" : ", ", system.robot().joints[j].name,
                        to[at]);
  }
  return list.empty() ? list : list + "}";
}

}  // namespace conddp
