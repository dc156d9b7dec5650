// Contacts, impulses, swings, and terminal contacts in problem files.
#include <cmath>

#include <fmt/format.h>

#include "problem_file/motion/contact_plan.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

const std::string kStepping = kStandingQuadruped + R"(phases:
  - {name: stand, knots: 5, dt: 0.02, contacts: all}
  - {name: lift, knots: 10, dt: 0.02, contacts: [LF, LH, RH]}
  - {name: rest, knots: 5, dt: 0.02, contacts: all}
costs:
  swing: {residual: frame_position, frame: rf_foot, phases: lift, weight: 100,
          swing: {height: 0.1, step: [0.2, 0.1, 0]}}
initial_guess: {controls: quasi_static}
)";

TEST(ContactFile, WarnsAboutDegreesAndMilliseconds) {
  EXPECT_NE(
      warnings(replaced(kStepping, "[0, 0, 0.57]", "[0, 0, 0.57], rpy: [0, 0, 90]"))
          .find("an angle of 90 rad is more than a turn (angles are in rad: 90° is 1.571 rad)"),
      std::string::npos);
  EXPECT_NE(warnings(replaced(kStepping, "knots: 10, dt: 0.02", "knots: 10, dt: 20"))
                .find("a time step of the phase 'lift' lasts 20 s (times are in s: "),
            std::string::npos);
}

TEST(ContactFile, WarnsAboutSoleFramesOffTheNormal) {
  const auto with = [](const std::string& keys) {
    return warnings(replaced(kStepping, "{frame: rh_foot}",
                             "{frame: rh_foot, type: surface, size: [0.1, 0.1]" + keys + "}"));
  };
  EXPECT_EQ(with(", axes: local"), "");
  // Hip and knee rotate it.
  EXPECT_NE(with("").find("7:15: the z axis of the sole 'rh_foot' is 43° "), std::string::npos)
      << with("");
  EXPECT_NE(with(", axes: local, normal: [0.5, 0, 0.866]").find(" is 30° off the normal"),
            std::string::npos);
}

TEST(ContactFile, WarnsAboutGravityOffAllSurfaces) {
  const auto with = [](const std::string& gravity) {
    return warnings(kStepping + "gravity: " + gravity + "\n");
  };
  EXPECT_NE(with("[0, 0, 9.81]").find("gravity, [0, 0, 9.81] m/s², pulls away from the surface"),
            std::string::npos)
      << with("[0, 0, 9.81]");
  EXPECT_EQ(with("[1, 0, -9.81]").find("pulls away"), std::string::npos);
  EXPECT_EQ(with("[0, 0, 0]").find("pulls away"), std::string::npos);
  const std::string one_below =
      replaced(kStepping, "{frame: rh_foot}", "{frame: rh_foot, normal: [0, 0, -1]}");
  EXPECT_EQ(warnings(one_below).find("pulls away"), std::string::npos);
}

TEST(ContactFile, WarnsAboutTermsOnContactsNoPhaseHolds) {
  const auto with = [](const std::string& term) {
    return warnings(replaced(kStepping, "costs:\n", "costs:\n  own: " + term + "\n"));
  };
  const std::string nowhere =
      "'own' counts nowhere: where it could, its contacts are not held (phases hold contacts by "
      "their key, 'contacts: all')\n";
  EXPECT_EQ(with("{residual: friction_cone}"), "");
  EXPECT_EQ(with("{residual: friction_cone, contacts: [RF]}"), "");
  EXPECT_EQ(with("{residual: friction_cone, phases: lift}"), "");
  EXPECT_EQ(with("{residual: friction_cone, contacts: [RF], phases: lift}"), "17:19: " + nowhere);
  EXPECT_EQ(with("{residual: friction_cone, contacts: [RF], knots: [5]}"), "17:19: " + nowhere);
  const std::string both =
      "{residual: expression, rows: a.fz - b.fz, phases: lift, of: {a: "
      "{residual: contact_force, contacts: [LF]}, b: {residual: "
      "contact_force, contacts: [RF]}}}";
  EXPECT_EQ(with(both), "17:19: " + nowhere);
}

