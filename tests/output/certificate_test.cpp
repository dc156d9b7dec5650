// The certificate of an answer holds and fails after any change.
#include <functional>
#include <map>

#include <gtest/gtest.h>

#include "base/json/json_document.hpp"
#include "output/report/certificate_report.hpp"
#include "support/sizes.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

OrderedJson& knot(OrderedJson& rows) { return rows[rows.size() / 2]; }

/// A multiplier of a control bound: positive, or zero.
OrderedJson* bound_multiplier(OrderedJson& document, double least = 1e-9) {
  for (const char* kind : {"control_lower", "control_upper"})
    if (document["multipliers"].contains(kind))
      for (OrderedJson& row : document["multipliers"][kind])
        for (OrderedJson& entry : row)
          if (least > 0 ? entry.get<double>() > least : entry == 0) return &entry;
  return nullptr;
}

/// A way to corrupt an answer, and the check that must detect it. Returns false if the answer has
/// no such part.
struct Corruption {
  std::string name;
  std::string found_by;
  std::function<bool(OrderedJson&)> apply;
};

const std::vector<Corruption>& corruptions() {
  static const std::vector<Corruption> list = {
      {"the unit of time", "units of t",
       [](OrderedJson& d) {
         d["trajectory"]["units"]["t"] = "ms";
         return true;
       }},
      {"a control", "gap",
       [](OrderedJson& d) {
         add_to(knot(d["trajectory"]["u"])[0], 1e-6);
         return true;
       }},
      {"a state", "gap",
       [](OrderedJson& d) {
         add_to(knot(d["trajectory"]["x"])[0], 1e-8);
         return true;
       }},
      {"the initial state", "initial state",
       [](OrderedJson& d) {
         add_to(d["trajectory"]["x"][0][0], 1e-9);
         return true;
       }},
      {"the sign of a co-state", "co-states",
       [](OrderedJson& d) {
         for (OrderedJson& entry : knot(d["multipliers"]["costates"])) entry = -entry.get<double>();
         return true;
       }},
      {"one entry of a co-state", "co-states",
       [](OrderedJson& d) {
         add_to(knot(d["multipliers"]["costates"]).back(), 1e-5);
         return true;
       }},
      {"the gradient in a state", "co-states",
       [](OrderedJson& d) {
         add_to(knot(d["multipliers"]["state_gradient"])[0], 1e-5);
         return true;
       }},
      {"the sign of a bound's multiplier", "signs of multipliers",
       [](OrderedJson& d) {
         OrderedJson* entry = bound_multiplier(d);
         if (entry == nullptr) return false;
         *entry = -entry->get<double>();
         return true;
       }},
      {"a multiplier of a bound that is not met", "complementarity",
       [](OrderedJson& d) {
         OrderedJson* entry = bound_multiplier(d, 0);
         if (entry == nullptr) return false;
         *entry = 1;
         return true;
       }},
      {"the cost", "cost",
       [](OrderedJson& d) {
         d["cost"] = d["cost"].get<double>() * (1 + 1e-8);
         return true;
       }},
      {"no cost", "cost",
       [](OrderedJson& d) {
         d["cost"] = nullptr;
         return true;
       }},
      {"a cost by name", "cost ",
       [](OrderedJson& d) {
         OrderedJson& cost = d["cost_by_name"].front();
         cost = cost.get<double>() * 1.0001;
         return true;
       }},
      {"a cost's name", "cost another",
       [](OrderedJson& d) {
         d["cost_by_name"]["another"] = d["cost_by_name"].front();
         d["cost_by_name"].erase(d["cost_by_name"].begin());
         return true;
       }},
      {"a residual", "stationarity",
       [](OrderedJson& d) {
         add_to(d["residuals"]["stationarity"], 1e-8);
         return true;
       }},
      {"the violation", "constraint violation",
       [](OrderedJson& d) {
         d["residuals"]["constraint"] = 1e-7;
         return true;
       }},
      {"the status", "status",
       [](OrderedJson& d) {
         d["status"] = "max_iterations";
         return true;
       }},
      {"a time", "times",
       [](OrderedJson& d) {
         add_to(knot(d["trajectory"]["t"]), 1e-6);
         return true;
       }},
      {"a knot", "trajectory.x",
       [](OrderedJson& d) {
         for (const char* kind : {"t", "x", "u"})
           d["trajectory"][kind].erase(d["trajectory"][kind].size() / 2);
         return true;
       }},
      {"an entry of a row", "trajectory.u",
       [](OrderedJson& d) {
         OrderedJson& rows = d["trajectory"]["u"];
         rows[1].erase(0);
         return true;
       }},
      {"the names of two columns", "columns of x",
       [](OrderedJson& d) {
         OrderedJson& names = d["trajectory"]["columns"]["x"];
         std::swap(names[0], names[1]);
         return true;
       }},
      {"the numbers of two columns", "gap",
       [](OrderedJson& d) {
         for (OrderedJson& row : d["trajectory"]["x"])
           std::swap(row[row.size() - 2], row[row.size() - 1]);
         return true;
       }},
      {"a phase", "phases",
       [](OrderedJson& d) {
         d["trajectory"]["phases"][0]["name"] = "other";
         return true;
       }},
      {"a tolerance", "options",
       [](OrderedJson& d) {
         d["problem"]["options"]["tolerances"]["stationarity"] = 1;
         return true;
       }},
      {"the solver", "solver",
       [](OrderedJson& d) {
         d["solver"] = d["solver"] == "ddp" ? "ilqr" : "ddp";
         return true;
       }},
      {"the iterations", "iterations",
       [](OrderedJson& d) {
         d["iterations"] = d["iterations"].get<int>() + 1;
         return true;
       }},
      {"the last row of the log", "cost in the log",
       [](OrderedJson& d) {
         add_to(d["log"].back()["cost"], 1e-3);
         return true;
       }},
      {"a quaternion", "unit quaternions",
       [](OrderedJson& d) {
         const OrderedJson& names = d["trajectory"]["columns"]["x"];
         for (std::size_t i = 0; i < names.size(); ++i)
           if (names[i].get<std::string>().ends_with("/qw")) {
             for (std::size_t j = i - 3; j <= i; ++j)
               knot(d["trajectory"]["x"])[j] = knot(d["trajectory"]["x"])[j].get<double>() * 1.001;
             return true;
           }
         return false;
       }},
      {"the figure of a finding", "findings",
       [](OrderedJson& d) {
         if (d["findings"].empty()) return false;
         OrderedJson& value = d["findings"].front()["value"];
         value = value.get<double>() * 1.0001;
         return true;
       }},
      {"a finding more", "findings",
       [](OrderedJson& d) {
         d["findings"].push_back({{"kind", "drift"}, {"subject", "nothing"}, {"value", 1.0}});
         return true;
       }},
      {"a gain", "feedback",
       [](OrderedJson& d) {
         add_to(knot(d["gains"]["K"])[0].back(), 1);
         return true;
       }},
      {"a feedforward", "feedforward",
       [](OrderedJson& d) {
         add_to(knot(d["gains"]["k"])[0], 1e-3);
         return true;
       }},
      {"the duration", "duration",
       [](OrderedJson& d) {
         add_to(d["problem"]["duration_s"], 1e-6);
         return true;
       }},
      {"a row of the log", "rows of the log",
       [](OrderedJson& d) {
         d["log"][1]["iteration"] = 7000;
         return true;
       }},
      {"a contact force", "force of ",
       [](OrderedJson& d) {
         for (OrderedJson& rows : d["trajectory"]["contact_forces"])
           for (OrderedJson& row : rows)
             if (row.is_array()) {
               add_to(row[0], 1e-3);
               return true;
             }
         return false;
       }},
      {"when a contact is held", "force of ",
       [](OrderedJson& d) {
         for (OrderedJson& rows : d["trajectory"]["contact_forces"])
           for (OrderedJson& row : rows)
             if (row.is_array()) {
               row = nullptr;
               return true;
             }
         return false;
       }},
  };
  return list;
}

