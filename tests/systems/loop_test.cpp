// Accelerations of robots with loops, compared with numbers from Pinocchio's kinematics and
// inertias (scripts/peers/loop_fixtures.py).
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "robot/urdf/urdf.hpp"
#include "support/random_numbers.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

using nlohmann::json;

/// A generalized force on every degree of freedom, also of the base.
Actuation all_forces(const RobotModel& model) {
  Actuation all{.nu = model.nv, .B = std::vector<double>(model.nv * model.nv, 0.0)};
  for (int i = 0; i < model.nv; ++i) {
    all.B[i * (model.nv + 1)] = 1;
    all.columns.push_back({"u/" + std::to_string(i), "Nm"});
    all.lower.push_back(-kUnlimited);
    all.upper.push_back(kUnlimited);
  }
  return all;
}

Contact loop_of(const json& loop, const RobotModel& model) {
  const std::string kind = loop["kind"];
  return {.name = "loop",
          .frame = model.find_frame(loop["frame"].get<std::string>()).value(),
          .base = model.find_frame(loop["on"].get<std::string>()).value(),
          .kind = kind == "planar"  ? ContactKind::planar
                  : kind == "point" ? ContactKind::point
                                    : ContactKind::surface};
}

TEST(Loops, AccelerationsAgreeWithPinocchio) {
  std::ifstream file(source_tree() / "tests/systems/data/loops.json");
  const json fixture = json::parse(file);
  ASSERT_EQ(fixture["robots"].size(), 5U);
  for (const json& robot : fixture["robots"]) {
    const std::string name = robot["urdf"];
    SCOPED_TRACE(name);
    UrdfOptions options;
    if (robot["base"] == "floating") options.base = UrdfOptions::Base::floating;
    const UrdfResult loaded =
        load_urdf(source_tree() / "problems/robots" / (name + ".urdf"), options);
    ASSERT_TRUE(loaded.model);
    const auto model = std::make_shared<RobotModel>(*loaded.model);
    std::vector<Contact> loops;
    for (const json& loop : robot["loops"]) loops.push_back(loop_of(loop, *model));
    const MultibodySystem system(model, all_forces(*model), {}, loops);
    const auto data = system.create_data(double{});
    for (const json& state : robot["states"]) {
      std::vector<double> x = state["q"];
      const std::vector<double> v = state["v"], tau = state["tau"], a = state["a"];
      x.insert(x.end(), v.begin(), v.end());
      system.evaluate(x.data(), tau.data(), *data);
      double size = 0;
      for (const double entry : a) size = std::max(size, std::abs(entry));
      ASSERT_EQ(a.size(), data->f.size());
      for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(data->f[i], a[i], 1e-9 * size);
    }
  }
}

/// Derivatives of accelerations, compared with dual numbers, also of robots with few joints.
TEST(Loops, DerivativesOfAFiveBarLegMatchDuals) {
  const UrdfResult loaded = load_urdf(source_tree() / "problems/robots/five_bar_leg.urdf", {});
  ASSERT_TRUE(loaded.model);
  const auto model = std::make_shared<RobotModel>(*loaded.model);
  const MultibodySystem system(model, Actuation::joints(*model, {"hip_a", "hip_b"}), {},
                               {{.name = "ankle",
                                 .frame = model->find_frame("foot").value(),
                                 .base = model->find_frame("foot_b").value(),
                                 .kind = ContactKind::planar,
                                 .kp = 100,
                                 .kd = 20}});
  const auto data = system.create_data(Lane{});
  const auto moving = system.create_data(Dual<Lane>{});
  RandomNumbers random(3);
  std::vector<double> x(system.nx()), u(system.nu());
  AlignedVector<Lane> at, by;
  for (int twice = 0; twice < 2; ++twice) {  // nothing of the first state stays
    for (double& entry : x) entry = random.uniform(-1, 1);
    for (double& entry : u) entry = random.uniform(-5, 5);
    at.assign(x.begin(), x.end());
    by.assign(u.begin(), u.end());
    system.differentiate(at.data(), by.data(), *data);
  }
  for (int d = 0; d < system.nx(); ++d) {
    AlignedVector<Dual<Lane>> xd(x.begin(), x.end()), ud(u.begin(), u.end());
    xd[d].d = Lane(1.0);
    system.evaluate(xd.data(), ud.data(), *moving);
    for (int i = 0; i < system.nv(); ++i)
      EXPECT_NEAR(data->fx[d * system.nv() + i][0], moving->f[i].d[0], 1e-8) << i << " by " << d;
  }
}

}  // namespace
}  // namespace conddp
