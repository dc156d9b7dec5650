#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

const std::vector<std::string> kDirectionNames = {"normal", "tangent"};

std::optional<ContactCost> make_contact_velocity(const ResidualContext& context, int index) {
  const Contact& contact = context.contacts[index];
  const bool directions =
      contact.kind == ContactKind::normal || contact.kind == ContactKind::planar;
  const auto& names = directions ? kDirectionNames : kTwistNames;
  ContactCost result;
  result.prototype.rows = {"components of the velocity",
                           {names.begin(), names.begin() + contact.rows()}};
  result.make = [contact](const std::shared_ptr<const MultibodySystem>& system,
                          const std::vector<int>&) {
    return contact_velocity_residual(system, contact);
  };
  return result;
}

}  // namespace

std::span<const ResidualDefinition> contact_velocity_residuals() {
  static const ResidualDefinition all[] = {
      {.name = "contact_velocity",
       .description = "velocity of a contact in the directions that it holds, in its axes",
       .unit = "m/s and rad/s",
       .needs = {.robot = true},
       .keys = {&contacts_key()},
       .make_of_contact = make_contact_velocity}};
  return all;
}

}  // namespace conddp
