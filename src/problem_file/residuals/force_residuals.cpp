#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

const Key<int> kFaces{"faces", 4};
const Key<bool> kInner{"inner", true};

const std::vector<std::string> kWrenchNames = {"fx", "fy", "fz", "tx", "ty", "tz"};

/// Limits of a contact's forces; the cost's `safety` scales the friction.
FrictionLimits limits_of(const CostSpec& cost, const ContactSpec& contact) {
  return {.friction = contact.friction * cost.keys.value(key::safety),
          .min_normal = contact.min_normal_force,
          .max_normal = contact.max_normal_force};
}

void name_rows(CostResidual& result, std::size_t rows) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < rows; ++i) names.push_back(fmt::format("{}", i));
  result.rows = {"rows of the cone", names};
}

ContactCost in_cone(const LinearCone& cone, int ndx) {
  ContactCost result;
  result.lower = cone.lower;
  result.upper = cone.upper;
  result.make = [ndx, cone](const std::shared_ptr<const MultibodySystem>& system,
                            const std::vector<int>& indices) {
    return contact_cone_residual(system, indices.front(), ndx, cone);
  };
  name_rows(result.prototype, result.lower.size());
  return result;
}

/// Normal of the first of a system's contacts with these indices.
const Vector3<double>& normal_of(const MultibodySystem& system, const std::vector<int>& indices) {
  return system.contacts().contacts()[indices.front()].normal;
}

std::optional<ContactCost> make_force(const ResidualContext& context, int contact) {
  const std::size_t rows = context.spec.contacts[contact].kind == ContactKind::surface ? 6 : 3;
  const std::vector<std::string> names(kWrenchNames.begin(), kWrenchNames.begin() + rows);
  ContactCost result;
  result.prototype.rows = result.prototype.references = {"components of the force", names};
  result.prototype.parameters = StateManifold::flat(static_cast<int>(rows));
  result.make = [ndx = context.ndx](const std::shared_ptr<const MultibodySystem>& system,
                                    const std::vector<int>& indices) {
    return contact_force_residual(system, indices.front(), ndx);
  };
  return result;
}

std::optional<ContactCost> make_friction_cone(const ResidualContext& context, int contact) {
  const CostSpec& cost = context.cost;
  const ContactSpec& on = context.spec.contacts[contact];
  if (on.axes != FrameAxes::world_aligned) {
    context.out.error(
        cost.residual.place,
        fmt::format("the friction cone of '{}' needs a normal that is fixed in the world",
                    on.name.value),
        "give the contact 'axes: world'");
    return std::nullopt;
  }
  const FrictionLimits limits = limits_of(cost, on);
  // The normal is that of the contact in its phase.
  if (!cost.keys.value(key::cone)) {
    const auto pyramid = [limits, faces = cost.keys.value(kFaces),
                          inner = cost.keys.value(kInner)](const Vector3<double>& normal) {
      return friction_pyramid(limits, faces, inner, normal);
    };
    ContactCost result = in_cone(pyramid(on.normal), context.ndx);
    result.make = [ndx = context.ndx, pyramid](const std::shared_ptr<const MultibodySystem>& system,
                                               const std::vector<int>& indices) {
      return contact_cone_residual(system, indices.front(), ndx,
                                   pyramid(normal_of(*system, indices)));
    };
    return result;
  }
  ContactCost result;
  result.lower = {-kUnlimited, limits.min_normal};
  result.upper = {0, limits.max_normal};
  result.make = [ndx = context.ndx, friction = limits.friction](
                    const std::shared_ptr<const MultibodySystem>& system,
                    const std::vector<int>& indices) {
    return friction_cone_residual(system, indices.front(), ndx, friction,
                                  normal_of(*system, indices));
  };
  name_rows(result.prototype, result.lower.size());
  return result;
}

/// Half the length and width of a contact's sole, m; reports a contact without a sole.
std::optional<std::array<double, 2>> sole_of(const ResidualContext& context, int contact) {
  const ContactSpec& on = context.spec.contacts[contact];
  if (on.kind == ContactKind::surface && on.half_size) return on.half_size;
  context.out.error(
      context.cost.residual.place,
      fmt::format("the residual '{}' needs a sole, which the contact '{}' does not have",
                  context.cost.residual.value, on.name.value),
      "give the contact 'type: surface' and 'size: [length, width]'");
  return std::nullopt;
}

