#include "problem_file/build/contact_cost.hpp"

#include <fmt/format.h>

#include "problem_file/plant/row_names.hpp"

namespace conddp {
namespace {

const std::vector<std::string> kWrenchNames = {"fx", "fy", "fz", "tx", "ty", "tz"};
const std::vector<std::string> kDirectionNames = {"normal", "tangent"};

/// The normal in the world of a contact whose cone is asked for.
std::optional<Vector3<double>> world_normal(const CostSpec& cost, const ContactSpec& contact,
                                            Diagnostics& out) {
  if (contact.axes == FrameAxes::world_aligned) return contact.normal;
  out.error(cost.residual.place,
            fmt::format("the friction cone of '{}' needs a normal that is fixed in the world",
                        contact.name.value),
            "give the contact 'axes: world'");
  return std::nullopt;
}

void name_rows(const std::string& what, int rows, CostResidual& result) {
  std::vector<std::string> names;
  for (int i = 0; i < rows; ++i) names.push_back(fmt::format("{}", i));
  result.rows = {what, names};
}

/// The linear cone that a cost asks for, in the world or, of soles, in their own axes.
std::optional<LinearCone> linear_cone(const CostSpec& cost, const ContactSpec& contact,
                                      const FrictionLimits& limits, Diagnostics& out) {
  if (cost.kind == ResidualKind::kFrictionCone) {
    const auto normal = world_normal(cost, contact, out);
    if (!normal) return std::nullopt;
    return friction_pyramid(limits, cost.cone.faces, cost.cone.inner, *normal);
  }
  if (contact.kind != ContactKind::surface || !contact.half_size) {
    out.error(cost.residual.place,
              fmt::format("the residual '{}' needs a sole, which the contact '{}' has not",
                          residual_info(cost.kind).name, contact.name.value),
              "give the contact 'type: surface' and 'size: [length, width]'");
    return std::nullopt;
  }
  const auto [half_x, half_y] = *contact.half_size;
  if (cost.kind == ResidualKind::kCenterOfPressure) return center_of_pressure_cone(half_x, half_y);
  return wrench_cone(limits, half_x, half_y, cost.cone.inner);
}

ContactCost velocity_cost(const Contact& contact) {
  ContactCost result;
  const bool directions =
      contact.kind == ContactKind::normal || contact.kind == ContactKind::planar;
  const auto& names = directions ? kDirectionNames : kTwistNames;
  result.prototype.rows = {"components of the velocity",
                           {names.begin(), names.begin() + contact.rows()}};
  result.make = [contact](const std::shared_ptr<const MultibodySystem>& system, int) {
    return contact_velocity_residual(system, contact);
  };
  return result;
}

std::optional<ContactCost> make_one(const CostSpec& cost, const ContactSpec& contact, int ndx,
                                    Diagnostics& out) {
  ContactCost result;
  if (cost.kind == ResidualKind::kContactForce) {
    const std::size_t rows = contact.kind == ContactKind::surface ? 6 : 3;
    const std::vector<std::string> names(kWrenchNames.begin(), kWrenchNames.begin() + rows);
    result.prototype.rows = result.prototype.references = {"components of the force", names};
    result.prototype.parameters = StateManifold::flat(static_cast<int>(rows));
    result.make = [ndx](const std::shared_ptr<const MultibodySystem>& system, int index) {
      return contact_force_residual(system, index, ndx);
    };
    return result;
  }
  const FrictionLimits limits{.friction = contact.friction * cost.cone.safety,
                              .min_normal = contact.min_normal_force,
                              .max_normal = contact.max_normal_force};
  if (cost.kind == ResidualKind::kFrictionCone && cost.cone.second_order) {
    const auto normal = world_normal(cost, contact, out);
    if (!normal) return std::nullopt;
    result.lower = {-kUnlimited, limits.min_normal};
    result.upper = {0, limits.max_normal};
    result.make = [ndx, friction = limits.friction, n = *normal](
                      const std::shared_ptr<const MultibodySystem>& system, int index) {
      return friction_cone_residual(system, index, ndx, friction, n);
    };
  } else {
    const auto cone = linear_cone(cost, contact, limits, out);
    if (!cone) return std::nullopt;
    result.lower = cone->lower;
    result.upper = cone->upper;
    result.make = [ndx, cone = *cone](const std::shared_ptr<const MultibodySystem>& system,
                                      int index) {
      return contact_cone_residual(system, index, ndx, cone);
    };
  }
  name_rows("rows of the cone", static_cast<int>(result.lower.size()), result.prototype);
  return result;
}

}  // namespace

std::vector<ContactCost> make_contact_costs(const CostSpec& cost, const ProblemSpec& spec,
                                            const ContactPlan& plan, const Plant& plant, int ndx,
                                            Diagnostics& out) {
  std::vector<ContactCost> costs;
  const std::vector<int> chosen = contacts_named(cost.contacts, spec, out);
  if (chosen.empty() && cost.contacts.all)
    out.error(cost.residual.place,
              fmt::format("the cost '{}' is on contacts, and the file has none", cost.name.value));
  for (const int contact : chosen) {
    auto one = cost.kind == ResidualKind::kContactVelocity
                   ? velocity_cost(plan.contacts()[contact])
                   : make_one(cost, spec.contacts[contact], ndx, out);
    if (!one) continue;
    one->contact = contact;
    one->prototype.residual =
        one->make(plant.multibody()->with_contacts({plan.contacts()[contact]}), 0);
    costs.push_back(std::move(*one));
  }
  return costs;
}

}  // namespace conddp
