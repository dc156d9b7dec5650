// Exact partwise Hessians, compared with dual numbers through all of `differentiate`.
#include "support/second_derivatives.hpp"

#include <gtest/gtest.h>

#include "support/contact_case.hpp"
#include "support/knot_case.hpp"
#include "support/named_residuals.hpp"
#include "support/sizes.hpp"
#include "systems/closed_form.hpp"

namespace conddp {
namespace {

/// Without external wrenches, with damping and friction.
std::shared_ptr<const MultibodySystem> held_system(const ContactCase& c, bool contacts) {
  auto robot = std::make_shared<RobotModel>(*c.robot);
  robot->wrenches.clear();
  for (Joint& joint : robot->joints) {
    joint.damping = 0.3;
    joint.friction = 0.2;
  }
  return std::make_shared<MultibodySystem>(robot, Actuation::full(*robot),
                                           PassiveForces{true, true, 0.5},
                                           contacts ? c.contacts : std::vector<Contact>{});
}

/// Residuals of every kind with partwise Hessians.
std::vector<std::pair<std::string, std::shared_ptr<const Residual>>> known_residuals(
    const std::shared_ptr<const MultibodySystem>& system, const KnotModel& model) {
  const int frames = static_cast<int>(system->robot().frames.size());
  auto all = named_residuals(system, model, std::max(1, frames / 2));
  std::erase_if(all, [&](const auto& named) {
    return named.second->reads() == Reads::everything ||
           (named.second->needs_control() && model.nu() == 0);
  });
  return all;
}

ActivationKind kind_of(int i) {
  constexpr ActivationKind kKinds[] = {ActivationKind::quadratic, ActivationKind::smooth_l1,
                                       ActivationKind::quadratic_barrier,
                                       ActivationKind::smooth_l2};
  return kKinds[i % 4];
}

void add_costs(const std::shared_ptr<const MultibodySystem>& system, KnotModel& model) {
  int i = 0;
  for (const auto& [name, residual] : known_residuals(system, model)) {
    const int n = residual->size();
    model.add_cost(name, residual,
                   {.kind = kind_of(i++),
                    .lower = std::vector<double>(n, -0.1),
                    .upper = std::vector<double>(n, 0.2),
                    .epsilon = 0.3});
  }
}

void add_constraints(const std::shared_ptr<const MultibodySystem>& system, KnotModel& model,
                     RandomNumbers& random) {
  const int frame = moving_frames(system->robot()).front();
  const auto position = frame_position_residual(system, frame);
  using K = ConstraintKind;
  model.add_constraint(make_constraint("position", position, K::bounds));
  model.add_constraint(make_constraint("distance", position, K::norm));
  model.add_constraint(make_constraint("cone", position, K::second_order_cone, 0.7, Softness::l1));
  model.add_constraint(make_constraint("soft", position, K::bounds, 1, Softness::l2));
  model.add_constraint(make_constraint("state", state_residual(model.manifold()), K::norm));
  if (model.nu() == 0) return;
  const auto& contacts = system->contacts();
  for (int i = 0; i < contacts.count(); ++i) {
    const auto force = contact_force_residual(system, i, model.ndx());
    const auto friction =
        friction_cone_residual(system, i, model.ndx(), 0.6, Vector3<double>{0.36, -0.48, 0.8});
    const bool surface = contacts.contacts()[i].kind == ContactKind::surface;
    LinearCone cone{Eigen::MatrixXd(5, surface ? 6 : 3)};
    for (double& entry : cone.A.reshaped()) entry = random.uniform(-1, 1);
    const auto linear = contact_cone_residual(system, i, model.ndx(), cone);
    const auto velocity = contact_velocity_residual(system, contacts.contacts()[i]);
    model.add_cost("velocity", velocity, {.kind = ActivationKind::smooth_l1, .epsilon = 0.4});
    model.add_constraint(make_constraint("velocity", velocity, K::bounds));
    model.add_cost("force", force, {});
    model.add_cost("faces", linear, {.kind = ActivationKind::smooth_l1, .epsilon = 0.5});
    model.add_constraint(make_constraint("force", force, K::norm));
    model.add_constraint(make_constraint("force in a cone", force, K::second_order_cone, 0.5));
    model.add_constraint(make_constraint("friction", friction, K::bounds));
    model.add_constraint(make_constraint("faces", linear, K::bounds, 1, Softness::l1));
  }
}

void set_constraints(KnotCase& c, RandomNumbers& random) {
  for (const ConstraintTerm& term : c.model->constraints()) {
    double* reference = &c.parameters[term.parameters];
    const int n = term.residual->parameter_count();
    if (n == c.model->nx()) {
      const auto x = random_manifold_state(c.model->manifold(), random, 1.2);
      std::copy(x.begin(), x.end(), reference);
    } else {
      for (int i = 0; i < n; ++i) reference[i] = random.uniform(-1, 1);
    }
    if (term.has_bounds())
      for (int i = 0; i < term.rows; ++i) {
        c.parameters[term.lower() + i] = random.uniform(-0.5, 0);
        c.parameters[term.upper() + i] = random.uniform(0, 0.5);
      }
    c.parameters[term.active()] = 1;
    if (term.softness != Softness::hard) c.parameters[term.weight()] = random.uniform(1, 50);
  }
}

void expect_equal_hessians(const KnotCase& c, RandomNumbers& random) {
  const int knots = kLaneWidth + 1;
  const ShootingProblem problem = problem_of(c, knots);
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k <= knots; ++k) {
    const auto x = random_manifold_state(problem.manifold(), random, 1.0);
    std::copy(x.begin(), x.end(), t.x(k).data());
    if (k == knots) break;
    for (double& u : t.u(k)) u = random.uniform(-2, 2);
  }
  Augmentation augmentation(problem);
  for (const NodeConstraint& node : problem.constraints()) {
    const double penalty = random.uniform(0.5, 3);
    for (int i = node.row; i < node.row + node.term->rows; ++i) {
      augmentation.penalty[i] = penalty;
      augmentation.shift[i] = random.uniform(-0.5, 0.5);
      augmentation.multiplier[i] = random.uniform(-1, 1);
    }
  }
  expect_hessians_of_dual_numbers(problem, t, augmentation, random);
}

/// True if contacts are dependent, so that forces are rounding divided by compliance.
bool redundant(const MultibodySystem& system) {
  RandomNumbers random(3);
  const auto x = random_manifold_state(system.manifold(), random, 1.0);
  const std::vector<double> u(system.nu());
  const auto data = system.create_data(0.0);
  system.evaluate(x.data(), u.data(), *data);
  return !system.contacts().empty() &&
         static_cast<const MultibodySystem::Data<double>&>(*data).contacts.compliant;
}

TEST(SecondDerivatives, PartwiseHessiansMatchDualNumbers) {
  RandomNumbers random(41);
  int known = 0;
  const int stride = kSmallSizes ? 20 : 1;
  const std::vector<ContactCase> cases = contact_cases();
  for (std::size_t i = 0; i < cases.size(); i += stride)
    for (const bool contacts : {false, true}) {
      const ContactCase& c = cases[i];
      const auto system = held_system(c, contacts);
      if (redundant(*system)) continue;
      const auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
      add_costs(system, *model);
      add_constraints(system, *model, random);
      EXPECT_EQ(known_by_parts(*model), system->mimic_map().identity()) << c.name;
      if (!known_by_parts(*model)) continue;
      ++known;
      KnotCase knot = make_case(c.name, model, random);
      set_constraints(knot, random);
      SCOPED_TRACE(c.name);
      expect_equal_hessians(knot, random);
      if (HasFatalFailure()) return;
    }
  EXPECT_GE(known, 40 / stride);
}

TEST(SecondDerivatives, HessiansMatchDualNumbersForRulesAndSystems) {
  RandomNumbers random(43);
  int known = 0;
  for (const auto& [name, system] : test_systems())
    for (const Integrator integrator : integrators_of(*system)) {
      SCOPED_TRACE(name + " " + std::string(info_of(integrator).name));
      const auto model = std::make_shared<KnotModel>(system, integrator);
      model->add_cost("state", state_residual(model->manifold()), {});
      if (model->nu() > 0)
        model->add_cost("control", control_residual(model->ndx(), model->nu()),
                        {.kind = ActivationKind::smooth_l1, .epsilon = 0.3});
      EXPECT_TRUE(known_by_parts(*model) || system->as_multibody() != nullptr);
      if (!known_by_parts(*model)) continue;
      ++known;
      KnotCase knot = make_case(name, model, random);
      knot.dt = 0.3;  // separates the stages
      expect_equal_hessians(knot, random);
      if (HasFatalFailure()) return;
    }
  EXPECT_GE(known, 40);
}

TEST(SecondDerivatives, RobotStagesOnContactsMatchDualNumbers) {
  RandomNumbers random(44);
  int known = 0;
  const std::vector<ContactCase> cases = contact_cases();
  for (std::size_t i = 0; i < cases.size(); i += kSmallSizes ? 20 : 4) {
    const ContactCase& c = cases[i];
    const auto system = held_system(c, true);
    if (redundant(*system)) continue;
    const auto model = std::make_shared<KnotModel>(system, Integrator::rk4);
    add_costs(system, *model);
    add_constraints(system, *model, random);
    if (!known_by_parts(*model)) continue;
    ++known;
    KnotCase knot = make_case(c.name, model, random);
    set_constraints(knot, random);
    SCOPED_TRACE(c.name);
    expect_equal_hessians(knot, random);
    if (HasFatalFailure()) return;
  }
  EXPECT_GE(known, 1);
}

/// A formula that supports only dual numbers.
class OwnFormula : public ClosedFormSystem<OwnFormula> {
 public:
  OwnFormula() : ClosedFormSystem(SystemKind::first_order, StateManifold::flat(1), 1) {}
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    f[0] = select(x[0] < S(0.0), x[0] * u[0], u[0]);
  }
};

