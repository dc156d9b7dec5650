#include "analysis/findings/holding_torques.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "base/exceeds.hpp"
#include "solvers/stages/box_qp.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Accelerations below this count as rest, rad/s² or m/s².
constexpr double kRest = 0.1;
/// Unbounded torques must leave less than this share of the accelerations.
constexpr double kCure = 0.1;
/// Share of the largest diagonal entry that is added to the diagonal. With contacts, torques that
/// oppose each other are undetermined, and the Hessian contains rounding errors.
constexpr double kRegularization = 1e-10;

/// A robot at rest with a control at every joint: accelerations are a + A τ.
struct Statics {
  Statics(const MultibodySystem& robot, const double* x)
      : B(Eigen::Map<const MatrixXd>(robot.actuation().B.data(), robot.nv(), robot.nu())) {
    const std::vector<double> none(robot.nu(), 0.0);
    const auto data = robot.create_data(double{});
    robot.differentiate(x, none.data(), *data);
    a = Eigen::Map<const VectorXd>(data->f.data(), robot.nv());
    A = Eigen::Map<const MatrixXd>(data->fu.data(), robot.nv(), robot.nu());
  }

  /// Torques within bounds that minimize aᵀM a, the work of the accelerations on the masses. With
  /// contacts held, A = P M⁻¹ B, so that AᵀM A = BᵀA and AᵀM a = Bᵀa.
  std::optional<VectorXd> torques(const VectorXd& lower, const VectorXd& upper) const {
    const Eigen::Index n = A.cols();
    MatrixXd H = B.transpose() * A;
    H = (0.5 * (H + H.transpose())).eval();
    H.diagonal().array() += kRegularization * H.diagonal().maxCoeff();
    BoxQp qp(static_cast<int>(n));
    std::vector<BoundState> active(n, BoundState::free);
    if (qp.solve(H, B.transpose() * a, lower, upper, active) ==
        BoxQp::Status::not_positive_definite)
      return std::nullopt;
    return qp.x();
  }

  double acceleration(const VectorXd& torque) const {
    return (a + A * torque).lpNorm<Eigen::Infinity>();
  }

  MatrixXd B, A;
  VectorXd a;
};

bool at_rest(const MultibodySystem& robot, const double* x) {
  return std::all_of(x + robot.nq(), x + robot.nx(), [](double v) { return v == 0; });
}

/// Independent joints with one coordinate, except those of a base, which carry everything and are
/// not driven. A planar base consists of joints.
std::vector<std::string> joints_to_hold(const MultibodySystem& system) {
  const RobotModel& robot = system.robot();
  const std::vector<int> driven = system.actuated_rows();
  std::vector<bool> base(robot.joint_count());
  std::vector<std::string> names;
  for (int j = 0; j < robot.joint_count(); ++j) {
    const Joint& joint = robot.joints[j];
    const std::optional<int> row = system.velocity_row(j);
    if (joint.type == JointType::floating || !row) continue;
    const bool outermost =
        joint.parent < 0 || (base[joint.parent] && robot.joints[joint.parent].inertia.mass == 0);
    base[j] = outermost && !std::binary_search(driven.begin(), driven.end(), *row);
    if (!base[j]) names.push_back(joint.name);
  }
  return names;
}

/// Limits of a knot's controls at each of some joints; zero for a joint without a control.
struct TorqueLimits {
  VectorXd lower, upper;
  std::vector<bool> has_control;
};

/// Returns nullopt if a control belongs to no joint, such as a thruster.
std::optional<TorqueLimits> torque_limits(const KnotModel& model, const MultibodySystem& robot,
                                          const std::vector<Column>& joints) {
  const auto n = static_cast<Eigen::Index>(joints.size());
  TorqueLimits limits{VectorXd::Zero(n), VectorXd::Zero(n), std::vector<bool>(n, false)};
  for (int i = 0; i < robot.nu(); ++i) {
    const auto same = [&](const Column& c) { return c.name == robot.control_columns()[i].name; };
    const auto joint = std::find_if(joints.begin(), joints.end(), same);
    if (joint == joints.end()) return std::nullopt;
    const auto j = joint - joints.begin();
    limits.lower[j] = model.control_lower()[i];
    limits.upper[j] = model.control_upper()[i];
    limits.has_control[j] = true;
  }
  return limits;
}

/// True if the question applies: a robot at rest with something to hold it.
bool can_be_held(const MultibodySystem* robot, const double* x) {
  if (robot == nullptr || robot->kind() != SystemKind::second_order || !at_rest(*robot, x))
    return false;
  return !robot->contacts().empty() ||
         static_cast<int>(robot->actuated_rows().size()) >= robot->nv();
}

}  // namespace

std::optional<MissingTorque> missing_torque(const ShootingProblem& problem) {
  const KnotModel& model = *problem.knot(0).model;
  const auto* robot = model.system().as_multibody();
  const double* x = problem.initial_state().data();
  if (!can_be_held(robot, x)) return std::nullopt;

  MultibodySystem strong(robot->shared_robot(),
                         Actuation::joints(robot->robot(), joints_to_hold(*robot)), {},
                         robot->contacts().contacts());
  strong.soften_redundant_contacts(x);
  const int n = strong.nu();
  const std::vector<Column>& joints = strong.control_columns();
  const auto limits = torque_limits(model, *robot, joints);
  if (!limits) return std::nullopt;
  const auto& [lower, upper, has_control] = *limits;

  const Statics statics(strong, x);
  if (!statics.a.allFinite() || !statics.A.allFinite()) return std::nullopt;
  const VectorXd unbounded = VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  const auto held = statics.torques(lower, upper), needed = statics.torques(-unbounded, unbounded);
  if (!held || !needed) return std::nullopt;
  const double moves = statics.acceleration(*held);
  if (!(moves > kRest) || statics.acceleration(*needed) > kCure * moves) return std::nullopt;

  const VectorXd lack = (lower - *needed).cwiseMax(*needed - upper);
  const int worst = worst_of(lack);
  if (!(lack[worst] > 0)) return std::nullopt;
  const double torque = (*needed)[worst];
  return MissingTorque{.joint = joints[worst].name.substr(joints[worst].name.find('/') + 1),
                       .unit = joints[worst].unit,
                       .needed = std::abs(torque),
                       .limit = torque > 0 ? upper[worst] : std::abs(lower[worst]),
                       .driven = has_control[worst]};
}

}  // namespace conddp