/// Corruptions without an object in this answer; other answers cover them.
std::string without_corruptions(const std::string& problem) {
  const std::string pose = "[a quaternion]", contacts = "[a contact force][when a contact is held]";
  const std::string finding = "[the figure of a finding]";
  if (problem == "pendulum_swingup" || problem == "double_pendulum_swingup")
    return pose + finding + contacts;
  const std::string bound = "[the sign of a bound's multiplier]";
  if (problem == "quadrotor_waypoints") return bound + pose + finding + contacts;
  if (problem == "body_reorient") return contacts;
  return problem == "hopper_jump" ? pose : bound;
}

class CertificateOf : public testing::TestWithParam<std::string> {};

TEST_P(CertificateOf, HoldsForAnAnswerButNotForChanges) {
  const SolvedExample answer(GetParam());
  const SolutionCertificate good = answer.judge(answer.document);
  EXPECT_TRUE(good.checks.holds()) << certificate_table(good.checks);
  std::string skipped;
  for (const Corruption& corruption : corruptions()) {
    OrderedJson changed = answer.document;
    if (!corruption.apply(changed)) {
      skipped += "[" + corruption.name + "]";
      continue;
    }
    const SolutionCertificate certificate = answer.judge(changed);
    EXPECT_NE(failures(certificate).find("[" + corruption.found_by), std::string::npos)
        << corruption.name << ": " << failures(certificate);
  }
  EXPECT_EQ(skipped, without_corruptions(GetParam()));
}

