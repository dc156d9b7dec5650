#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "robot/urdf/regularity.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/simple_kinematics.hpp"
#include "urdf_text.hpp"

namespace conddp {
namespace {

/// Vendor URDFs: numbers that are not physically valid, and leftovers of their tools.

struct VendorLink {
  const char* name;
  const char* inertial;
  const char* warning;  ///< nullptr: no warning
};

/// Mass, center of mass, and inertia of links in public descriptions of these robots; the last
/// entry has digits rounded to 2e-6 of the largest moment.
const VendorLink kLinks[] = {
    {"icub_head",
     R"(<origin xyz="0.0185 -0.1108 6.78454e-18"/><mass value="1.33687"/>
        <inertia ixx="0" ixy="0" ixz="2.40741e-35" iyy="0" iyz="0" izz="0"/>)",
     nullptr},
    {"icub_r_hip_2",
     R"(<origin xyz="0 0 0.03045"/><mass value="0.526"/>
        <inertia ixx="-5.42101e-20" ixy="0" ixz="0" iyy="-5.42101e-20" iyz="0" izz="0"/>)",
     nullptr},
    {"tiago_antenna",
     R"(<mass value="0.000001"/><inertia ixx="2.371e-8" ixy="6.119e-8" ixz="1.179e-8" iyy="2.833e-8"
        iyz="0.774e-8" izz="3.849e-8"/>)",
     "negative by 38.9 %"},
    {"romeo_shoulder_yaw",
     R"(<origin xyz="0.09367 -0.01373 0.00103"/><mass value="0.57151"/><inertia ixx="0.000742356"
        ixy="0.000617202" ixz="5.98521e-06" iyy="0.00649989" iyz="-1.07417e-06" izz="0.000664209"/>)",
     "exceeds the sum of the others by 79.6 %"},
    {"romeo_hip_pitch",
     R"(<origin xyz="-0.02138 -0.00255 -0.14577"/><mass value="4.71096"/><inertia ixx="0.0390706"
        ixy="-2.41786e-05" ixz="0.0250104" iyy="0.0395116" iyz="0.000712271" izz="0.0122599"/>)",
     "negative by 5.03 %"},
    {"rounded_rod",
     R"(<origin xyz="0 0 0.2"/><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01"
        iyz="0" izz="-2e-8"/>)",
     "negative by 0.0002 %"},
};

/// The link between two heavier bodies of an arm, at the end of its own joint.
std::string with_link(const VendorLink& link) {
  return robot_element(
      link_element("base") +
      link_element(link.name, std::string("<inertial>") + link.inertial + "</inertial>") +
      link_element("hand") +
      joint_element("shoulder", "continuous", "base", link.name, "<axis xyz=\"0 1 0\"/>") +
      joint_element("elbow", "continuous", link.name, "hand",
                    "<origin xyz=\"0 0 -0.3\"/><axis xyz=\"1 0 0\"/>"));
}

std::string warnings(const UrdfResult& result) {
  std::string all;
  for (const UrdfProblem& problem : result.problems)
    all += (problem.warning ? "" : "error: ") + problem.message + "\n";
  return all;
}

TEST(VendorInertias, WarnsIfInvalidInertiasStayPositiveDefinite) {
  for (const VendorLink& link : kLinks) {
    SCOPED_TRACE(link.name);
    const UrdfResult result = parse_urdf(with_link(link), "f");
    ASSERT_TRUE(result.model) << warnings(result);
    EXPECT_EQ(warnings(result).find("used as given") != std::string::npos, link.warning != nullptr);
    if (link.warning) {
      EXPECT_NE(warnings(result).find(link.warning), std::string::npos);
    }
    for (int i = 0; i < 20; ++i) {
      const std::vector<double> q{std::sin(1.0 + i), 3 * std::sin(2.0 * i)};
      EXPECT_GT(
          Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(simple_inertia_matrix(*result.model, q))
              .eigenvalues()[0],
          0);
    }
  }
}

TEST(VendorInertias, AreErrorsIfStrict) {
  for (const VendorLink& link : kLinks) {
    SCOPED_TRACE(link.name);
    const UrdfResult result =
        parse_urdf(with_link(link), "f", {.inertias = UrdfOptions::Inertias::strict});
    EXPECT_EQ(result.model.has_value(), link.warning == nullptr) << warnings(result);
    if (link.warning) {
      EXPECT_NE(warnings(result).find(std::string("error: link '") + link.name), std::string::npos);
    }
  }
}

