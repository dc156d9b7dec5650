#include <algorithm>
#include <thread>

#include <console_bridge/console.h>
#include <gtest/gtest.h>

#include "robot/urdf/urdf.hpp"
#include "support/temporary_folder.hpp"
#include "urdf_text.hpp"

namespace conddp {
namespace {

/// Link "arm" on link "base" by a continuous joint "j" with additional content.
std::string one_joint(const std::string& content, const std::string& type = "continuous") {
  return robot_element(link_element("base") + link_element("arm") +
                       joint_element("j", type, "base", "arm", content));
}
std::string inertial(const std::string& mass, const std::string& moments) {
  return "<inertial><mass value=\"" + mass + "\"/><inertia " + moments + "/></inertial>";
}
std::string with_arm(const std::string& content) {
  return robot_element(link_element("base") + link_element("arm", content) +
                       joint_element("j", "continuous", "base", "arm"));
}

struct Rejection {
  const char* name;
  std::string xml;
  std::string element;
  std::string fragment;  ///< of the message
  int line = 0;          ///< 0: anywhere
  UrdfOptions options = {};
};

UrdfOptions with(void (*change)(UrdfOptions&)) {
  UrdfOptions options;
  change(options);
  return options;
}

std::vector<Rejection> rejections() {
  const std::string diagonal = R"(ixy="0" ixz="0" iyz="0" )";
  return {
      {"empty", " \n", "", "'robot.urdf' is empty"},
      {"latin1", "<robot name=\"r\">\n<!-- \xE9 -->\n</robot>", "", "not UTF-8", 2},
      {"nul", std::string("<robot name=\"r\">\0</robot>", 25), "", "control character (0x00)"},
      {"text_only", "hello", "", "not well-formed XML"},
      {"unclosed", "<robot name=\"r\">\n<link name=\"a\">", "", "<link> is never closed", 2},
      {"crossed", "<robot name=\"r\">\n<link>\n</joint></robot>", "", "</joint> where <link>", 3},
      {"two_roots", "<robot name=\"r\"/>\n<robot name=\"s\"/>", "", "second root", 2},
      {"unquoted", "<robot name=r/>", "", "not quoted"},
      {"attribute_twice", robot_element("<link name=\"a\" name=\"b\"/>"), "", "given twice", 2},
      {"open_declaration", "<?xml version=\"1.0\"", "", "never closed"},
      {"entities", "<!DOCTYPE r [<!ENTITY a \"b\">]><robot name=\"r\"/>", "", "document type"},
      {"sdf", "<sdf version=\"1.6\"><model/></sdf>", "", "root element is <sdf>"},
      {"xacro_element", robot_element("<xacro:arm name=\"a\"/>"), "", "xacro file", 2},
      {"xacro_in_a_link", robot_element(link_element("a", "<xacro:body/>")), "", "xacro file", 2},
      {"xacro_expression", robot_element("\n<link name=\"${side}_arm\"/>"), "", "xacro file", 3},
      {"robot_without_name", "<robot><link name=\"a\"/></robot>", "", "has no name"},
      {"no_links", robot_element(""), "", "no links"},
      {"link_without_name", robot_element("<link/>"), "", "a link has no name", 2},
      {"name_with_comma", robot_element(link_element("a,b")), "a,b", "a name may not hold"},
      {"link_twice", robot_element(link_element("a") + link_element("a")), "a",
       "a second link of this name", 3},
      {"joint_twice",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "fixed", "a", "b") + joint_element("j", "fixed", "a", "c")),
       "j", "a second joint of this name", 6},
      {"link_in_link", robot_element(link_element("a", link_element("b"))), "a",
       "<link> stands inside <link>"},
      {"unknown_type", one_joint("", "revolut"), "j", "unknown type 'revolut'"},
      {"no_type",
       robot_element(link_element("a") + "<joint name=\"j\"><parent link=\"a\"/></joint>"), "j",
       "has no type"},
      {"no_parent",
       robot_element(link_element("a") + link_element("b") +
                     "<joint name=\"j\" type=\"fixed\">\n<child link=\"b\"/></joint>"),
       "j", "has no parent link", 4},
      {"parent_missing",
       robot_element(link_element("base") + link_element("arm") +
                     joint_element("j", "fixed", "bsae", "arm")),
       "j", "parent link 'bsae' does not exist", 4},
      {"child_missing",
       robot_element(link_element("base") + joint_element("j", "fixed", "base", "arm")), "j",
       "child link 'arm' does not exist"},
      {"own_parent", robot_element(link_element("a") + joint_element("j", "fixed", "a", "a")), "j",
       "parent and child"},
      {"two_parents",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "fixed", "a", "c") + joint_element("k", "fixed", "b", "c")),
       "c", "two parents, through joints 'j' and 'k'", 6},
      {"detached_part",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "fixed", "a", "b")),
       "c", "2 separate parts, with the root links a, c", 4},
      {"detached_loop",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "fixed", "b", "c") + joint_element("k", "fixed", "c", "b")),
       "b", "form a loop"},
      {"loop",
       robot_element(link_element("a") + link_element("b") + joint_element("j", "fixed", "a", "b") +
                     joint_element("k", "fixed", "b", "a")),
       "a", "form a loop"},
      {"mass_not_a_number", with_arm(inertial("1kg", "")), "arm", "<mass> value: '1kg' is not"},
      {"mass_nan", with_arm(inertial("nan", "")), "arm", "'nan' is not a finite number"},
      {"mass_overflow", with_arm(inertial("1e400", "")), "arm", "'1e400' is not a finite number"},
      {"printf_format", with_arm(inertial("%n%s", "")), "arm", "'%n%s' is not a number"},
      {"two_numbers", one_joint("<axis xyz=\"0 1\"/>"), "j", "<axis> xyz: has 2 numbers"},
      {"inertia_missing", with_arm("<inertial><mass value=\"1\"/></inertial>"), "arm",
       "urdfdom: Inertial element must have inertia element"},
      {"inertia_incomplete", with_arm(inertial("1", "ixx=\"1\"")), "arm", "urdfdom: "},
      {"negative_mass", with_arm(inertial("-1", diagonal + R"(ixx="1" iyy="1" izz="1")")), "arm",
       "mass is -1 kg"},
      {"negative_inertia", with_arm(inertial("1", diagonal + R"(ixx="1" iyy="1" izz="-1")")), "arm",
       "not positive semidefinite", 3,
       with([](UrdfOptions& o) { o.inertias = UrdfOptions::Inertias::strict; })},
      {"indefinite_inertia",
       with_arm(inertial("1", R"(ixx="1" iyy="1" izz="1" ixy="2" ixz="0" iyz="0")")), "arm",
       "not positive semidefinite", 0,
       with([](UrdfOptions& o) { o.inertias = UrdfOptions::Inertias::strict; })},
      {"negative_along_the_joint",
       with_arm(inertial("1", diagonal + R"(ixx="-1" iyy="1" izz="1")")), "j",
       "inertia matrix is not positive definite", 4},
      {"triangle", with_arm(inertial("1", diagonal + R"(ixx="1" iyy="1" izz="3")")), "arm",
       "exceeds the sum of the others", 0,
       with([](UrdfOptions& o) { o.inertias = UrdfOptions::Inertias::strict; })},
      {"inertia_overflows",
       with_arm("<inertial><origin xyz=\"1e200 0 0\"/><mass value=\"1e200\"/>"
                "<inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
                "izz=\"1\"/></inertial>"),
       "j", "overflows"},
      {"second_inertial", with_arm(std::string(kBody) + kBody), "arm", "a second <inertial>"},
      {"second_origin", one_joint("<origin/><origin/>"), "j", "a second <origin>"},
      {"origin_quaternion", one_joint("<origin xyz=\"0 0 0\" quat_xyzw=\"0 0 0 1\"/>"), "j",
       "attribute quat_xyzw"},
      {"zero_axis", one_joint("<axis xyz=\"0 0 0\"/>"), "j", "axis is zero", 4},
      {"axis_without_xyz", one_joint("<axis/>"), "j", "axis is zero"},
      {"revolute_without_limit", one_joint("", "revolute"), "j", "does not specify limits"},
      {"prismatic_without_limit", one_joint("", "prismatic"), "j", "without limits"},
      {"limit_without_effort", one_joint("<limit lower=\"0\" upper=\"1\"/>", "revolute"), "j",
       "no effort"},
      {"limits_crossed",
       one_joint("<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>", "revolute"), "j",
       "lower limit 1 is above the upper -1"},
      {"negative_effort", one_joint("<limit effort=\"-5\" velocity=\"1\"/>"), "j",
       "effort limit is -5 Nm"},
      {"negative_velocity", one_joint("<limit effort=\"5\" velocity=\"-1\"/>"), "j",
       "velocity limit is -1"},
      {"negative_damping", one_joint("<dynamics damping=\"-1\"/>"), "j", "negative"},
      {"mimics_itself", one_joint("<mimic joint=\"j\"/>"), "j", "mimics itself", 0,
       with([](UrdfOptions& o) { o.enforce_mimic = true; })},
      {"mimics_missing", one_joint("<mimic joint=\"k\"/>"), "j", "'k', which does not exist", 0,
       with([](UrdfOptions& o) { o.enforce_mimic = true; })},
      {"mimic_cycle",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "continuous", "a", "b", "<mimic joint=\"k\"/>") +
                     joint_element("k", "continuous", "b", "c", "<mimic joint=\"j\"/>")),
       "j", "cycle", 0, with([](UrdfOptions& o) { o.enforce_mimic = true; })},
      {"floating_in_the_middle",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "continuous", "a", "b") +
                     joint_element("k", "floating", "b", "c")),
       "k", "supported only if its parent is the root link"},
      {"planar_in_the_middle",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "continuous", "a", "b") +
                     joint_element("k", "planar", "b", "c")),
       "k", "here the parent moves with joint 'j'"},
      {"base_twice",
       robot_element(link_element("a") + link_element("b") +
                     joint_element("k", "floating", "a", "b")),
       "k", "a floating joint of its own", 0,
       with([](UrdfOptions& o) { o.base = UrdfOptions::Base::floating; })},
      {"massless_leaf", with_arm(""), "j", "no link that it moves (arm) has inertia"},
      {"massless_between_parallel_axes",
       robot_element(link_element("a") + link_element("b", "") + link_element("c") +
                     joint_element("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>") +
                     joint_element("k", "continuous", "b", "c", "<axis xyz=\"0 1 0\"/>")),
       "j", "inertia matrix is singular"},
      {"point_on_its_axis", with_arm(inertial("1", diagonal + R"(ixx="0" iyy="0" izz="0")")), "j",
       "inertia matrix is singular"},
      {"floating_point",
       robot_element(link_element("a", inertial("1", diagonal + R"(ixx="0" iyy="0" izz="0")"))),
       "base", "inertia matrix is singular", 0,
       with([](UrdfOptions& o) { o.base = UrdfOptions::Base::floating; })},
      {"lock_unknown", one_joint(""), "jj", "no such joint", 0,
       with([](UrdfOptions& o) { o.locked_joints["jj"] = 0; })},
      {"lock_fixed", one_joint("", "fixed"), "j", "a fixed joint is not one", 4,
       with([](UrdfOptions& o) { o.locked_joints["j"] = 0; })},
      {"lock_outside",
       one_joint("<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>", "revolute"), "j",
       "locked at 2, outside its limits -1 to 1", 4,
       with([](UrdfOptions& o) { o.locked_joints["j"] = 2; })},
      {"lock_nan", one_joint(""), "j", "not finite", 4,
       with([](UrdfOptions& o) { o.locked_joints["j"] = std::nan(""); })},
      {"payload_nowhere", one_joint(""), "amr", "no such link", 0,
       with([](UrdfOptions& o) { o.payloads.push_back({.link = "amr", .mass = 1}); })},
      {"payload_negative", one_joint(""), "arm", "payload's mass -1", 3,
       with([](UrdfOptions& o) { o.payloads.push_back({.link = "arm", .mass = -1}); })},
      {"payload_impossible", one_joint(""), "arm", "payload's inertia", 3, with([](UrdfOptions& o) {
         o.payloads.push_back(
             {.link = "arm", .mass = 1, .inertia = Symmetric3<double>{1, 0, 0, 1, 0, 3}});
       })},
      {"rotor_unknown", one_joint(""), "i", "no such joint", 0,
       with([](UrdfOptions& o) { o.rotor_inertia["i"] = 1; })},
      {"rotor_negative", one_joint(""), "j", "rotor inertia -1", 4,
       with([](UrdfOptions& o) { o.rotor_inertia["j"] = -1; })},
      {"leader_fixed",
       robot_element(link_element("a") + link_element("b") + link_element("c") +
                     joint_element("j", "fixed", "a", "b") +
                     joint_element("k", "continuous", "b", "c",
                                   "<mimic joint=\"j\" multiplier=\"2\" offset=\"1\"/>")),
       "k", "mimics joint 'j', which has no coordinate", 0,
       with([](UrdfOptions& o) { o.enforce_mimic = true; })},
      {"locked_pattern_fits_none", one_joint(""), "finger_*", "fits none of the joints that move",
       0, with([](UrdfOptions& o) { o.locked_joints["finger_*"] = 0; })},
      {"locked_pattern_outside_limits",
       one_joint(R"(<limit lower="1" upper="2" effort="1" velocity="1"/>)", "revolute"), "j",
       "to be locked at 0, outside its limits 1 to 2", 0,
       with([](UrdfOptions& o) { o.locked_joints["*"] = 0; })},
  };
}

