#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "systems/system.hpp"

namespace conddp {

/// Closed-form systems. Parameters default to the usual values of the literature.

/// `dimension` independent double integrators: a = u. x = (positions, velocities).
std::shared_ptr<const System> double_integrator(int dimension);

/// A x + B u + c: x⁺, or ẋ for a first-order system.
std::shared_ptr<const System> linear_system(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                            const Eigen::VectorXd& c,
                                            SystemKind kind = SystemKind::discrete);

struct PendulumParameters {
  double mass = 1, length = 0.5, inertia = 0.25, damping = 0.1, gravity = 9.81;
};
/// inertia·α = u − mass·gravity·length·sin θ − damping·ω; θ = 0 hanging. x = (θ, ω).
std::shared_ptr<const System> pendulum(const PendulumParameters& p);

struct CartpoleParameters {
  double cart_mass = 1, pole_mass = 0.2, length = 0.5, gravity = 9.81;
};
/// Point-mass pole on a cart pushed by u; θ = 0 hanging. x = (x, θ, ẋ, θ̇).
std::shared_ptr<const System> cartpole(const CartpoleParameters& p);

struct AcrobotParameters {
  double length1 = 1, length2 = 1, mass1 = 1, mass2 = 1, inertia1 = 1, inertia2 = 1;
  double friction = 1, gravity = 9.81;
};
/// Two links with a torque on the elbow; θ₁ = −π/2 hanging, as in the literature. x = (θ₁, θ₂, θ̇₁,
/// θ̇₂).
std::shared_ptr<const System> acrobot(const AcrobotParameters& p);

/// ẋ = v cos θ, ẏ = v sin θ, θ̇ = ω. x = (x, y, θ), u = (v, ω).
std::shared_ptr<const System> unicycle();

/// The car of Tassa, Mansard, Todorov 2014: x = (x, y, θ, v), u = (steering, acceleration),
/// discrete with the given step.
std::shared_ptr<const System> car(double wheelbase, double step);

struct PlanarQuadrotorParameters {
  double mass = 1, inertia = 0.1, arm = 0.3, gravity = 9.81;
};
/// x = (x, z, θ, velocities), u = (right thrust, left thrust).
std::shared_ptr<const System> planar_quadrotor(const PlanarQuadrotorParameters& p);

struct QuadrotorParameters {
  double mass = 0.5, jx = 0.0023, jy = 0.0023, jz = 0.004, arm = 0.175, torque_ratio = 0.0245;
  double gravity = 9.81;
};
/// Four rotors in plus configuration at (arm, 0), (0, arm), (−arm, 0), (0, −arm), alternating
/// reaction torque. State on SE(3): position and quaternion, then twist in the body frame.
std::shared_ptr<const System> quadrotor(const QuadrotorParameters& p);

struct LanderParameters {
  double mass = 40, fuel_rate = 5e-4, gravity = 3.71;
};
/// A point mass with thrust T, z upwards: m r̈ = T − m gravity e_z. It has burned the mass b: m =
/// mass − b, ḃ = fuel_rate ‖T‖ (kg/s per N). x = (r, ṙ, b), u = T. After Açıkmeşe and Ploen,
/// "Convex programming approach to powered descent guidance for Mars landing" (2007). Near T = 0,
/// ‖T‖ is smoothed by kThrustRounding.
std::shared_ptr<const System> lander(const LanderParameters& p);
inline constexpr double kThrustRounding = 1e-3;  ///< N

}  // namespace conddp