// A closed form with active bounds, URDF pendulums, poses in SE(3), an impact of a planar hopper,
// and impacts of four feet.
std::vector<std::string> certified_problems() {
  std::vector<std::string> names = {"pendulum_swingup", "double_pendulum_swingup", "body_reorient",
                                    "quadrotor_waypoints", "hopper_jump"};
  if (!kSmallSizes) names.push_back("quadruped_bound");
  return names;
}

INSTANTIATE_TEST_SUITE_P(Problems, CertificateOf, testing::ValuesIn(certified_problems()),
                         [](const auto& name) { return name.param; });

TEST(Certificate, KnowsChoiceAndLinkOfPeriodicMotions) {
  const SolvedExample own("pendulum_cycle");
  const SolutionCertificate good = own.judge(own.document);
  EXPECT_TRUE(good.checks.holds()) << certificate_table(good.checks);
  OrderedJson changed = own.document;
  add_to(changed["trajectory"]["u"][0][0], 1e-6);
  EXPECT_NE(failures(own.judge(changed)).find("[gap]"), std::string::npos) << "the choice";
  changed = own.document;
  for (OrderedJson& entry : changed["multipliers"]["constraints"])
    if (entry["name"] == "cycle") add_to(entry["multiplier"][1], 1e-4);
  ASSERT_NE(changed, own.document);
  EXPECT_NE(failures(own.judge(changed)).find("[co-states]"), std::string::npos)
      << "its multiplier";
  const SolvedExample further("pendulum_cycle", {"terminal.constraints.cycle.offset={theta: 0.001}",
                                                 "solver.max_iterations=1"});
  EXPECT_NE(failures(further.judge(own.document)).find("[constraint violation]"),
            std::string::npos);
}

TEST(Certificate, RejectsAnotherRobot) {
  const SolvedExample own("cartpole_swingup", {"solver.max_iterations=3"});
  const SolvedExample other("cartpole_swingup",
                            {"robot.payloads={pole: {mass: 0.01}}", "solver.max_iterations=1"});
  EXPECT_NE(failures(other.judge(own.document)).find("[gap]"), std::string::npos);
}

TEST(Certificate, RejectsAnotherStep) {
  const SolvedExample own("cartpole_swingup", {"solver.max_iterations=3"});
  const SolvedExample other("cartpole_swingup", {"phases.0.dt=0.0301", "solver.max_iterations=1"});
  const std::string found = failures(other.judge(own.document));
  for (const char* check : {"[times]", "[gap]", "[cost]"})
    EXPECT_NE(found.find(check), std::string::npos) << check << found;
}

/// The claims of an unconverged answer hold too.
TEST(Certificate, HoldsForUnconvergedAnswers) {
  for (const std::string solver : {"ilqr", "ilqr_clip", "ddp", "box_ddp", "fddp", "box_fddp"})
    for (const std::string& iterations :
         kSmallSizes ? std::vector<std::string>{"1"} : std::vector<std::string>{"0", "1", "4"})
      for (const std::string problem :
           {"cartpole_swingup", "quadrotor_waypoints", "hopper_jump", "quadruped_jump"}) {
        if (problem == "quadruped_jump" && solver != "box_fddp") continue;  // the largest
        BuildOptions options;
        const bool bounds = solver.find("box") == 0 || solver == "ilqr_clip";
        if (!bounds)
          options.drop = {problem == "cartpole_swingup"      ? "force"
                          : problem == "quadrotor_waypoints" ? "thrust"
                                                             : "torque"};
        const SolvedExample answer(
            problem, {"solver={name: " + solver + ", max_iterations: " + iterations + "}"},
            options);
        EXPECT_NE(answer.document["status"], "converged");
        const SolutionCertificate certificate = answer.judge(answer.document);
        EXPECT_TRUE(certificate.checks.holds())
            << problem << " " << solver << " " << iterations << "\n"
            << certificate_table(certificate.checks);
      }
}