TEST(ContactFile, ReportsMistakesAtTheirPlaces) {
  struct Said {
    const char *from, *to, *says;
  };
  const Said mistakes[] = {
      {"frame: lf_foot", "frame: lf_fot", "4:15: the robot has no frame 'lf_fot'"},
      {"{frame: lf_foot}", "{type: point}", "4:7: 'contacts.LF' lacks the key 'frame'"},
      {"{frame: lf_foot}", "{frame: lf_foot, type: edge}", "4:30: unknown type of contact 'edge'"},
      {"{frame: lf_foot}", "{frame: lf_foot, axes: base}", "4:30: unknown system of axes 'base'"},
      {"{frame: lf_foot}", "{frame: lf_foot, normal: [0, 0, 0]}", "4:32: a direction of length 0"},
      {"{frame: lf_foot}", "{frame: lf_foot, friction: 0}", "4:34: a positive number is expected"},
      {"{frame: lf_foot}", "{frame: lf_foot, mu: 1}", "4:24: unknown key 'mu' in 'contacts.LF'"},
      {"{frame: lf_foot}", "{frame: lf_foot, type: planar, normal: [1, 0, 0]}",
       "4:3: the tangent of a planar contact must not be along its normal"},
      {"LF: {frame", "a/b: {frame", "4:3: 'a/b' cannot be the name of a contact"},
      {"contacts: [LF, LH, RH]", "contacts: [LF, LH, FH]", "14:58: unknown contact 'FH'"},
      {"contacts:\n  LF: {frame: lf_foot}\n  RF: {frame: rf_foot}\n  LH: {frame: lh_foot}\n"
       "  RH: {frame: rh_foot}\n",
       "", "8:12: the phase 'stand' holds all contacts, and the file has none"},
      {"knots: 5, dt: 0.02, contacts: all}\ncosts", "impulse: all, restitution: 2}\ncosts",
       "15:45: a number from 0 to 1 is expected here"},
      {"contacts: [LF, LH, RH]}", "contacts: all}\n  - {impulse: all}",
       "15:15: the impulse 'phase_3' of 'LF', 'RF', 'LH', 'RH' has no time in the air before it"},
      {"phases: lift, ", "phases: [stand, lift], ",
       "18:18: 'rf_foot' cannot swing in phase 'stand', which holds it on the ground by the"},
      {"phases: lift, ", "knots: [7], ", "18:18: 'rf_foot' cannot swing in phase 'stand'"},
      {"contacts: [LF, LH, RH]", "contacts: all",
       "18:18: 'rf_foot' is asked to swing and never lifts: every phase holds it on the ground"},
      {"frame_position", "frame_velocity", "18:18: the residual 'frame_velocity' has no 'swing'"},
      {"step: [0.2, 0.1, 0]", "displaced: [[0, 0, 0], [0, 0, 0]]",
       "18:18: 'rf_foot' swings 1 time, and 'displaced' has 2 landings"},
      {"initial_guess", "terminal: {contacts: [RG]}\ninitial_guess", "19:23: unknown contact 'RG'"},
      {"initial_guess",
       "terminal: {contacts: [], costs: {a: {residual: contact_velocity}}}\ninitial_guess",
       "19:48: the last node holds no contact"},
  };
  for (const Said& m : mistakes) {
    const Loaded loaded(replaced(kStepping, m.from, m.to));
    EXPECT_FALSE(loaded.built) << m.to;
    EXPECT_TRUE(loaded.first_error().starts_with(m.says)) << m.to << '\n' << loaded.all();
  }
}

TEST(ContactFile, ImpulseWithStandingFeetIsAccepted) {
  const Loaded loaded(
      replaced(kStepping, "  - {name: rest", "  - {impulse: all}\n  - {name: rest"));
  EXPECT_TRUE(loaded.built) << loaded.all();
}

TEST(ContactFile, NormalizedNormalsSurviveARoundTrip) {
  const Loaded first(
      replaced(kStepping, "{frame: lf_foot}", "{frame: lf_foot, normal: [-1, 2, 10]}"));
  const Vector3<double> n = first.spec->contacts[0].normal;
  EXPECT_NEAR(squared_norm(n), 1, 1e-15);
  const Loaded again(
      replaced(kStepping, "{frame: lf_foot}",
               fmt::format("{{frame: lf_foot, normal: [{}, {}, {}]}}", n.x, n.y, n.z)));
  for (int i = 0; i < 3; ++i) EXPECT_EQ(again.spec->contacts[0].normal[i], n[i]);
}

struct CostAt {
  double weight = 0;  ///< cost scale included
  std::vector<double> reference;
};

CostAt cost_at(const ShootingProblem& problem, int k, const std::string& name) {
  const KnotView& knot = problem.knot(k);
  for (const CostTerm& term : knot.model->costs())
    if (term.name == name)
      return {knot.parameters[term.weight] * knot.cost_scale,
              {knot.parameters + term.parameters, knot.parameters + term.weight}};
  return {};
}