class UrdfRejection : public testing::TestWithParam<Rejection> {};

TEST_P(UrdfRejection, IsAnErrorThatNamesItsPlace) {
  const Rejection& expected = GetParam();
  const UrdfResult result = parse_urdf(expected.xml, "robot.urdf", expected.options);
  EXPECT_FALSE(result.model);
  std::string messages;
  const bool found =
      std::any_of(result.problems.begin(), result.problems.end(), [&](const UrdfProblem& problem) {
        messages +=
            std::to_string(problem.line) + " [" + problem.element + "] " + problem.message + "\n";
        return !problem.warning && problem.element == expected.element &&
               problem.message.find(expected.fragment) != std::string::npos &&
               (expected.line == 0 || problem.line == expected.line);
      });
  EXPECT_TRUE(found) << "expected " << expected.line << " [" << expected.element << "] "
                     << expected.fragment << "\n"
                     << messages;
}

INSTANTIATE_TEST_SUITE_P(Cases, UrdfRejection, testing::ValuesIn(rejections()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(UrdfCharacters, OnlyOtherEncodingsGetAHint) {
  const auto first_problem = [](const std::string& xml) {
    const UrdfResult result = parse_urdf(xml, "robot.urdf");
    return result.problems.empty() ? UrdfProblem{} : result.problems.front();
  };
  const UrdfProblem latin = first_problem("<robot>\n<!-- \xE9 -->\n</robot>");
  EXPECT_EQ(latin.column, 6);
  EXPECT_NE(latin.hint.find("iconv"), std::string::npos);
  const UrdfProblem control = first_problem("<robot>\n<!-- \x01\xC3\xA9 -->\n</robot>");
  EXPECT_EQ(control.column, 6);
  EXPECT_EQ(control.hint, "");
}

TEST(UrdfNames, RobotNameErrorsNameNoLinkOrJoint) {
  const UrdfResult result =
      parse_urdf("<robot name=\"a,b\">" + link_element("base") + "</robot>", "robot.urdf");
  ASSERT_FALSE(result.problems.empty());
  EXPECT_TRUE(result.problems[0].message.starts_with("a name may not hold"))
      << result.problems[0].message;
}

std::string joined_hints(const UrdfResult& result) {
  std::string hints;
  for (const UrdfProblem& problem : result.problems) hints += problem.hint + "\n";
  return hints;
}

TEST(UrdfHints, SuggestNamesForMisspeltOnes) {
  EXPECT_NE(joined_hints(parse_urdf(robot_element(link_element("base") + link_element("arm") +
                                                  joint_element("j", "fixed", "bsae", "arm")),
                                    "f"))
                .find("did you mean 'base'?"),
            std::string::npos);
  UrdfOptions options;
  options.locked_joints["elbow"] = 0;
  EXPECT_NE(joined_hints(parse_urdf(one_joint(""), "f", options)).find("joints: j"),
            std::string::npos);
}

TEST(UrdfHints, MimicOfFixedJointSuggestsTheLockValue) {
  UrdfOptions options;
  options.enforce_mimic = true;
  const UrdfResult result =
      parse_urdf(robot_element(link_element("a") + link_element("b") + link_element("c") +
                               joint_element("j", "fixed", "a", "b") +
                               joint_element("k", "continuous", "b", "c",
                                             "<mimic joint=\"j\" multiplier=\"2\" offset=\"1\"/>")),
                 "f", options);
  EXPECT_NE(joined_hints(result).find("lock it, at 1"), std::string::npos);
}

TEST(UrdfFile, MustBeARegularFileOfModestSize) {
  const auto message = [](const std::filesystem::path& path) {
    const UrdfResult result = load_urdf(path);
    EXPECT_FALSE(result.model);
    return result.problems.empty() ? "" : result.problems[0].message;
  };
  EXPECT_NE(message("/nonexistent/robot.urdf").find("does not exist"), std::string::npos);
  EXPECT_NE(message("/tmp").find("is a folder"), std::string::npos);
  EXPECT_NE(message("/dev/zero").find("is not a regular file"), std::string::npos);
  const TemporaryFolder folder;
  const std::string large =
      folder.write("large.urdf", robot_element(link_element("a") + std::string(17 << 20, ' ')));
  EXPECT_NE(message(large).find("larger than 16 MiB"), std::string::npos);
}

TEST(UrdfFile, DeepNestingAndLongChainsDoNotOverflow) {
  std::string nested;
  for (int i = 0; i < 200'000; ++i) nested += "<a>";
  EXPECT_NE(
      parse_urdf(robot_element(nested), "f").problems.at(0).message.find("nested deeper than 64"),
      std::string::npos);
  const auto chain = [](int links) {
    std::string text = link_element("l0");
    for (int i = 1; i < links; ++i) {
      const std::string n = std::to_string(i);
      text += link_element("l" + n) +
              joint_element("j" + n, "continuous", "l" + std::to_string(i - 1), "l" + n);
    }
    return robot_element(text);
  };
  const UrdfResult longest = parse_urdf(chain(10'000), "f");
  ASSERT_TRUE(longest.model);
  EXPECT_EQ(longest.model->nv, 9'999);
  EXPECT_NE(parse_urdf(chain(10'001), "f").problems.at(0).message.find("more than 10000"),
            std::string::npos);
}

TEST(UrdfFile, UnreadPartsCannotFail) {
  const std::string visual =
      "<visual><geometry><mesh/></geometry><material name=\"%n\"/></visual>"
      "<collision><geometry><box size=\"%s%n\"/></geometry></collision>";
  const UrdfResult result = parse_urdf(
      robot_element("<material name=\"%n%s\"><color/></material>\n" + link_element("base", visual) +
                    link_element("arm") +
                    joint_element("j", "continuous", "base", "arm", "<safety_controller/>") +
                    "<gazebo><joint name=\"j\"/><mass value=\"x\"/></gazebo>"
                    "<transmission name=\"t\"><joint name=\"j\"/></transmission>"),
      "f");
  ASSERT_TRUE(result.model);
  EXPECT_TRUE(result.problems.empty());
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_EQ(result.notes[0],
            "not read: <collision>, <gazebo>, <material>, <safety_controller>, <transmission>, "
            "<visual>");
}

TEST(UrdfFile, ParallelReadsKeepTheLogHandler) {
  class Counter : public console_bridge::OutputHandler {
   public:
    void log(const std::string&, console_bridge::LogLevel, const char*, int) override { ++count; }
    int count = 0;
  };
  static Counter counter;
  console_bridge::OutputHandler* const before = console_bridge::getOutputHandler();
  console_bridge::useOutputHandler(&counter);
  std::vector<std::thread> threads;
  std::vector<int> good(4, 0);
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([t, &good] {
      for (int i = 0; i < 50; ++i) {
        const bool broken = (t + i) % 2 == 0;
        const UrdfResult result = parse_urdf(
            broken ? with_arm("<inertial><mass value=\"1\"/></inertial>") : one_joint(""), "f");
        good[t] += result.model.has_value() != broken && result.problems.size() == broken;
      }
    });
  for (std::thread& thread : threads) thread.join();
  for (const int count : good) EXPECT_EQ(count, 50);
  EXPECT_EQ(console_bridge::getOutputHandler(), &counter);
  EXPECT_EQ(counter.count, 0);
  console_bridge::useOutputHandler(before);
}

}  // namespace
}  // namespace conddp