std::optional<ContactCost> make_wrench_cone(const ResidualContext& context, int contact) {
  const auto sole = sole_of(context, contact);
  if (!sole) return std::nullopt;
  const FrictionLimits limits = limits_of(context.cost, context.spec.contacts[contact]);
  const bool inner = context.cost.keys.value(kInner);
  return in_cone(wrench_cone(limits, (*sole)[0], (*sole)[1], inner), context.ndx);
}

std::optional<ContactCost> make_center_of_pressure(const ResidualContext& context, int contact) {
  const auto sole = sole_of(context, contact);
  if (!sole) return std::nullopt;
  return in_cone(center_of_pressure_cone((*sole)[0], (*sole)[1]), context.ndx);
}

/// Restricts a key to pyramids; second-order cones reject it.
ResidualKey of_pyramids(ResidualKey key, const char* message) {
  key.visit = [visit = std::move(key.visit), message](Keys& keys, KeyInfo info, CostSpec& cost) {
    info.omitted = cost.keys.value(key::cone);
    visit(keys, info, cost);
    if (const auto value = keys.found(info.name); value && info.omitted) value->error(message);
  };
  return key;
}

void set_barrier_of_cone(CostSpec& cost) {
  cost.activation.kind = ActivationKind::quadratic_barrier;
}

}  // namespace

std::span<const ResidualDefinition> force_residuals() {
  static const NumberRange kFactor{0, 1, true, false, "a factor from 0 (excluded) to 1"};
  static const ResidualKey cone = residual_key(
      key::cone,
      {.says = "For friction_cone: a pyramid, or the cone itself with its tip rounded by 0.01 N"},
      WordForm(kConeWords, "cone"), {.of_constraints = false, .of_last_node = false});
  static const ResidualKey faces =
      of_pyramids(residual_key(kFaces, {.says = "For a pyramid: number of its faces"},
                               IntegerForm{3, 64}, {.of_last_node = false}),
                  "a second-order cone has no faces");
  static const ResidualKey inner =
      of_pyramids(residual_key(kInner,
                               {.says = "For friction_cone and wrench_cone: the pyramid is inside "
                                        "the cone (true) or contains it (false)"},
                               FlagForm{"value of 'inner'"}, {.of_last_node = false}),
                  "a second-order cone is exact: it has no 'inner'");
  static const ResidualKey safety = residual_key(
      key::safety,
      {.says = "For friction_cone and wrench_cone: the share of the friction coefficient that is "
               "used, without unit"},
      NumberForm{kFactor}, {.of_last_node = false});
  static const ResidualDefinition all[] = {
      {.name = "contact_force",
       .description = "force on the robot at a contact (and torque, if a surface) minus a "
                      "reference, world axes; an impulse at an impulse",
       .unit = "N and Nm, Ns and Nms",
       .synonyms = {"force", "forces", "wrench"},
       .needs = {.robot = true, .force = true},
       .keys = {&contacts_key()},
       .reference = &kRowsReference,
       .make_of_contact = make_force},
      {.name = "friction_cone",
       .description = "friction cone of a contact's force",
       .unit = "N",
       .synonyms = {"cone", "friction"},
       .needs = {.robot = true, .force = true},
       .keys = {&contacts_key(), &cone, &faces, &inner, &safety},
       .is_cone = true,
       .set_activation = set_barrier_of_cone,
       .make_of_contact = make_friction_cone},
      {.name = "wrench_cone",
       .description =
           "wrench cone of a sole's force and torque: friction, center of pressure, yaw torque",
       .unit = "N and Nm",
       .needs = {.robot = true, .force = true},
       .keys = {&contacts_key(), &inner, &safety},
       .is_cone = true,
       .set_activation = set_barrier_of_cone,
       .make_of_contact = make_wrench_cone},
      {.name = "center_of_pressure",
       .description = "cone of a sole's center of pressure alone",
       .unit = "Nm",
       .synonyms = {"cop", "zmp"},
       .needs = {.robot = true, .force = true},
       .keys = {&contacts_key()},
       .is_cone = true,
       .set_activation = set_barrier_of_cone,
       .make_of_contact = make_center_of_pressure}};
  return all;
}

}  // namespace conddp