TEST(SecondDerivatives, PartlyUnknownModelsUseDualNumbers) {
  const ContactCase c = contact_cases().front();
  const auto system = held_system(c, true);
  const auto with = [&](Integrator integrator, bool memory, auto add) {
    KnotModel model(step_with(system, integrator, memory));
    add(model);
    return known_by_parts(model);
  };
  const auto nothing = [](KnotModel&) {};
  EXPECT_TRUE(with(Integrator::semi_implicit_euler, false, nothing));
  EXPECT_TRUE(with(Integrator::rk4, false, nothing));
  EXPECT_FALSE(with(Integrator::rk4, true, nothing));
  EXPECT_FALSE(with(Integrator::semi_implicit_euler, true, nothing));
  EXPECT_FALSE(with(Integrator::semi_implicit_euler, false, [&](KnotModel& model) {
    model.add_cost("a", acceleration_residual(*system, model.ndx(), {0}), {});
  }));
  auto pushed = std::make_shared<RobotModel>(system->robot());
  pushed->wrenches.push_back({moving_frames(*pushed).front(), Force<double>::zero()});
  EXPECT_FALSE(
      known_by_parts(KnotModel(std::make_shared<MultibodySystem>(pushed, Actuation::full(*pushed)),
                               Integrator::semi_implicit_euler)));
  EXPECT_TRUE(known_by_parts(KnotModel(pendulum({}), Integrator::semi_implicit_euler)));
  EXPECT_FALSE(known_by_parts(KnotModel(std::make_shared<OwnFormula>(), Integrator::rk4)));
}

}  // namespace
}  // namespace conddp
