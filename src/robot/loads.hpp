#pragma once

#include <algorithm>

#include "robot/data.hpp"

namespace conddp {

/// Contributions of a model's loads (RobotModel::loads) to the kernels. Inverse dynamics is linear
/// in the parameters: a column of derivatives is the generalized force for a unit of the load.

/// An inertia in a joint's frame, expressed in its tree's root frame; placements must be current.
template <class S>
Inertia<S> inertia_in_root(const RobotModel& model, const RobotData<S>& data, int joint,
                           const Inertia<double>& y) {
  if (model.joints[joint].type != JointType::floating) return act(data.placement[joint], y);
  const Symmetric3<double>& j = y.rotational;
  return {S(y.mass), y.moment.cast<S>(), {S(j.xx), S(j.xy), S(j.xz), S(j.yy), S(j.yz), S(j.zz)}};
}

/// Calls act(load, unit) with each load's unit inertia in its root frame.
template <class S, class Act>
void for_each_load(const RobotModel& model, const RobotData<S>& data, Act act) {
  for (const Load& load : model.loads)
    act(load, inertia_in_root(model, data, load.body, load.unit));
}

/// Adds the loads to the inertias of bodies, and to the composite inertias while these equal the
/// bodies'.
template <class S>
void add_loads(const RobotModel& model, RobotData<S>& data) {
  for_each_load(model, data, [&](const Load& load, const Inertia<S>& unit) {
    const S& amount = data.placement[load.parameter].p.z;
    const Symmetric3<S>& j = unit.rotational;
    const Inertia<S> y{
        amount * unit.mass,
        amount * unit.moment,
        {amount * j.xx, amount * j.xy, amount * j.xz, amount * j.yy, amount * j.yz, amount * j.zz}};
    data.body[load.body] += y;
    data.composite[load.body] += y;
  });
}

/// Writes the columns of the parameters in a matrix (nv x nv by columns): the generalized forces of
/// force_of(load, unit), a force on the body in the root frame.
template <class S, class ForceOf>
void put_parameter_columns(const RobotModel& model, const RobotData<S>& data, ForceOf force_of,
                           S* matrix) {
  const int n = model.nv;
  const auto column_of = [&](const Load& load) {
    return matrix + model.joints[load.parameter].v * n;
  };
  for (const Load& load : model.loads) std::fill_n(column_of(load), n, S(0.0));
  for_each_load(model, data, [&](const Load& load, const Inertia<S>& unit) {
    S* column = column_of(load);
    const Force<S> f = force_of(load, unit);
    for (int i = load.body; i >= 0; i = model.joints[i].parent) {
      const Joint& joint = model.joints[i];
      if (joint.type == JointType::floating)
        for (int k = 0; k < 6; ++k) column[joint.v + k] += f[k];
      else
        column[joint.v] += dot(data.axis[i], f);
    }
  });
}

/// The inertial force of a unit of a load that moves with its body.
template <class S>
Force<S> inertial_force(const RobotData<S>& data, const Load& load, const Inertia<S>& unit) {
  const Motion<S>& v = data.v[load.body];
  return unit * data.a[load.body] + cross(v, unit * v);
}

/// Writes the columns of the parameters in tau_q; velocities and accelerations must be current.
template <class S>
void put_load_columns(const RobotModel& model, RobotData<S>& data) {
  const auto force = [&](const Load& load, const Inertia<S>& unit) {
    return inertial_force(data, load, unit);
  };
  put_parameter_columns(model, data, force, data.tau_q.data());
}

/// Writes the same columns in the derivative of gravity torques.
template <class S>
void put_load_weights(const RobotModel& model, const RobotData<S>& data, S* out_q) {
  const auto force = [&](const Load& load, const Inertia<S>& unit) {
    return unit * Motion<S>{-data.gravity(model, load.body), Vector3<S>::zero()};
  };
  put_parameter_columns(model, data, force, out_q);
}

/// Adds the parameters' entries to the gradient of wᵀτ with respect to the configuration.
/// `virtual_velocity` contains the body velocities for the generalized velocities w.
template <class S>
void add_load_gradients(const RobotModel& model, const RobotData<S>& data,
                        const AlignedVector<Motion<S>>& virtual_velocity, S* wrt_q) {
  for_each_load(model, data, [&](const Load& load, const Inertia<S>& unit) {
    wrt_q[model.joints[load.parameter].v] +=
        dot(virtual_velocity[load.body], inertial_force(data, load, unit));
  });
}

}  // namespace conddp
