#include "robot/regularity.hpp"

#include <cmath>

#include <Eigen/Eigenvalues>

#include "robot/axis_alignment.hpp"

namespace conddp {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Pivots below this, relative to what moves if all joints further out are held, count as zero.
constexpr double kSingular = 1e-11;

Eigen::Matrix3d dense(const Matrix3<double>& a) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(a.m);
}

/// The inertia on (linear; angular) velocities.
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

/// Takes velocities of the outer frame to the inner one.
Matrix6d motion_to_inner(const SE3<double>& inner) {
  const Eigen::Matrix3d rt = dense(inner.R).transpose();
  Matrix6d x = Matrix6d::Zero();
  x.topLeftCorner<3, 3>() = x.bottomRightCorner<3, 3>() = rt;
  x.topRightCorner<3, 3>() = -rt * dense(skew(inner.p));
  return x;
}

/// Where a joint's frame is in its parent's at a configuration without special angles.
SE3<double> generic_placement(const Joint& joint, int index) {
  const double q = 0.4 + 0.5 * std::sin(1.7 * index + 0.3);
  const Vector3<double> z{0, 0, 1};
  const SE3<double> moved = joint.type == JointType::revolute
                                ? SE3<double>{rotation_about(z, q), Vector3<double>::zero()}
                                : SE3<double>{Matrix3<double>::identity(), q * z};
  return joint.placement * moved;
}

bool singular(const Matrix6d& inertia) {
  const Eigen::Matrix<double, 6, 1> diagonal = inertia.diagonal();
  if (!(diagonal.minCoeff() > 0)) return true;
  const Eigen::Matrix<double, 6, 1> scale = diagonal.cwiseSqrt().cwiseInverse();
  const Matrix6d scaled = scale.asDiagonal() * inertia * scale.asDiagonal();
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(scaled, Eigen::EigenvaluesOnly).eigenvalues()[0] <
         kSingular;
}

}  // namespace

std::vector<int> joints_without_inertia(const RobotModel& model) {
  const std::size_t count = model.joints.size();
  // Articulated-body inertias (Featherstone 2008, §7.3) and, for scale, composite ones.
  std::vector<Matrix6d> articulated(count), composite(count);
  for (std::size_t i = 0; i < count; ++i)
    articulated[i] = composite[i] = dense(model.joints[i].inertia);
  std::vector<int> found;
  for (int i = static_cast<int>(count) - 1; i >= 0; --i) {
    const Joint& joint = model.joints[i];
    Matrix6d& inertia = articulated[i];
    if (joint.type == JointType::floating) {
      if (singular(inertia)) found.push_back(i);
      continue;
    }
    const int axis = joint.type == JointType::revolute ? 5 : 2;
    const double pivot = inertia(axis, axis) + joint.rotor_inertia;
    const double whole = composite[i](axis, axis) + joint.rotor_inertia;
    if (!(pivot > kSingular * whole)) {
      found.push_back(i);
    } else {
      const Eigen::Matrix<double, 6, 1> column = inertia.col(axis);
      inertia -= column * column.transpose() / pivot;
    }
    if (joint.parent < 0) continue;
    const Matrix6d x = motion_to_inner(generic_placement(joint, i));
    articulated[joint.parent] += x.transpose() * inertia * x;
    composite[joint.parent] += x.transpose() * composite[i] * x;
  }
  return {found.rbegin(), found.rend()};
}

}  // namespace conddp
