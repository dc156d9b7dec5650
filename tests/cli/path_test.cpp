// A path means the same in every spelling for every subcommand.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "process.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTriangle = R"(solid triangle
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 0.1 0 0
vertex 0 0.1 0
endloop
endfacet
endsolid triangle
)";

/// An arm next to its problem, with a mesh in a package that is the folder of both.
class Paths : public testing::Test {
 protected:
  Paths() {
    std::string robot = read_file(source("problems/robots/arm7.urdf"));
    const std::string link = R"(<link name="link_1">)";
    robot.insert(
        robot.find(link) + link.size(),
        R"(<visual><geometry><mesh filename="package://my arm/mesh.stl"/></geometry></visual>)");
    std::string problem = read_file(source("problems/arm_reach.yaml"));
    problem.replace(problem.find("robots/arm7"), 11, "arm7");
    folder_.write("my arm/arm7.urdf", robot);
    folder_.write("my arm/mesh.stl", kTriangle);
    folder_.write("my arm/reach.yaml", problem);
    fs::create_directory(home_ / "elsewhere");
    fs::create_directory_symlink("my arm", folder_.path() / "linked");
    fs::create_symlink("reach.yaml", home_ / "link.yaml");
  }
  ProcessResult run(const fs::path& from, const std::vector<std::string>& arguments) const {
    return run_conddp(arguments, {.folder = from});
  }

  TemporaryFolder folder_;
  fs::path home_ = folder_.path() / "my arm";
};

/// True if the page draws the mesh, which only the robot's path can locate.
bool draws_the_mesh(const fs::path& page) {
  return read_file(page).find(R"("kind":"mesh")") != std::string::npos;
}

TEST_F(Paths, ProblemIdentityIgnoresPathSpelling) {
  const fs::path deep = home_ / "elsewhere", above = folder_.path();
  int count = 0;
  for (const auto& [from, problem, out] : {
           std::tuple(home_, "reach.yaml", "out"),
           std::tuple(home_, "./reach.yaml", "./out/"),
           std::tuple(home_, "link.yaml", "."),
           std::tuple(home_, "elsewhere/../reach.yaml", "a/../b"),
           std::tuple(deep, "../reach.yaml", "."),
           std::tuple(above, "my arm/reach.yaml", "my out"),
           std::tuple(above, "linked//link.yaml", "linked/out"),
       }) {
    SCOPED_TRACE(problem);
    const fs::path folder = from / ("run " + std::to_string(++count)) / out;
    for (const std::string& name : {std::string(problem), (from / problem).string()}) {
      const ProcessResult solved = run(from, {"solve", name, "--report", "--quiet", "-o", folder});
      ASSERT_EQ(solved.exit_code, 0) << solved.err;
      EXPECT_TRUE(draws_the_mesh(folder / "report.html"));
      EXPECT_EQ(run(from, {"check", name}).exit_code, 0);
    }
    const std::string relative = (folder / "solution.json").lexically_relative(from);
    for (const std::string& name : {relative, "./" + relative, (from / relative).string()}) {
      EXPECT_EQ(run(from, {"verify", name, "--quiet"}).exit_code, 0) << name;
      EXPECT_EQ(run(from, {"compare", name, relative}).exit_code, 0) << name;
      EXPECT_EQ(run(from, {"report", name, "-o", "page.html"}).exit_code, 0) << name;
      EXPECT_TRUE(draws_the_mesh(from / "page.html")) << name;
    }
    const ProcessResult bench =
        run(from, {"bench", problem, "--solvers", "box_fddp", "--repeat", "0"});
    EXPECT_EQ(bench.exit_code, 0) << bench.err;
    fs::create_directories(from / "golden");
    EXPECT_EQ(run(from, {"regress", "--add", problem, "golden"}).exit_code, 0);
    EXPECT_EQ(run(from, {"regress", "golden"}).exit_code, 0);
    fs::remove_all(from / "golden");
  }
  for (const char* robot : {"arm7.urdf", "./arm7.urdf", "../linked/arm7.urdf"})
    EXPECT_EQ(run(home_, {"inspect", robot}).exit_code, 0) << robot;
}

TEST_F(Paths, VerifiesSolutionsFromAnyFolder) {
  ASSERT_EQ(run(home_, {"solve", "reach.yaml", "--quiet", "-o", "."}).exit_code, 0);
  for (const fs::path& from : {home_, home_ / "elsewhere", fs::path("/")}) {
    EXPECT_EQ(run(from, {"verify", home_ / "solution.json", "--quiet"}).exit_code, 0) << from;
    EXPECT_EQ(run(from, {"report", home_ / "solution.json"}).err, "") << from;
  }
}

TEST_F(Paths, EmptyPathIsBadInputForEverySubcommand) {
  const std::vector<std::vector<std::string>> commands = {
      {"solve", ""},
      {"solve", "reach.yaml", "--warm-start", ""},
      {"solve", "reach.yaml", "-o", ""},
      {"check", ""},
      {"verify", ""},
      {"verify", "solution.json", "--problem", ""},
      {"contacts", "", "-o", "new.yaml"},
      {"contacts", "solution.json", "-o", ""},
      {"contacts", "solution.json", "-o", "new.yaml", "--problem", ""},
      {"bench", ""},
      {"bench", "reach.yaml", ""},
      {"bench", "reach.yaml", "-o", ""},
      {"report", ""},
      {"report", "solution.json", "-o", ""},
      {"report", "solution.json", "--problem", ""},
      {"report", "solution.json", "--bench", ""},
      {"compare", "", ""},
      {"regress", ""},
      {"regress", "--add", "", "."},
      {"regress", "--add", "reach.yaml", ""},
      {"regress", "--junit", "", "."},
      {"inspect", ""},
      {"man", "-o", ""},
  };
  ASSERT_EQ(run(home_, {"solve", "reach.yaml", "--quiet", "-o", "."}).exit_code, 0);
  for (const std::vector<std::string>& arguments : commands) {
    const ProcessResult r = run(home_, arguments);
    EXPECT_EQ(r.exit_code, 2) << arguments[0];
    EXPECT_EQ(r.out, "") << arguments[0];
    EXPECT_NE(r.err.find("the value is empty"), std::string::npos) << arguments[0] << "\n" << r.err;
  }
}

TEST_F(Paths, CircularLinksAndLongNamesAreBadInput) {
  fs::create_symlink("circle.yaml", home_ / "circle.yaml");
  const std::string name(300, 'x');
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"bench", ".", "--solvers", "box_fddp", "--repeat", "0"},
           {"regress", "--add", name + ".yaml", "."},
           {"regress", "--add", "reach.yaml", name},
           {"regress", "--add", "reach.yaml", "circle.yaml"}}) {
    const ProcessResult r = run(home_, arguments);
    EXPECT_EQ(r.exit_code, 2) << arguments[0] << r.err;
    EXPECT_EQ(r.err.find("defect"), std::string::npos) << r.err;
  }
}

TEST_F(Paths, DeletedFolderIsBadInput) {
  const std::string gone = "mkdir gone; cd gone; rmdir ../gone; " + conddp_binary();
  const std::string errors = folder_.path() / "errors";
  for (const char* arguments : {" bench reach.yaml", " regress golden.json", " solve reach.yaml"}) {
    const std::string command =
        "cd '" + home_.string() + "'; " + gone + arguments + " 2>'" + errors + "' >&2";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 2) << arguments << read_file(errors);
    EXPECT_EQ(read_file(errors).find("defect"), std::string::npos) << read_file(errors);
  }
}

TEST_F(Paths, OmitsAMeshOutsideAnyPackage) {
  std::string robot = read_file(home_ / "arm7.urdf");
  const std::string name = "package://my arm/mesh.stl";
  robot.replace(robot.find(name), name.size(), "package://");
  folder_.write("my arm/arm7.urdf", robot);
  ASSERT_EQ(run(home_, {"solve", "reach.yaml", "--report", "--quiet", "-o", "."}).exit_code, 0);
  EXPECT_FALSE(draws_the_mesh(home_ / "report.html"));
}

}  // namespace
}  // namespace conddp
