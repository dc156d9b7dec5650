#pragma once

#include "robot/model.hpp"
#include "spatial/aligned.hpp"
#include "spatial/dual.hpp"

namespace conddp {

/// The results of all kernels for one knot (or one knot per lane) of a robot. Allocated once; the
/// comment of each function lists the fields it reads and writes.
///
/// Spatial quantities of a joint's body are expressed at the origin and in the axes of its tree's
/// root frame (the floating body, or the world). So only gravity depends on the pose of a floating
/// base, and the base's motion subspace is the identity.
template <class S>
struct RobotData {
  explicit RobotData(const RobotModel& model);

  AlignedVector<SE3<S>> root;           ///< per joint, only for floating ones: pose in the world
  AlignedVector<SE3<S>> placement;      ///< per joint, in the root frame
  AlignedVector<Motion<S>> axis;        ///< per joint: motion subspace S_j of one-DoF joints
  AlignedVector<Motion<S>> v;           ///< per joint: velocity of the body
  AlignedVector<Motion<S>> a;           ///< per joint: acceleration of the body minus gravity
  AlignedVector<Motion<S>> psi_dot;     ///< v_parent × S_j
  AlignedVector<Motion<S>> psi_ddot;    ///< a_parent × S_j + v_parent × psi_dot
  AlignedVector<Motion<S>> axis_rate;   ///< psi_dot + v_j × S_j
  AlignedVector<Inertia<S>> body;       ///< per joint: inertia of its body
  AlignedVector<Inertia<S>> composite;  ///< inertia of the subtree
  AlignedVector<Force<S>> momentum;     ///< body·v, then of the subtree
  AlignedVector<Symmetric3<S>>
      inertia_rate;                ///< rate of the rotational inertia, then of the subtree's
  AlignedVector<Force<S>> force;   ///< net force on the body, then on the subtree
  AlignedVector<Force<S>> column;  ///< composite · S_j, the joint's column of M

  AlignedVector<S> M;  ///< nv x nv by columns, lower triangle: joint-space inertia (kg m², kg …)
  AlignedVector<S> L;  ///< nv x nv by columns: factor of M = Lᵀ D L, D on the diagonal
  AlignedVector<S> D_inverse;     ///< nv
  AlignedVector<S> bias;          ///< nv: Coriolis, centrifugal, gravity, external wrenches
  AlignedVector<S> acceleration;  ///< nv: generalized acceleration
  AlignedVector<S> tau;           ///< nv: generalized forces of inverse dynamics
  AlignedVector<S> tau_q, tau_v;  ///< nv x nv by columns: derivatives of inverse dynamics

  /// The pose of a joint's root frame in the world.
  SE3<S> root_pose(const RobotModel& model, int joint) const {
    const int r = joint < 0 ? -1 : model.root[joint];
    return r < 0 ? SE3<S>::identity() : root[r];
  }
  /// Gravity in a joint's root frame.
  Vector3<S> gravity(const RobotModel& model, int joint) const {
    const int r = joint < 0 ? -1 : model.root[joint];
    return r < 0 ? model.gravity.cast<S>() : transpose_times(root[r].R, model.gravity);
  }
};

/// Instantiates a macro for every scalar of the kernels.
#define CONDDP_FOR_EACH_KERNEL_SCALAR(X) X(double) X(Lane) X(Dual<double>) X(Dual<Lane>)

}  // namespace conddp
