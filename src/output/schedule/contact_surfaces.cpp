#include "output/schedule/contact_surfaces.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

/// Angle within which normals count as equal, rad.
constexpr double kTurn = 1e-3;

OrderedJson list(const Vector3<double>& v) { return {v.x, v.y, v.z}; }

int frame_of(const ContactCandidate& candidate) {
  return std::visit([](const auto& shape) { return shape.frame; }, candidate.against);
}

}  // namespace

bool is_same_normal(const Vector3<double>& a, const Vector3<double>& b) {
  return squared_norm(a - b) <= kTurn * kTurn;
}

ContactSurfaces::ContactSurfaces(const ContactMotion& motion)
    : motion_(motion), looks_(motion.plant.contacts.candidates.size()) {
  ContactMechanics<double> mechanics(motion.plant);
  for (const Eigen::VectorXd& q : motion.q) {
    const auto& instants = mechanics.look(q.data());
    for (std::size_t c = 0; c < looks_.size(); ++c) {
      const auto& [gap, directions, point, rows] = instants[c];
      looks_[c].push_back({gap, directions[0], point + at(c).sphere.radius * directions[0]});
    }
  }
}

int ContactSurfaces::count(std::size_t candidate) const {
  if (frame_of(at(candidate)) >= 0 || at(candidate).stiffness) return 0;
  return std::holds_alternative<ContactBox>(at(candidate).against) ? 6 : 1;
}

/// The plane of a half space or of a face of a box, in the order +x, −x, +y, … of its axes.
ContactSurfaces::Plane ContactSurfaces::plane(std::size_t candidate, int surface) const {
  if (const auto* half_space = std::get_if<ContactHalfSpace>(&at(candidate).against))
    return {half_space->normal, half_space->offset * half_space->normal};
  const auto& box = std::get<ContactBox>(at(candidate).against);
  Vector3<double> axis = Vector3<double>::zero();
  axis[surface / 2] = surface % 2 == 0 ? 1 : -1;
  const double half = box.half_sizes[surface / 2];
  return {box.placement.R * axis, box.placement.p + box.placement.R * (half * axis)};
}

std::optional<int> ContactSurfaces::touched(std::size_t candidate, int first, int last) const {
  const Vector3<double>& n = normal(candidate, first);
  for (int k = first + 1; k <= last; ++k)
    if (!is_same_normal(n, normal(candidate, k))) return std::nullopt;
  if (std::holds_alternative<ContactSphere>(at(candidate).against)) return 0;
  for (int s = 0; s < count(candidate); ++s)
    if (is_same_normal(n, plane(candidate, s).normal)) return s;
  return std::nullopt;
}

bool ContactSurfaces::travels(std::size_t candidate, int first, int last, double speed) const {
  const std::vector<Look>& looks = looks_[candidate];
  for (int k = first; k < last; ++k) {
    const Vector3<double> way = looks[k + 1].center - looks[k].center;
    const Vector3<double> along = way - dot(way, looks[k].normal) * looks[k].normal;
    if (squared_norm(along) > std::pow(speed * motion_.h[k], 2)) return true;
  }
  return false;
}

bool ContactSurfaces::is_outside(std::size_t candidate, int surface, int node) const {
  const Look& look = looks_[candidate][node];
  if (!std::holds_alternative<ContactBox>(at(candidate).against)) return look.gap >= -kGrazing;
  const auto [normal, point] = plane(candidate, surface);
  return dot(normal, look.center - point) - at(candidate).sphere.radius >= -kGrazing;
}

std::optional<int> ContactSurfaces::longest_outside(std::size_t candidate, int node) const {
  std::optional<int> best;
  int latest = node;
  for (int s = 0; s < count(candidate); ++s) {
    int end = node;
    while (end <= motion_.steps() && is_outside(candidate, s, end)) ++end;
    if (end <= latest) continue;
    latest = end;
    best = s;
  }
  return best;
}

OrderedJson ContactSurfaces::obstacle(std::size_t candidate, int surface, double less) const {
  if (const auto* sphere = std::get_if<ContactSphere>(&at(candidate).against))
    return {{"sphere", {{"radius", sphere->radius - less}, {"center", list(sphere->center)}}}};
  const auto [normal, point] = plane(candidate, surface);
  return {{"half_space", {{"normal", list(normal)}, {"point", list(point - less * normal)}}}};
}

}  // namespace conddp