TEST(Swing, ArchesFromStanceToTouchDown) {
  const Loaded loaded(kStepping);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const int frame = *loaded.built->plant.robot().find_frame("rf_foot");
  const Vector3<double> stance =
      placement_in_state(*loaded.built->plant.multibody(), problem.initial_state(), frame).p;
  for (int k = 0; k < 20; ++k) {
    const CostAt cost = cost_at(problem, k, "swing");
    const bool swings = k >= 5 && k <= 15;
    // A rate during the swing, and an instantaneous cost at touch-down.
    EXPECT_NEAR(cost.weight, k == 15 ? 100 : swings ? 100 * 0.02 : 0, 1e-12) << k;
    if (!swings) continue;
    const double s = (k - 5) / 10.0, along = s * s * (3 - 2 * s);
    EXPECT_NEAR(cost.reference[0], stance.x + 0.2 * along, 1e-12);
    EXPECT_NEAR(cost.reference[1], stance.y + 0.1 * along, 1e-12);
    EXPECT_NEAR(cost.reference[2], stance.z + 1.6 * s * s * (1 - s) * (1 - s), 1e-12);
  }
}

TEST(Swing, IsEvenInTimeAcrossPhasesAndImpulses) {
  const Loaded whole(
      replaced(replaced(kStepping, "  - {name: lift, knots: 10, dt: 0.02, contacts: [LF, LH, RH]}",
                        "  - {name: lift, knots: 10, dt: 0.01, contacts: [LF, RH]}\n"
                        "  - {name: other, impulse: [LF, LH, RH]}\n"
                        "  - {name: on, knots: 2, dt: 0.05, contacts: [LF, LH, RH]}"),
               "phases: lift", "phases: [lift, other, on]"));
  ASSERT_TRUE(whole.built) << whole.all();
  const ShootingProblem& problem = *whole.built->problem;
  // Halfway is reached after 0.1 s, before and after the impulse, for any steps.
  const double top = cost_at(problem, 15, "swing").reference[2];
  EXPECT_EQ(cost_at(problem, 16, "swing").reference[2], top);
  EXPECT_NEAR(top - cost_at(problem, 5, "swing").reference[2], 0.1, 1e-12);
  EXPECT_NEAR(cost_at(problem, 18, "swing").reference[2], cost_at(problem, 5, "swing").reference[2],
              1e-12);
}

