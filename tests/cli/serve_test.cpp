#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// Runs the tool with a text as standard input.
ProcessResult serve(const std::string& input) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "requests";
  std::ofstream(file) << input;
  const Channel out = open_pipe(), err = open_pipe();
  const pid_t child = start_conddp({"serve"}, {}, out, err, [&file] {
    const int requests = ::open(file.c_str(), O_RDONLY);
    ::dup2(requests, 0);
  });
  return collect_child(child, out, err, [](const ProcessResult&) {});
}

std::vector<Json> lines_of(const std::string& text) {
  std::vector<Json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(Json::parse(line));
  return lines;
}

TEST(ServeTest, RepliesLineByLine) {
  const ProcessResult r =
      serve("{\"id\": 1, \"do\": \"load\", \"problem\": \"p\", \"file\": \"" + kPendulum +
            "\"}\n\nnonsense\n{\"id\": 2, \"do\": \"solve\", \"problem\": \"p\", \"parts\": []}");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const std::vector<Json> replies = lines_of(r.out);
  ASSERT_EQ(replies.size(), 3u);
  EXPECT_EQ(replies[0]["id"], 1);
  EXPECT_TRUE(replies[1].contains("error"));
  EXPECT_EQ(replies[2]["solution"]["status"], "converged");
}

TEST(ServeTest, RefusesEndlessLines) {
  const ProcessResult r = serve(std::string(65 << 20, 'x') + "\nnonsense\n");
  EXPECT_EQ(r.exit_code, 0);
  const std::vector<Json> replies = lines_of(r.out);
  ASSERT_EQ(replies.size(), 2u);
  EXPECT_EQ(replies[0]["error"]["message"], "a request may have 64 MiB");
}

}  // namespace
}  // namespace conddp
