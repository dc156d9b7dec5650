#include "output/scene/closed_form_scene.hpp"

#include <array>
#include <cmath>
#include <functional>

namespace conddp {
namespace {

constexpr double kRod = 0.04;  ///< radius of rods relative to their length

OrderedJson sphere(double radius, OrderedJson at) {
  return {{"kind", "sphere"}, {"radius", radius}, {"placement", std::move(at)}};
}
OrderedJson box(double x, double y, double z, OrderedJson at) {
  return {{"kind", "box"}, {"size", {x, y, z}}, {"placement", std::move(at)}};
}
/// A rod from the origin along the body's x or −z axis.
OrderedJson rod(double length, bool along_x) {
  const double r = std::sqrt(0.5);
  OrderedJson at = along_x ? OrderedJson{length / 2, 0, 0, 0, r, 0, r}
                           : OrderedJson{0, 0, -length / 2, 0, 0, 0, 1};
  return {{"kind", "cylinder"},
          {"radius", kRod * length},
          {"length", length},
          {"placement", std::move(at)}};
}
/// A flat disc across the body's z axis.
OrderedJson disc(double radius, double x, double y) {
  return {{"kind", "cylinder"},
          {"radius", radius},
          {"length", 0.1 * radius},
          {"placement", {x, y, 0, 0, 0, 0, 1}}};
}

/// Appearance of a system: bodies (except the world), and their poses in a state.
struct Picture {
  struct Body {
    const char* name;
    int parent;
    OrderedJson shapes;
  };
  using Pose = std::array<double, 7>;  ///< position, quaternion x y z w
  std::vector<Body> bodies;
  std::function<std::vector<Pose>(const double* x)> poses;
};

/// Pose in the vertical plane x, z: rotated from x towards z.
Picture::Pose upright(double x, double z, double angle) {
  return {x, 0, z, 0, -std::sin(angle / 2), 0, std::cos(angle / 2)};
}
/// Pose on the ground, rotated from x towards y.
Picture::Pose on_ground(double x, double y, double angle) {
  return {x, y, 0, 0, 0, std::sin(angle / 2), std::cos(angle / 2)};
}

Picture picture(const DoubleIntegratorSpec& p) {
  if (p.dimension > 3) return {};
  return {
      {{"point", 0, {sphere(0.08, {0, 0, 0, 0, 0, 0, 1})}}}, [n = p.dimension](const double* x) {
        return std::vector<Picture::Pose>{{x[0], n > 1 ? x[1] : 0, n > 2 ? x[2] : 0, 0, 0, 0, 1}};
      }};
}

Picture picture(const LinearSpec&) { return {}; }
Picture picture(const ExpressionSystemSpec&) { return {}; }
Picture picture(const LibrarySystemSpec&) { return {}; }

Picture picture(const PendulumParameters& p) {
  return {
      {{"rod", 0, {rod(p.length, false), sphere(0.12 * p.length, {0, 0, -p.length, 0, 0, 0, 1})}}},
      [](const double* x) { return std::vector{upright(0, 0, x[0])}; }};
}

Picture picture(const CartpoleParameters& p) {
  const double l = p.length;
  return {{{"cart", 0, {box(0.6 * l, 0.4 * l, 0.3 * l, {0, 0, 0, 0, 0, 0, 1})}},
           {"pole", 1, {rod(l, false), sphere(0.1 * l, {0, 0, -l, 0, 0, 0, 1})}}},
          [](const double* x) {
            return std::vector{upright(x[0], 0, 0), upright(x[0], 0, x[1])};
          }};
}

Picture picture(const AcrobotParameters& p) {
  return {{{"upper", 0, {rod(p.length1, true)}}, {"lower", 1, {rod(p.length2, true)}}},
          [l = p.length1](const double* x) {
            return std::vector{upright(0, 0, x[0]),
                               upright(l * std::cos(x[0]), l * std::sin(x[0]), x[0] + x[1])};
          }};
}

Picture picture(const UnicycleSpec&) {
  return {{{"unicycle", 0, {disc(0.15, 0, 0), box(0.15, 0.04, 0.04, {0.12, 0, 0.03, 0, 0, 0, 1})}}},
          [](const double* x) { return std::vector{on_ground(x[0], x[1], x[2])}; }};
}

Picture picture(const CarSpec& p) {
  const double d = p.wheelbase;
  return {{{"car",
            0,
            {box(1.5 * d, 0.7 * d, 0.25 * d, {d / 2, 0, 0.2 * d, 0, 0, 0, 1}),
             box(0.7 * d, 0.6 * d, 0.2 * d, {0.4 * d, 0, 0.42 * d, 0, 0, 0, 1})}}},
          [](const double* x) { return std::vector{on_ground(x[0], x[1], x[2])}; }};
}

Picture picture(const PlanarQuadrotorParameters& p) {
  const double a = p.arm;
  return {{{"body",
            0,
            {box(2 * a, 0.1 * a, 0.1 * a, {0, 0, 0, 0, 0, 0, 1}), disc(0.35 * a, a, 0),
             disc(0.35 * a, -a, 0)}}},
          [](const double* x) { return std::vector{upright(x[0], x[1], x[2])}; }};
}

Picture picture(const QuadrotorParameters& p) {
  const double a = p.arm, t = 0.08 * a;
  return {
      {{"body",
        0,
        {box(2 * a, t, t, {0, 0, 0, 0, 0, 0, 1}), box(t, 2 * a, t, {0, 0, 0, 0, 0, 0, 1}),
         disc(0.5 * a, a, 0), disc(0.5 * a, 0, a), disc(0.5 * a, -a, 0), disc(0.5 * a, 0, -a)}}},
      [](const double* x) {
        return std::vector<Picture::Pose>{{x[0], x[1], x[2], x[3], x[4], x[5], x[6]}};
      }};
}

Picture picture(const LanderParameters&) {
  return {{{"lander",
            0,
            {box(1, 1, 0.6, {0, 0, 0.8, 0, 0, 0, 1}), box(1.6, 0.1, 0.5, {0, 0, 0.25, 0, 0, 0, 1}),
             box(0.1, 1.6, 0.5, {0, 0, 0.25, 0, 0, 0, 1})}}},
          [](const double* x) {
            return std::vector<Picture::Pose>{{x[0], x[1], x[2], 0, 0, 0, 1}};
          }};
}

}  // namespace

OrderedJson closed_form_scene(const SystemSpec& system, const Trajectory& trajectory) {
  const Picture picture_of =
      std::visit([](const auto& p) { return picture(p); }, system.parameters);
  if (!picture_of.poses) return nullptr;
  OrderedJson bodies = OrderedJson::array(), poses = OrderedJson::array();
  bodies.push_back({{"name", "world"}, {"parent", nullptr}, {"shapes", OrderedJson::array()}});
  for (const Picture::Body& body : picture_of.bodies)
    bodies.push_back({{"name", body.name}, {"parent", body.parent}, {"shapes", body.shapes}});
  OrderedJson way = OrderedJson::array();  // path of the first body
  for (int k = 0; k <= trajectory.knots(); ++k) {
    for (const double number : {0., 0., 0., 0., 0., 0., 1.}) poses.push_back(number);
    const std::vector<Picture::Pose> at = picture_of.poses(trajectory.x(k).data());
    for (const Picture::Pose& pose : at)
      for (const double number : pose) poses.push_back(finite_or_null(number));
    for (int i = 0; i < 3; ++i) way.push_back(finite_or_null(at.front()[i]));
  }
  return {{"bodies", std::move(bodies)},
          {"poses", std::move(poses)},
          {"com", OrderedJson::array()},
          {"paths", {{picture_of.bodies.front().name, std::move(way)}}},
          {"contacts", OrderedJson::array()}};
}

}  // namespace conddp
