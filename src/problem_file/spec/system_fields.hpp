#pragma once

#include <string_view>

#include "problem_file/spec/spec_robot.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// `type` of the alternatives of SystemSpec::parameters, in their order.
inline constexpr std::string_view kSystemTypes[] = {
    "double_integrator", "linear", "pendulum",         "cartpole",  "acrobot",
    "unicycle",          "car",    "planar_quadrotor", "quadrotor", "lander"};
static_assert(std::size(kSystemTypes) == std::variant_size_v<decltype(SystemSpec::parameters)>);

/// The scalar parameters of a closed-form system: calls `field(key, value, range)` for each, with a
/// reference to the value. `P` is the struct, const or not.
template <class P, class Field>
void for_each_field([[maybe_unused]] P& p, [[maybe_unused]] Field&& field) {
  using Parameters = std::remove_const_t<P>;
  if constexpr (std::is_same_v<Parameters, PendulumParameters>) {
    field("mass", p.mass, kPositive);
    field("length", p.length, kPositive);
    field("inertia", p.inertia, kPositive);
    field("damping", p.damping, kNotNegative);
    field("gravity", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, CartpoleParameters>) {
    field("cart_mass", p.cart_mass, kPositive);
    field("pole_mass", p.pole_mass, kPositive);
    field("length", p.length, kPositive);
    field("gravity", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, AcrobotParameters>) {
    field("length1", p.length1, kPositive);
    field("length2", p.length2, kPositive);
    field("mass1", p.mass1, kPositive);
    field("mass2", p.mass2, kPositive);
    field("inertia1", p.inertia1, kPositive);
    field("inertia2", p.inertia2, kPositive);
    field("friction", p.friction, kNotNegative);
    field("gravity", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, CarSpec>) {
    field("wheelbase", p.wheelbase, kPositive);
  } else if constexpr (std::is_same_v<Parameters, PlanarQuadrotorParameters>) {
    field("mass", p.mass, kPositive);
    field("inertia", p.inertia, kPositive);
    field("arm", p.arm, kPositive);
    field("gravity", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, QuadrotorParameters>) {
    field("mass", p.mass, kPositive);
    field("jx", p.jx, kPositive);
    field("jy", p.jy, kPositive);
    field("jz", p.jz, kPositive);
    field("arm", p.arm, kPositive);
    field("torque_ratio", p.torque_ratio, kPositive);
    field("gravity", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, LanderParameters>) {
    field("mass", p.mass, kPositive);
    field("fuel_rate", p.fuel_rate, kNotNegative);
    field("gravity", p.gravity, kAnyNumber);
  }
}

}  // namespace conddp