/// An arm whose forearm has a negative moment about the vertical: harmless while the forearm is far
/// from the vertical axis, but not when it folds onto it.
std::string folding_arm() {
  return robot_element(
      link_element("base") +
      link_element("upper", R"(<inertial><mass value="0.01"/><inertia ixx="1e-5" ixy="0" ixz="0"
                               iyy="1e-5" iyz="0" izz="1e-5"/></inertial>)") +
      link_element("fore", R"(<inertial><origin xyz="0.3 0 0"/><mass value="1"/><inertia ixx="-0.02"
                              ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial>)") +
      joint_element("turn", "continuous", "base", "upper", "<axis xyz=\"0 0 1\"/>") +
      joint_element("fold", "continuous", "upper", "fore", "<axis xyz=\"0 1 0\"/>"));
}

TEST(VendorInertias, RejectsMatricesIndefiniteInSomeConfiguration) {
  const UrdfResult result = parse_urdf(folding_arm(), "f");
  EXPECT_FALSE(result.model);
  EXPECT_NE(warnings(result).find("error: joint 'turn': the links that it moves"),
            std::string::npos)
      << warnings(result);
  // The arm's own inertia about the vertical is positive when stretched.
  UrdfOptions stretched;
  stretched.locked_joints["fold"] = 0;
  EXPECT_TRUE(parse_urdf(folding_arm(), "f", stretched).model);
  stretched.locked_joints["fold"] = 1.5707963;
  EXPECT_FALSE(parse_urdf(folding_arm(), "f", stretched).model);
  UrdfOptions geared;
  geared.rotor_inertia["turn"] = 0.03;
  const UrdfResult accepted = parse_urdf(folding_arm(), "f", geared);
  EXPECT_TRUE(accepted.model);
  EXPECT_NE(warnings(accepted).find("(fold) are not positive semidefinite; the robot's inertia "
                                    "matrix is positive definite in 32 configurations"),
            std::string::npos)
      << warnings(accepted);
}

TEST(VendorInertias, JointsWithoutInertiaGiveOneCopyableHint) {
  const std::string massless =
      R"(<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>
         </inertial>)";
  const std::string limit = R"(<limit lower="0.5" upper="1" effort="1" velocity="1"/>)";
  const std::string xml = robot_element(
      link_element("base") + link_element("palm") + link_element("finger", massless) +
      link_element("thumb", massless) + joint_element("wrist", "continuous", "base", "palm") +
      joint_element("f", "revolute", "palm", "finger", limit) +
      joint_element("t", "revolute", "palm", "thumb", limit));
  const UrdfResult result = parse_urdf(xml, "f");
  EXPECT_FALSE(result.model);
  ASSERT_EQ(result.problems.size(), 1) << warnings(result);
  EXPECT_NE(result.problems[0].message.find("joint 'f': no link that it moves (finger)"),
            std::string::npos);
  EXPECT_NE(result.problems[0].message.find("the same holds for t"), std::string::npos);
  EXPECT_NE(result.problems[0].hint.find("'locked_joints: {f: 0.5, t: 0.5}'"), std::string::npos)
      << result.problems[0].hint;
  EXPECT_TRUE(parse_urdf(xml, "f", {.locked_joints = {{"f", 0.5}, {"t", 0.5}}}).model);
  EXPECT_TRUE(parse_urdf(xml, "f", {.rotor_inertia = {{"f", 1e-4}, {"t", 1e-4}}}).model);
}

