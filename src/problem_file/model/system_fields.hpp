#pragma once

#include <string_view>

#include "problem_file/model/spec_robot.hpp"
#include "problem_file/yaml/yaml_reader.hpp"

namespace conddp {

/// A `type` of closed-form systems.
struct SystemType {
  std::string_view name;
  std::string_view description;  ///< one line: the columns of its state and control
  std::string_view examples;     ///< of mappings, a JSON list
  std::string_view rules = {};   ///< between keys, members of a JSON Schema
};

/// Types of the alternatives of SystemSpec::parameters, in their order.
inline constexpr SystemType kSystemTypes[] = {
    {"double_integrator", "a = u; state (q/0, ..., v/0, ...), controls u/0, ...",
     R"([{"type": "double_integrator"}])"},
    {"linear",
     "A x + B u + c is the next state or, with gives: rate, the rate of the state; state (x/0, "
     "...), controls u/0, ...",
     R"([{"type": "linear", "A": [[1, 0.1], [0, 1]], "B": [[0], [0.1]]}])"},
    {"pendulum", "State (theta, omega), theta = 0 hanging; control torque",
     R"([{"type": "pendulum"}])"},
    {"cartpole", "State (x, theta, vx, omega), theta = 0 hanging; control force on the cart",
     R"([{"type": "cartpole"}])"},
    {"acrobot",
     "State (theta1, theta2, omega1, omega2), theta1 = -π/2 hanging; control elbow torque",
     R"([{"type": "acrobot"}])"},
    {"unicycle", "State (x, y, theta), controls v and omega", R"([{"type": "unicycle"}])"},
    {"car",
     "Car of Tassa, Mansard, Todorov 2014: state (x, y, theta, v), controls steering and "
     "acceleration",
     R"([{"type": "car"}])"},
    {"planar_quadrotor", "State (x, z, theta, vx, vz, omega), controls right and left thrust",
     R"([{"type": "planar_quadrotor"}])"},
    {"quadrotor",
     "State (x, y, z, qx, qy, qz, qw, vx, vy, vz, wx, wy, wz), velocities in the body frame; "
     "controls front, left, back and right thrust",
     R"([{"type": "quadrotor"}])"},
    {"lander",
     "Point mass on its thrust: state (x, y, z, vx, vy, vz, burnt), z upwards, and the mass that "
     "it has burnt; controls tx, ty, tz, the thrust in world axes",
     R"([{"type": "lander", "gravity": 1.62}])"},
    {"expressions", "A system of your own equations; may be left out",
     R"json([{"positions": {"theta": "rad"}, "velocities": {"omega": "rad/s"},
          "controls": {"torque": "Nm"}, "parameters": {"m": 1, "l": 0.5, "g": 9.81},
          "acceleration": {"omega": "(torque - m*g*l*sin(theta))/(m*l^2)"}}])json",
     R"("oneOf": [{"required": ["states", "rate"]},
                  {"required": ["positions", "velocities", "acceleration"]},
                  {"required": ["states", "next"]}])"},
    {"library", "A system of a compiled function; may be left out",
     R"([{"library": "model.so", "function": "f", "states": {"x": "m", "v": "m/s"},
          "controls": {"u": "N"}}])"}};
static_assert(std::size(kSystemTypes) == std::variant_size_v<decltype(SystemSpec::parameters)>);

/// The scalar parameters of a closed-form system. Calls `field(key, description, value, range)` for
/// each, with a reference to the value. `P` is the struct, const or not.
template <class P, class Field>
void for_each_field([[maybe_unused]] P& p, [[maybe_unused]] Field&& field) {
  using Parameters = std::remove_const_t<P>;
  if constexpr (std::is_same_v<Parameters, PendulumParameters>) {
    field("mass", "Mass, kg", p.mass, kPositive);
    field("length", "From pivot to center of mass, m", p.length, kPositive);
    field("inertia", "About the pivot, kg m²", p.inertia, kPositive);
    field("damping", "Viscous friction of the pivot, Nm s/rad", p.damping, kNotNegative);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, CartpoleParameters>) {
    field("cart_mass", "Mass of the cart, kg", p.cart_mass, kPositive);
    field("pole_mass", "Point mass at the pole's end, kg", p.pole_mass, kPositive);
    field("length", "Length of the pole, m", p.length, kPositive);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, AcrobotParameters>) {
    field("length1", "Length of the first link, m", p.length1, kPositive);
    field("length2", "Length of the second link, m", p.length2, kPositive);
    field("mass1", "Mass of the first link, kg", p.mass1, kPositive);
    field("mass2", "Mass of the second link, kg", p.mass2, kPositive);
    field("inertia1", "Inertia of the first link about its center of mass, kg m²", p.inertia1,
          kPositive);
    field("inertia2", "Inertia of the second link about its center of mass, kg m²", p.inertia2,
          kPositive);
    field("friction", "Viscous friction of both joints, Nm s/rad", p.friction, kNotNegative);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, CarSpec>) {
    field("wheelbase", "Distance of the axles, m", p.wheelbase, kPositive);
  } else if constexpr (std::is_same_v<Parameters, PlanarQuadrotorParameters>) {
    field("mass", "Mass, kg", p.mass, kPositive);
    field("inertia", "Inertia about the center of mass, kg m²", p.inertia, kPositive);
    field("arm", "Distance of a rotor from the center of mass, m", p.arm, kPositive);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, QuadrotorParameters>) {
    field("mass", "Mass, kg", p.mass, kPositive);
    field("jx", "Inertia about x, kg m²", p.jx, kPositive);
    field("jy", "Inertia about y, kg m²", p.jy, kPositive);
    field("jz", "Inertia about z, kg m²", p.jz, kPositive);
    field("arm", "Distance of a rotor from the center of mass, m", p.arm, kPositive);
    field("torque_ratio", "Torque of a rotor for each unit of thrust, Nm per N", p.torque_ratio,
          kPositive);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  } else if constexpr (std::is_same_v<Parameters, LanderParameters>) {
    field("mass", "Mass before it burns fuel, kg", p.mass, kPositive);
    field("fuel_rate", "Mass that a unit of thrust burns in a second, kg/s per N", p.fuel_rate,
          kNotNegative);
    field("gravity", "Gravity, m/s²", p.gravity, kAnyNumber);
  }
}

}  // namespace conddp
