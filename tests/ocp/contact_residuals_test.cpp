#include <gtest/gtest.h>

#include "ocp/residuals.hpp"
#include "support/contact_case.hpp"
#include "support/knot_case.hpp"

namespace conddp {
namespace {

struct NamedResidual {
  std::string name;
  std::shared_ptr<const Residual> residual;
};

std::vector<NamedResidual> residuals_of(const std::shared_ptr<const MultibodySystem>& system) {
  const int ndx = system->ndx();
  std::vector<NamedResidual> all = {{"momentum", centroidal_momentum_residual(system)}};
  for (int i = 0; i < system->contacts().count(); ++i) {
    const Contact& contact = system->contacts().contacts()[i];
    const Vector3<double> normal{0.36, -0.48, 0.8};
    all.push_back({contact.name + " force", contact_force_residual(system, i, ndx)});
    all.push_back({contact.name + " pyramid",
                   contact_cone_residual(system, i, ndx,
                                         friction_pyramid({.friction = 0.7}, 5, true, normal))});
    all.push_back({contact.name + " cone", friction_cone_residual(system, i, ndx, 0.7, normal)});
    if (contact.kind != ContactKind::surface) continue;
    all.push_back({contact.name + " wrench",
                   contact_cone_residual(system, i, ndx, wrench_cone({}, 0.1, 0.05, true))});
  }
  return all;
}

class ContactResiduals : public testing::TestWithParam<ContactCase> {};

void expect_gradients_of_dual_numbers(const std::shared_ptr<const MultibodySystem>& system,
                                      Integrator integrator, RandomNumbers& random) {
  for (const NamedResidual& named : residuals_of(system)) {
    auto model = std::make_shared<KnotModel>(system, integrator);
    model->add_cost(named.name, named.residual, {});
    const KnotCase c = make_case(named.name, model, random);
    KnotWorkspace<double> work(*model);
    model->differentiate(KnotInput<double>{c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt},
                         work, true);
    double scale = 1;
    for (double g : work.gradient) scale = std::max(scale, std::abs(g));
    for (int d = 0; d < model->nz(); ++d)
      EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-8 * scale)
          << named.name << " direction " << d;
  }
}

TEST_P(ContactResiduals, GradientsAreThoseOfDualNumbers) {
  RandomNumbers random(31);
  const ContactCase& c = GetParam();
  expect_gradients_of_dual_numbers(
      std::make_shared<MultibodySystem>(c.robot, Actuation::full(*c.robot), PassiveForces{},
                                        c.contacts),
      Integrator::semi_implicit_euler, random);
}

TEST_P(ContactResiduals, GradientsAtImpulsesAreThoseOfDualNumbers) {
  RandomNumbers random(32);
  const ContactCase& c = GetParam();
  expect_gradients_of_dual_numbers(std::make_shared<MultibodySystem>(c.robot, c.contacts, 0.3),
                                   Integrator::impulse, random);
}

/// Contacts that a robot can keep all at once: where it cannot, forces are as large as 1/ε, and
/// rounding with them.
std::vector<ContactCase> independent_contact_cases() {
  RandomNumbers random(33);
  std::vector<ContactCase> independent;
  for (const ContactCase& c : contact_cases()) {
    const MultibodySystem system(c.robot, c.contacts, 0);
    const auto data = system.create_data(double{});
    const auto x = random_manifold_state(system.manifold(), random, 1.2);
    system.evaluate(x.data(), nullptr, *data);
    if (!static_cast<const MultibodySystem::Data<double>&>(*data).contacts.compliant)
      independent.push_back(c);
  }
  return independent;
}

INSTANTIATE_TEST_SUITE_P(All, ContactResiduals, testing::ValuesIn(independent_contact_cases()),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace conddp
