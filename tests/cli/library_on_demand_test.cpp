#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "child.hpp"
#include "process.hpp"

namespace conddp {
namespace {

/// The tool without the libraries beside it in the build tree.
class LibraryOnDemand : public ::testing::Test {
 protected:
  LibraryOnDemand() { std::filesystem::copy_file(conddp_binary(), tool()); }

  /// Exit code of a command; errors() holds its stderr.
  int run(const std::string& arguments) const {
    const std::string command = tool() + " " + arguments + " > /dev/null 2> " + error_file();
    return WEXITSTATUS(std::system(command.c_str()));
  }
  std::string errors() const { return read_file(error_file()); }
  std::string output() const { return folder_.path() / "out"; }

 private:
  std::string tool() const { return folder_.path() / "conddp"; }
  std::string error_file() const { return folder_.path() / "errors"; }
  const TemporaryFolder folder_;
};

const std::string kFastest = source("problems/double_integrator_fastest.yaml");  // by ipopt

TEST_F(LibraryOnDemand, OtherCommandsWorkWithoutTheIpoptLibrary) {
  EXPECT_EQ(run("list solvers"), 0) << errors();
  EXPECT_EQ(run("schema problem"), 0) << errors();
  EXPECT_EQ(run("check " + kFastest), 0) << errors();
  EXPECT_EQ(run("solve " + kPendulum + " -o " + output()), 0) << errors();
}

TEST_F(LibraryOnDemand, MissingIpoptLibraryIsReportedAndNothingWritten) {
  EXPECT_EQ(run("solve " + kFastest + " -o " + output()), 2);
  EXPECT_EQ(errors().find("conddp: error: the solver 'ipopt' cannot be loaded: conddp-ipopt-"), 0u)
      << errors();
  EXPECT_TRUE(std::filesystem::is_empty(output()));
}

TEST_F(LibraryOnDemand, AnswerRemainsIfIpoptLibraryIsMissing) {
  const std::string file = output() + ".yaml";
  std::ofstream(file) << R"(conddp: 1
name: far
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {values: {x: 0}}
phases: [{knots: 5, dt: 0.1}]
costs: {effort: {residual: control}}
constraints: {force: {bounds: control, lower: -1, upper: 1}}
terminal: {constraints: {there: {residual: state, equals: 5}}}
solver: {name: auto}
)";
  EXPECT_EQ(run("solve " + file + " -o " + output()), 1) << errors();
  const std::string solution = read_file(output() + "/solution.json");
  EXPECT_NE(solution.find("the solver 'ipopt' cannot be loaded: "), std::string::npos);
  EXPECT_NE(solution.find("; it is expected as '"), std::string::npos);
}

}  // namespace
}  // namespace conddp