TEST(Swing, PlacementTurnsTheFrameAboutTheVertical) {
  const Loaded loaded(replaced(replaced(kStepping, "frame_position", "frame_placement"),
                               "step: [0.2, 0.1, 0]", "displaced: [[0.1, 0, 0.4]]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const auto turned = [&](int k) {
    const std::vector<double> a = cost_at(problem, 5, "swing").reference;
    const std::vector<double> b = cost_at(problem, k, "swing").reference;
    const Quaternion<double> q = Quaternion<double>{b[3], b[4], b[5], b[6]} *
                                 conjugate(Quaternion<double>{a[3], a[4], a[5], a[6]});
    EXPECT_NEAR(std::hypot(q.x, q.y), 0, 1e-12);
    return 2 * std::atan2(q.z, q.w);
  };
  EXPECT_NEAR(turned(10), 0.2, 1e-12);
  EXPECT_NEAR(turned(15), 0.4, 1e-12);
}

TEST(LastNode, HoldsLastPhaseContactsOrItsOwn) {
  const std::string costs =
      "costs: {still: {residual: contact_velocity, weight: 3}}}\ninitial_guess";
  const auto count = [](const Loaded& loaded) {
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? loaded.built->problem->terminal().model->costs().size() : 0;
  };
  EXPECT_EQ(count(Loaded(replaced(kStepping, "initial_guess", "terminal: {" + costs))), 4u);
  EXPECT_EQ(count(Loaded(
                replaced(kStepping, "initial_guess", "terminal: {contacts: [LF, RH], " + costs))),
            2u);
}

TEST(LastNode, IsTouchDownIfItHoldsTheFoot) {
  const std::string swinging =
      replaced(kStepping, "  - {name: rest, knots: 5, dt: 0.02, contacts: all}\n", "");
  const Loaded without(swinging);
  ASSERT_TRUE(without.built) << without.all();
  EXPECT_TRUE(without.built->problem->terminal().model->costs().empty());
  const Loaded with(
      replaced(swinging, "initial_guess", "terminal: {contacts: all}\ninitial_guess"));
  ASSERT_TRUE(with.built) << with.all();
  const ShootingProblem& problem = *with.built->problem;
  const CostAt landing = cost_at(problem, problem.knots(), "swing");
  EXPECT_EQ(landing.weight, 100);
  EXPECT_NEAR(landing.reference[0] - cost_at(problem, 5, "swing").reference[0], 0.2, 1e-12);
}

/// Growth of a unit error at rest after many steps.
double error_after(Integrator integrator, double kp, double kd, double dt) {
  double e = 1, v = 0;
  const auto a = [&](double x, double w) { return -kp * x - kd * w; };
  for (int k = 0; k < 3000 && std::abs(e) + std::abs(v) * dt < 1e6; ++k) {
    if (integrator == Integrator::semi_implicit_euler) {
      v += dt * a(e, v);
      e += dt * v;
    } else if (integrator == Integrator::explicit_euler) {
      const double slope = v;
      v += dt * a(e, v);
      e += dt * slope;
    } else {  // rk2
      const double em = e + dt / 2 * v, vm = v + dt / 2 * a(e, v);
      e += dt * vm;
      v += dt * a(em, vm);
    }
  }
  return std::abs(e) + std::abs(v) * dt;
}

TEST(Baumgarte, IsStableExactlyIfErrorsDecay) {
  int stable = 0, unstable = 0;
  for (const Integrator integrator :
       {Integrator::semi_implicit_euler, Integrator::explicit_euler, Integrator::rk2})
    for (const double kp : {10.0, 400.0, 2500.0, 9000.0})
      for (const double kd : {1.0, 15.0, 90.0, 150.0, 210.0}) {
        const double dt = 0.01;
        const double left = error_after(integrator, kp, kd, dt);
        const bool is = is_stable(integrator, kp, kd, dt);
        // Slow errors have not decayed yet, but none grows.
        if (is)
          EXPECT_LT(left, 1) << kp << ' ' << kd;
        else
          EXPECT_GT(left, 1) << kp << ' ' << kd;
        (is ? stable : unstable) += 1;
      }
  EXPECT_GT(stable, 15);
  EXPECT_GT(unstable, 10);
}

TEST(Baumgarte, WarnsAboutUnstableStepsAndSaysWhy) {
  const auto with = [](const char* gains) {
    return replaced(kStepping, "{frame: lf_foot}",
                    std::string("{frame: lf_foot, baumgarte: {") + gains + "}}");
  };
  EXPECT_EQ(warnings(with("kd: 99")), "");
  EXPECT_EQ(warnings(with("kp: 2000, kd: 50")), "");
  EXPECT_EQ(warnings(with("kd: 101")),
            "4:35: the contact 'LF' is stabilized more stiffly (kp 0 1/s², kd 101 1/s) than the "
            "time step 0.02 s of phase 'stand' carries: errors grow (kd up to 100 is stable with "
            "this step)\n");
  EXPECT_EQ(warnings(with("kp: 6000, kd: 50")),
            "4:35: the contact 'LF' is stabilized more stiffly (kp 6000 1/s², kd 50 1/s) than the "
            "time step 0.02 s of phase 'stand' carries: errors grow (lower kp and kd, or take "
            "smaller steps)\n");
  // A phase without the contact is irrelevant.
  EXPECT_EQ(warnings(replaced(replaced(with("kd: 150"), "knots: 5, dt: 0.02, contacts: all}\n  - ",
                                       "knots: 5, dt: 0.01, contacts: all}\n  - "),
                              "knots: 5, dt: 0.02, contacts: all}\ncosts",
                              "knots: 5, dt: 0.01, contacts: all}\ncosts"))
                .substr(0, 40),
            "4:35: the contact 'LF' is stabilized mor");
  EXPECT_EQ(warnings(replaced(
                replaced(replaced(with("kd: 150"), "knots: 5, dt: 0.02, contacts: all}\n  - ",
                                  "knots: 5, dt: 0.01, contacts: all}\n  - "),
                         "knots: 5, dt: 0.02, contacts: all}\ncosts",
                         "knots: 5, dt: 0.01, contacts: all}\ncosts"),
                "contacts: [LF, LH, RH]", "contacts: [LH, RH]")),
            "");
}

TEST(QuasiStatic, ReportsClampedControls) {
  const std::string heavy = replaced(
      replaced(kStepping, "base: floating}", "base: floating, payloads: {trunk: {mass: 300}}}"),
      "initial_guess", "constraints: {torque: {bounds: control, from: urdf}}\ninitial_guess");
  const Loaded loaded(heavy);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::string said = warnings(heavy);
  EXPECT_TRUE(
      said.starts_with("20:27: to hold the guessed states the controls would have to leave "
                       "their limits in 20 of 20 knots"))
      << said;
  const ShootingProblem& problem = *loaded.built->problem;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) {
      EXPECT_LE(loaded.built->guess.u(k)[i], problem.knot(k).model->control_upper()[i]);
      EXPECT_GE(loaded.built->guess.u(k)[i], problem.knot(k).model->control_lower()[i]);
    }
}

}  // namespace
}  // namespace conddp