/// Far from any answer, the last digits of costs and gradients are meaningless.
TEST(Certificate, HoldsForBadlyConditionedIterates) {
  for (const std::string solver : {"ilqr_clip", "box_ddp", "box_fddp"})
    for (const std::string& seed :
         kSmallSizes ? std::vector<std::string>{"1"} : std::vector<std::string>{"1", "2", "3"})
      for (const std::string problem : {"arm_reach", "hopper_jump", "quadrotor_waypoints"}) {
        const SolvedExample answer(
            problem, {"solver={name: " + solver + ", max_iterations: 1}",
                      "initial_guess.controls={random: {seed: " + seed + ", scale: 30}}"});
        const SolutionCertificate certificate = answer.judge(answer.document);
        EXPECT_TRUE(certificate.checks.holds()) << problem << " " << solver << " " << seed << "\n"
                                                << certificate_table(certificate.checks);
      }
}

TEST(Certificate, FindsAHiddenGap) {
  SolvedExample answer("cartpole_swingup",
                       {"solver={name: box_fddp, max_iterations: 0}",
                        "initial_guess.states={keyframes: [{time: 3, state: up}]}",
                        "robot.configurations={up: {joints: {hinge: 3.14}}}"});
  ASSERT_GT(answer.document["residuals"]["gap"].get<double>(), 1e-6)
      << "the answer should have a gap";
  EXPECT_TRUE(answer.judge(answer.document).checks.holds());
  answer.document["residuals"]["gap"] = 0;
  EXPECT_EQ(failures(answer.judge(answer.document)), "[gap][gap in the log]");
}

TEST(Certificate, RejectsAStatusThatIsTooGood) {
  SolvedExample answer("cartpole_swingup", {"solver.max_iterations=3"});
  ASSERT_EQ(answer.document["status"], "max_iterations");
  answer.document["status"] = "converged";
  EXPECT_EQ(failures(answer.judge(answer.document)), "[status]");
}

/// Claims that agree with each other but not with the problem.
TEST(Certificate, RejectsResidualsThatAreTooGood) {
  SolvedExample answer("cartpole_swingup", {"solver.max_iterations=3"});
  answer.document["status"] = "converged";
  answer.document["residuals"] = {
      {"stationarity", 0}, {"gap", 0}, {"constraint", 0}, {"complementarity", 0}};
  const std::string found = failures(answer.judge(answer.document));
  EXPECT_NE(found.find("[stationarity]"), std::string::npos) << found;
  EXPECT_NE(found.find("[status]"), std::string::npos) << found;
}

TEST(Certificate, KnowsDroppedConstraints) {
  SolvedExample answer("arm_reach", {"solver.name=fddp"}, {.drop = {"torque"}});
  EXPECT_TRUE(answer.judge(answer.document).checks.holds());
  add_to(answer.document["dropped_constraints"][0]["violation"], -1e-3);
  EXPECT_EQ(failures(answer.judge(answer.document)), "[violation of dropped torque]");
}

TEST(Certificate, RejectsDocumentsWithoutKeys) {
  const SolvedExample answer("pendulum_swingup");
  for (const char* key : {"problem", "status", "cost", "residuals", "trajectory", "multipliers",
                          "gains", "log", "dropped_constraints"}) {
    OrderedJson changed = answer.document;
    changed.erase(key);
    EXPECT_THROW(answer.judge(changed), MalformedSolution) << key;
  }
}

TEST(Certificate, DivergedSolveMakesNoFalseClaim) {
  const SolvedExample answer("acrobot_swingup",
                             {"initial_guess.controls={constant: 1.0e+200}", "solver.name=ilqr"},
                             {.drop = {"torque"}});
  EXPECT_EQ(answer.document["status"], "diverged");
  const SolutionCertificate certificate = answer.judge(answer.document);
  EXPECT_TRUE(certificate.checks.holds()) << certificate_table(certificate.checks);
}

}  // namespace
}  // namespace conddp
