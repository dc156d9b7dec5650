#include <gtest/gtest.h>

#include "ocp/residuals/residuals.hpp"
#include "support/contact_case.hpp"
#include "support/knot_case.hpp"
#include "support/sizes.hpp"

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
    all.push_back({contact.name + " velocity", contact_velocity_residual(system, contact)});
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
    for (int d = 0; d < model->nz(); d += kDirectionStride)
      EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-8 * scale)
          << named.name << " direction " << d;
  }
}

TEST_P(ContactResiduals, GradientsMatchDualNumbers) {
  RandomNumbers random(31);
  const ContactCase& c = GetParam();
  expect_gradients_of_dual_numbers(
      std::make_shared<MultibodySystem>(c.robot, Actuation::full(*c.robot), PassiveForces{},
                                        c.contacts),
      Integrator::semi_implicit_euler, random);
}

TEST_P(ContactResiduals, GradientsAtImpulsesMatchDualNumbers) {
  RandomNumbers random(32);
  const ContactCase& c = GetParam();
  expect_gradients_of_dual_numbers(std::make_shared<MultibodySystem>(c.robot, c.contacts, 0.3),
                                   Integrator::impulse, random);
}

/// Hides that a residual is a linear image.
class Plain : public ResidualBase<Plain> {
 public:
  explicit Plain(std::shared_ptr<const Residual> of)
      : ResidualBase(of->blocks(), of->parameter_count(), of->needs_control()),
        of_(std::move(of)) {}
  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    of_->evaluate(in, r);
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    of_->differentiate(in, r, jacobian);
  }

 private:
  std::shared_ptr<const Residual> of_;
};

TEST_P(ContactResiduals, CostsOfLinearImagesMatchTheirRows) {
  RandomNumbers random(34);
  const ContactCase& c = GetParam();
  const auto system = std::make_shared<MultibodySystem>(c.robot, Actuation::full(*c.robot),
                                                        PassiveForces{}, c.contacts);
  for (const NamedResidual& named : residuals_of(system)) {
    if (named.residual->linear_image() == nullptr) continue;
    const int rows = named.residual->size();
    Activation barrier{.kind = ActivationKind::quadratic_barrier};
    for (int i = 0; i < rows; ++i) {
      barrier.lower.push_back(random.uniform(-100, 0));
      barrier.upper.push_back(random.uniform(0, 100));
      barrier.weights.push_back(random.uniform(0.5, 2));
    }
    for (const Activation& activation :
         {Activation{}, barrier, Activation{.kind = ActivationKind::smooth_l2, .epsilon = 1}}) {
      std::shared_ptr<KnotModel> models[2];
      for (auto& model : models)
        model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
      models[0]->add_cost("image", named.residual, activation);
      models[1]->add_cost("plain", std::make_shared<Plain>(named.residual), activation);
      const KnotCase knot = make_case(named.name, models[0], random);
      const KnotInput<double> in{knot.x.data(), knot.u.data(), knot.parameters.data(), knot.dt,
                                 knot.dt};
      KnotWorkspace<double> image(*models[0]), plain(*models[1]);
      models[0]->differentiate(in, image, true);
      models[1]->differentiate(in, plain, true);
      EXPECT_EQ(image.cost, plain.cost) << named.name;
      const auto expect_near = [&](const AlignedVector<double>& a, const AlignedVector<double>& b) {
        ASSERT_EQ(a.size(), b.size());
        double scale = 1;
        for (double entry : b) scale = std::max(scale, std::abs(entry));
        // Near dependent contacts, derivatives of large forces cancel.
        for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9 * scale);
      };
      expect_near(image.gradient, plain.gradient);
      expect_near(image.hessian, plain.hessian);
    }
  }
}

TEST_P(ContactResiduals, InactiveBarrierHasNoSlopeOrCurvature) {
  RandomNumbers random(35);
  const ContactCase& c = GetParam();
  const auto system = std::make_shared<MultibodySystem>(c.robot, Actuation::full(*c.robot),
                                                        PassiveForces{}, c.contacts);
  const auto residual = contact_force_residual(system, 0, system->ndx());
  const Activation barrier{.kind = ActivationKind::quadratic_barrier,
                           .lower = std::vector<double>(residual->size(), 0),
                           .upper = std::vector<double>(residual->size(), 0)};
  auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  const int reference = model->add_cost("force", residual, barrier);
  KnotCase knot = make_case("force", model, random);
  const KnotInput<double> in{knot.x.data(), knot.u.data(), knot.parameters.data(), knot.dt,
                             knot.dt};
  KnotWorkspace<double> work(*model);
  const auto largest = [](const AlignedVector<double>& a) {
    double sum = 0;
    for (double entry : a) sum = std::max(sum, std::abs(entry));
    return sum;
  };
  model->differentiate(in, work, true);
  EXPECT_GT(largest(work.gradient), 0);
  EXPECT_GT(largest(work.hessian), 0);
  // With the force itself as reference, no residual remains outside.
  std::vector<double> zero(residual->parameter_count(), 0), force(residual->size());
  const auto data = system->create_data(double{});
  system->evaluate(knot.x.data(), knot.u.data(), *data);
  residual->evaluate(ResidualInput<double>{knot.x.data(), knot.u.data(), zero.data(), *data},
                     force.data());
  std::copy(force.begin(), force.end(), knot.parameters.begin() + reference);
  model->differentiate(in, work, true);
  EXPECT_EQ(work.cost, 0);
  EXPECT_EQ(largest(work.gradient), 0);
  EXPECT_EQ(largest(work.hessian), 0);
}

/// Contacts that a robot can satisfy together: otherwise forces, and their rounding, reach 1/ε.
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
