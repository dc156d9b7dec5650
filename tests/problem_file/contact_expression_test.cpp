// Expressions that read contact forces and velocities.
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/residuals/system_columns.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

const std::string kShared = kStandingQuadruped + R"(phases:
  - {name: stand, knots: 2, dt: 0.02, contacts: all}
  - {name: lift, knots: 2, dt: 0.02, contacts: [LH, RH, LF]}
  - {name: pair, knots: 2, dt: 0.02, contacts: [RF, LH]}
costs:
  effort: {residual: control}
  shared:
    residual: expression
    of:
      front: {residual: contact_force, contacts: [RF]}
      hind: {residual: contact_force, contacts: [LH]}
      foot: {residual: frame_position, frame: lh_foot}
    rows: {even: front.fz - hind.fz, pull: hind.fx*foot.z}
    reference: {even: 5}
initial_guess: {controls: quasi_static}
)";

const CostTerm* shared_cost(const KnotView& view) {
  for (const CostTerm& cost : view.model->costs())
    if (cost.name == "shared") return &cost;
  return nullptr;
}

TEST(ContactExpressions, CountWhereAllTheirContactsAreHeld) {
  const Loaded loaded(kShared);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const auto is_on = [&](int k) {
    const KnotView view = problem.knot(k);
    const CostTerm* cost = shared_cost(view);
    return cost != nullptr && view.parameters[cost->weight] != 0;
  };
  EXPECT_TRUE(is_on(0));
  EXPECT_FALSE(is_on(2));  // RF is lifted
  EXPECT_TRUE(is_on(4));
}

/// Cost rows at a knot of the guess, and the forces there in contact order.
struct AtKnot {
  std::vector<double> rows;
  std::vector<Force<double>> forces;
  double height = 0;  ///< of the last contact
};

AtKnot at_knot(const Loaded& loaded, int k) {
  const ShootingProblem& problem = *loaded.built->problem;
  const KnotView view = problem.knot(k);
  const auto& system = dynamic_cast<const MultibodySystem&>(view.model->system());
  const auto data = system.create_data(0.0);
  const Trajectory& guess = loaded.built->guess;
  system.evaluate(guess.x(k).data(), guess.u(k).data(), *data);
  AtKnot at;
  const CostTerm* cost = shared_cost(view);
  at.rows.resize(static_cast<std::size_t>(cost->residual->size()));
  const ResidualInput<double> input{guess.x(k).data(), guess.u(k).data(),
                                    view.parameters + cost->parameters, *data};
  cost->residual->evaluate(input, at.rows.data());
  for (const auto& contact : multibody_data(input).contacts.contacts) {
    at.forces.push_back(contact_force_in_world(contact));
    at.height = contact.world.p[2];
  }
  return at;
}

TEST(ContactExpressions, ReadContactForcesInEverySystem) {
  const Loaded loaded(kShared);
  ASSERT_TRUE(loaded.built) << loaded.all();
  // All four feet are held first, then RF and LH.
  for (const auto& [knot, front, hind] : {std::tuple{0, 1, 2}, {4, 0, 1}}) {
    const AtKnot at = at_knot(loaded, knot);
    ASSERT_EQ(at.rows.size(), 2u);
    EXPECT_NE(at.forces[hind].linear[2], 0);
    EXPECT_NEAR(at.rows[0], at.forces[front].linear[2] - at.forces[hind].linear[2] - 5, 1e-9);
    EXPECT_NEAR(at.rows[1], at.forces[hind].linear[0] * at.height, 1e-9);
  }
}

TEST(ContactExpressions, DerivativesMatchDifferences) {
  const Loaded loaded(kShared);
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const DerivativeComparison& derivative :
       check_derivatives(*loaded.built->problem, loaded.built->guess, {.knots_per_phase = 2}))
    EXPECT_LT(derivative.error, 1e-7);
}

TEST(ContactExpressions, ReportUnreadableQuantities) {
  struct Said {
    const char *from, *to, *says;
  };
  const Said mistakes[] = {
      {"contacts: [RF]}\n", "contacts: [RF, LF]}\n",
       "21:7: error: 'front' has to be of one contact, not of 2"},
      {"contacts: [RF]}\n", "contacts: [XX]}\n", "21:51: error: unknown contact 'XX'"},
      {"{residual: contact_force, contacts: [RF]}", "{residual: friction_cone, contacts: [RF]}",
       "21:25: error: 'friction_cone' is a set, and expressions read numbers"},
      {"front.fz", "front.fw", "24:24: error: unknown part 'fw' of a vector of 3"},
      {"initial_guess",
       "terminal: {costs: {end: {residual: expression, rows: f.fz, of: {f: "
       "{residual: contact_force, contacts: [LH]}}}}}\ninitial_guess",
       "the last node has no forces of contacts that an expression could read"}};
  for (const Said& mistake : mistakes) {
    const Loaded loaded(replaced(kShared, mistake.from, mistake.to));
    EXPECT_FALSE(loaded.built) << mistake.to;
    EXPECT_NE(loaded.all().find(mistake.says), std::string::npos) << mistake.to << loaded.all();
    EXPECT_EQ(loaded.diagnostics.error_count(), 1) << mistake.to;
  }
}

}  // namespace
}  // namespace conddp