/// iCub's head: a point mass behind a neck with three intersecting axes.
TEST(VendorInertias, SingularInertiaMatrixWarningNamesTheJoint) {
  const std::string none =
      R"(<inertial><mass value="0"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/>
         </inertial>)";
  const std::string xml = robot_element(
      link_element("chest") + link_element("n1") + link_element("n2", none) +
      link_element("head", std::string("<inertial>") + kLinks[0].inertial + "</inertial>") +
      joint_element("pitch", "continuous", "chest", "n1", "<axis xyz=\"1 0 0\"/>") +
      joint_element("roll", "continuous", "n1", "n2", "<axis xyz=\"0 1 0\"/>") +
      joint_element("yaw", "continuous", "n2", "head",
                    "<origin xyz=\"0 0 0.0\"/><axis xyz=\"0.0185 -0.1108 0\"/>"));
  const UrdfResult result = parse_urdf(xml, "f");
  EXPECT_NE(warnings(result).find("joint 'yaw': no link that it moves (head)"), std::string::npos)
      << warnings(result);  // the mass is on its axis in every configuration
  const std::string aligned = robot_element(
      link_element("chest") + link_element("n1", none) +
      link_element("head", std::string("<inertial>") + kLinks[0].inertial + "</inertial>") +
      joint_element("outer", "continuous", "chest", "n1", "<axis xyz=\"0 0 1\"/>") +
      joint_element("inner", "revolute", "n1", "head",
                    "<origin xyz=\"0.3 0 0\" rpy=\"0 0 0\"/><axis xyz=\"0 0 1\"/>"
                    "<limit lower=\"-2\" upper=\"2\" effort=\"1\" velocity=\"1\"/>"));
  // A point mass 0.1123 m from the inner axis, rotated into line with the outer one.
  const double turn = std::atan2(-0.1108, 0.0185);
  const auto folded = aligned.find("rpy=\"0 0 0\"");
  for (const double rounding : {0.0, 4e-6}) {  // right angle rounded to 1.5708
    std::string at_zero = aligned;
    at_zero.replace(folded, 11, "rpy=\"0 0 " + fmt::format("{}", rounding - turn) + "\"");
    const UrdfResult warned = parse_urdf(at_zero, "f");
    ASSERT_TRUE(warned.model) << warnings(warned);
    EXPECT_NE(
        warnings(warned).find("joint 'outer': at the zero configuration no link that it moves"),
        std::string::npos)
        << rounding << warnings(warned);
  }
  EXPECT_EQ(warnings(parse_urdf(aligned, "f")), "");
}

TEST(VendorOddities, IgnoresWhiteSpaceAroundNumbers) {
  const auto arm = [](const char* mass, const char* origin) {
    return robot_element(
        link_element("base") +
        link_element("arm", std::string("<inertial>") + origin + "<mass value=" + mass +
                                R"(/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
                                   </inertial>)") +
        joint_element("j", "continuous", "base", "arm"));
  };
  const UrdfResult plain = parse_urdf(arm("\"2.5\"", "<origin xyz=\"0.1 0.2 0.3\"/>"), "f");
  const UrdfResult odd =
      parse_urdf(arm("'\n 2.5\t\n'", "<origin xyz=\" 0.1\n\t 0.2\r\n0.3 \" />"), "f");
  ASSERT_TRUE(plain.model);
  ASSERT_TRUE(odd.model) << warnings(odd);
  EXPECT_EQ(odd.model->joints[0].inertia.mass, 2.5);
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(odd.model->joints[0].inertia.moment[i], plain.model->joints[0].inertia.moment[i]);
}

TEST(VendorOddities, MimicJointWithoutLeaderIsIndependent) {
  const auto follower = [](const char* leader) {
    return robot_element(link_element("a") + link_element("b") +
                         joint_element("j", "continuous", "a", "b",
                                       std::string("<mimic joint=\"") + leader + "\"/>"));
  };
  for (const char* leader : {"missing", "j"}) {
    const UrdfResult result = parse_urdf(follower(leader), "f");
    ASSERT_TRUE(result.model) << warnings(result);
    EXPECT_EQ(result.model->nv, 1);
    EXPECT_NE(warnings(result).find("it is independent"), std::string::npos);
    EXPECT_FALSE(parse_urdf(follower(leader), "f", {.enforce_mimic = true}).model);
  }
}

TEST(VendorOddities, NamesAndIgnoresXacroLeftovers) {
  const UrdfResult result = parse_urdf(
      robot_element("<xacro:property name=\"r\" value=\"${pi}\"/>\n" + link_element("a") +
                    link_element("b", std::string(kBody) + "<visual><xacro:look/></visual>") +
                    joint_element("j", "continuous", "a", "b")),
      "f");
  ASSERT_TRUE(result.model) << warnings(result);
  EXPECT_EQ(warnings(result),
            "<xacro:property> is left over from xacro and is ignored, with what is in it\n");
}

TEST(VendorOddities, RobotNameMayBeEmpty) {
  const UrdfResult result = parse_urdf("<robot name=\"\">" + link_element("a") + link_element("b") +
                                           joint_element("j", "continuous", "a", "b") + "</robot>",
                                       "f");
  ASSERT_TRUE(result.model) << warnings(result);
  EXPECT_EQ(warnings(result), "<robot>: its name is empty\n");
}

}  // namespace
}  // namespace conddp
