#include "robot/urdf/regularity.hpp"

#include <algorithm>
#include <cmath>

#include "base/matrix_decompositions.hpp"
#include "robot/urdf/axis_alignment.hpp"

namespace conddp {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Pivots below this count as zero, relative to the inertia with all joints further out held.
constexpr double kSingular = 1e-11;
/// Looser threshold for a single configuration: right angles written as 1.5708 leave 1e-11.
constexpr double kNearlySingular = 1e-8;

/// Residue of cancelled inertia terms, relative to the largest entry; it also counts as zero.
constexpr double kRounding = 1e-14;

Eigen::Matrix3d dense(const Matrix3<double>& a) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(a.m);
}

/// Inertia as a 6×6 matrix on (linear; angular) velocities.
Matrix6d dense(const Inertia<double>& body) {
  const Symmetric3<double>& j = body.rotational;
  Matrix6d m;
  const Eigen::Matrix3d h = dense(skew(body.moment));
  m.topLeftCorner<3, 3>() = body.mass * Eigen::Matrix3d::Identity();
  m.topRightCorner<3, 3>() = -h;
  m.bottomLeftCorner<3, 3>() = h;
  m.bottomRightCorner<3, 3>() << j.xx, j.xy, j.xz, j.xy, j.yy, j.yz, j.xz, j.yz, j.zz;
  return m;
}

/// Transforms velocities from the outer frame to the inner one.
Matrix6d motion_to_inner(const SE3<double>& inner) {
  const Eigen::Matrix3d rt = dense(inner.R).transpose();
  Matrix6d x = Matrix6d::Zero();
  x.topLeftCorner<3, 3>() = x.bottomRightCorner<3, 3>() = rt;
  x.topRightCorner<3, 3>() = -rt * dense(skew(inner.p));
  return x;
}

/// Placement of a one-axis joint's frame in its parent's frame at position q.
SE3<double> placement_at(const Joint& joint, double q) {
  const Vector3<double> z{0, 0, 1};
  const SE3<double> moved = joint.type == JointType::revolute
                                ? SE3<double>{rotation_about(z, q), Vector3<double>::zero()}
                                : SE3<double>{Matrix3<double>::identity(), q * z};
  return joint.placement * moved;
}

/// Joint positions without special angles.
double generic_position(int index) { return 0.4 + 0.5 * std::sin(1.7 * index + 0.3); }

/// Positions spread over the joint's range. Joints without limits are sampled within ±π rad or
/// ±1 m.
double sampled_position(const Joint& joint, int index, int sample) {
  const double whole = (sample + 1) * (0.6180339887498949 + 0.7548776662466927 * (index + 1));
  const double u = whole - std::floor(whole);
  if (std::isfinite(joint.lower) && std::isfinite(joint.upper) && joint.lower < joint.upper)
    return joint.lower + u * (joint.upper - joint.lower);
  return (2 * u - 1) * (joint.type == JointType::revolute ? M_PI : 1.0);
}

/// Smallest eigenvalue of an inertia whose diagonal is scaled to 1. If a diagonal entry is not
/// positive, the result is −1, or 0 if that entry is zero up to rounding.
double smallest_eigenvalue(const Matrix6d& inertia) {
  const Eigen::Matrix<double, 6, 1> diagonal = inertia.diagonal();
  if (const double least = diagonal.minCoeff(); !(least > 0))
    return least < -kRounding * diagonal.maxCoeff() ? -1 : 0;
  const Eigen::Matrix<double, 6, 1> scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * inertia * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(scaled, Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

/// Row of a one-axis joint's axis in (linear; angular) vectors.
int axis_row(const Joint& joint) { return joint.type == JointType::revolute ? 5 : 2; }

/// Articulated inertia along a one-axis joint, and its ratio to the composite inertia along the
/// joint. The ratio is zero if the pivot is within rounding.
struct Pivot {
  double value, relative;
};
Pivot find_pivot(const Joint& joint, const Matrix6d& articulated, const Matrix6d& composite) {
  const int axis = axis_row(joint);
  const double pivot = articulated(axis, axis) + joint.rotor_inertia;
  const double whole = std::abs(composite(axis, axis) + joint.rotor_inertia);
  const double noise =
      kRounding * composite.diagonal().segment<3>(axis < 3 ? 0 : 3).cwiseAbs().maxCoeff();
  return {pivot, std::abs(pivot) > noise ? pivot / whole : 0};
}

/// Pivots of the factorized inertia matrix, one per joint: the inertia along the joint while all
/// joints further out move freely, relative to the inertia with these joints held.
template <typename Position>
std::vector<double> relative_pivots(const RobotModel& model, const Position& position) {
  const std::size_t count = model.joints.size();
  // Articulated-body inertias (Featherstone 2008, §7.3) and, for scale, composite ones.
  std::vector<Matrix6d> articulated(count), composite(count);
  for (std::size_t i = 0; i < count; ++i)
    articulated[i] = composite[i] = dense(model.joints[i].inertia);
  std::vector<double> relative(count, 0);
  for (int i = static_cast<int>(count) - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    Matrix6d& inertia = articulated[i];
    if (joint.type == JointType::floating) {
      relative[i] = smallest_eigenvalue(inertia);
      continue;
    }
    const Pivot pivot = find_pivot(joint, inertia, composite[i]);
    relative[i] = pivot.relative;
    if (std::abs(pivot.relative) > kSingular) {
      const Eigen::Matrix<double, 6, 1> column = inertia.col(axis_row(joint));
      inertia -= column * column.transpose() / pivot.value;
    }
    if (joint.parent < 0) continue;
    const Matrix6d x = motion_to_inner(placement_at(joint, position(i)));
    articulated[joint.parent] += x.transpose() * inertia * x;
    composite[joint.parent] += x.transpose() * composite[i] * x;
  }
  return relative;
}

std::vector<int> without_inertia(const std::vector<double>& pivots, double least) {
  std::vector<int> found;
  for (std::size_t i = 0; i < pivots.size(); ++i)
    if (!(pivots[i] > least)) found.push_back(static_cast<int>(i));
  return found;
}

}  // namespace

double zero_position(const Joint& joint) {
  return joint.lower <= joint.upper ? std::clamp(0.0, joint.lower, joint.upper) : 0;
}

std::vector<int> joints_without_inertia(const RobotModel& model) {
  return without_inertia(relative_pivots(model, generic_position), kSingular);
}

std::vector<int> joints_without_inertia_at_zero(const RobotModel& model) {
  const auto zero = [&](int i) { return zero_position(model.joints[i]); };
  return without_inertia(relative_pivots(model, zero), kNearlySingular);
}

std::vector<int> bodies_with_negative_inertia(const RobotModel& model) {
  std::vector<int> found;
  for (int i = 0; i < model.joint_count(); ++i)
    if (smallest_eigenvalue(dense(model.joints[i].inertia)) < -kSingular) found.push_back(i);
  return found;
}

std::vector<int> joints_with_negative_inertia(const RobotModel& model) {
  std::vector<char> negative(model.joints.size(), 0);
  for (int sample = 0; sample < kRegularitySamples; ++sample) {
    const std::vector<double> pivots =
        relative_pivots(model, [&](int i) { return sampled_position(model.joints[i], i, sample); });
    for (std::size_t i = 0; i < pivots.size(); ++i) negative[i] |= pivots[i] < -kSingular;
  }
  std::vector<int> found;
  for (std::size_t i = 0; i < negative.size(); ++i)
    if (negative[i]) found.push_back(static_cast<int>(i));
  return found;
}

}  // namespace conddp
