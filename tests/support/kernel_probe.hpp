#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "robot/dynamics.hpp"
#include "robot/frames.hpp"
#include "support/random_robot.hpp"
#include "support/robots.hpp"

namespace conddp {

/// The random robots, ours, and those of the foreign folder, loaded once.
inline const std::vector<TestModel>& kernel_models() {
  static const std::vector<TestModel> models = [] {
    std::vector<TestModel> all = random_robots();
    std::vector<TestRobot> files = our_robots();
    for (TestRobot& robot : foreign_robots()) files.push_back(std::move(robot));
    for (const TestRobot& robot : files) {
      UrdfResult result = load_urdf(robot.urdf, {.base = robot.base});
      if (!result.model) throw std::runtime_error("cannot load " + robot.urdf.string());
      all.push_back({robot.name, std::move(*result.model)});
    }
    return all;
  }();
  return models;
}

template <class S>
std::vector<S> as_scalars(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

/// q ⊕ dq: a floating base moves by a twist in its own frame.
template <class S>
std::vector<S> move_configuration(const RobotModel& model, const std::vector<S>& q,
                                  const std::vector<S>& dq) {
  std::vector<S> moved(q.size());
  for (const Joint& joint : model.joints) {
    const S* a = &q[joint.q];
    const S* d = &dq[joint.v];
    if (joint.type != JointType::floating) {
      moved[joint.q] = a[0] + d[0];
      continue;
    }
    const Pose<S> pose = integrate_se3(Pose<S>{{a[0], a[1], a[2]}, {a[3], a[4], a[5], a[6]}},
                                       Motion<S>{{d[0], d[1], d[2]}, {d[3], d[4], d[5]}});
    const S values[] = {pose.p.x, pose.p.y, pose.p.z, pose.q.x, pose.q.y, pose.q.z, pose.q.w};
    std::copy(std::begin(values), std::end(values), &moved[joint.q]);
  }
  return moved;
}

template <class S>
struct ProbeState {
  std::vector<S> q, v, a, tau;

  static ProbeState at(const RobotState& x) {
    return {as_scalars<S>(x.q), as_scalars<S>(x.v), as_scalars<S>(x.a), as_scalars<S>(x.tau)};
  }
};

/// All kernel outputs in a state, by name. Jacobians are padded to nv columns.
template <class S>
class KernelProbe {
 public:
  KernelProbe(const RobotModel& model, const ProbeState<S>& x)
      : KernelProbe(model, x, RobotData<S>(model)) {}
  /// Starts with data of earlier evaluations.
  KernelProbe(const RobotModel& model, const ProbeState<S>& x, RobotData<S> data)
      : model_(model), data_(std::move(data)) {
    inverse_dynamics(model, x.q.data(), x.v.data(), x.a.data(), data_);
    put("tau", data_.tau);
    update_derivative_columns(model, data_);
    probe_frames();
    probe_totals();
    mass_matrix(model, data_);
    put("M", data_.M);
    bias_forces(model, x.v.data(), data_);
    put("bias", data_.bias);
    std::copy(x.a.begin(), x.a.end(), data_.acceleration.begin());
    inverse_dynamics_derivatives(model, x.v.data(), data_);
    put("tau_q", data_.tau_q);
    put("tau_v", data_.tau_v);
    forward_dynamics(model, x.q.data(), x.v.data(), x.tau.data(), data_);
    put("acceleration", data_.acceleration);
    put("L", data_.L);
  }

  const std::vector<S>& operator[](const std::string& name) const {
    for (const auto& [key, values] : outputs_)
      if (key == name) return values;
    throw std::out_of_range(name);
  }
  const std::vector<std::pair<std::string, std::vector<S>>>& outputs() const { return outputs_; }
  const RobotData<S>& data() const { return data_; }

 private:
  template <class Values>
  void put(const std::string& name, const Values& values) {
    outputs_.emplace_back(name, std::vector<S>(std::begin(values), std::end(values)));
  }
  template <class Spatial>
  void put_spatial(const std::string& name, const Spatial& m) {
    put(name, std::vector<S>{m[0], m[1], m[2], m[3], m[4], m[5]});
  }
  void put_vector(const std::string& name, const Vector3<S>& a) {
    put(name, std::vector<S>{a.x, a.y, a.z});
  }
  /// 6 rows by the columns that move the joint.
  void put_columns(const std::string& name, int joint, const std::vector<S>& columns) {
    std::vector<S> full(6 * model_.nv, S(0.0));
    const std::vector<int> indices = support(model_, joint);
    for (std::size_t k = 0; k < indices.size(); ++k)
      std::copy_n(columns.begin() + 6 * k, 6, full.begin() + 6 * indices[k]);
    put(name, full);
  }

  void probe_frames() {
    for (int f = 0; f < static_cast<int>(model_.frames.size()); ++f) {
      const std::string id = std::to_string(f);
      const int joint = model_.frames[f].joint;
      std::vector<S> first(6 * support_size(model_, joint)), second(first);
      const SE3<S> m = frame_placement(model_, data_, f);
      put("rotation " + id, m.R.m);
      put_vector("position " + id, m.p);
      for (const FrameAxes axes : {FrameAxes::local, FrameAxes::world_aligned}) {
        const std::string in = (axes == FrameAxes::local ? " local " : " world ") + id;
        put_spatial("velocity" + in, frame_velocity(model_, data_, f, axes));
        put_spatial("acceleration" + in, frame_acceleration(model_, data_, f, axes));
        frame_jacobian(model_, data_, f, axes, first.data());
        put_columns("jacobian" + in, joint, first);
        frame_velocity_derivative(model_, data_, f, axes, first.data());
        put_columns("velocity_q" + in, joint, first);
      }
      frame_acceleration_derivatives(model_, data_, f, first.data(), second.data());
      put_columns("acceleration_q " + id, joint, first);
      put_columns("acceleration_v " + id, joint, second);
    }
  }

  void probe_totals() {
    const int n = model_.nv;
    put_vector("com", center_of_mass(model_, data_));
    std::vector<S> jacobian(3 * n);
    center_of_mass_jacobian(model_, data_, jacobian.data());
    put("com jacobian", jacobian);
    put("energy", std::vector<S>{kinetic_energy(model_, data_), potential_energy(model_, data_)});
    std::vector<S> torques(n), torques_q(n * n, S(0.0));
    gravity_torques(model_, data_, torques.data(), torques_q.data());
    put("gravity torques", torques);
    put("gravity torques_q", torques_q);
    put_spatial("momentum", centroidal_momentum(model_, data_));
    std::vector<S> momentum_q(6 * n), momentum_v(6 * n);
    centroidal_momentum_derivatives(model_, data_, momentum_q.data(), momentum_v.data());
    put("momentum_q", momentum_q);
    put("momentum_v", momentum_v);
  }

  const RobotModel& model_;
  RobotData<S> data_;
  std::vector<std::pair<std::string, std::vector<S>>> outputs_;
};

/// Expects equality within the tolerance relative to the largest expected element (at least 1).
inline void expect_close(const std::vector<double>& actual, const std::vector<double>& expected,
                         double tolerance, const std::string& what) {
  ASSERT_EQ(actual.size(), expected.size()) << what;
  double scale = 1, worst = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    scale = std::max(scale, std::abs(expected[i]));
    const double error = std::abs(actual[i] - expected[i]);
    if (!(error <= worst)) {
      worst = error;
      at = i;
    }
  }
  EXPECT_LE(worst, tolerance * scale) << what << ": element " << at << " of " << actual.size()
                                      << " is " << actual[at] << ", not " << expected[at];
}

}  // namespace conddp
