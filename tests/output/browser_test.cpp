#include "output/report/browser.hpp"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include <signal.h>

#include <gtest/gtest.h>

#include "base/files/atomic_file.hpp"
#include "base/text/base64.hpp"
#include "output/report/motion_video.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

/// Shell scripts in the place of Chromium: they answer on descriptor 4, whatever they are asked.
class FakeBrowser : public testing::Test {
 protected:
  FakeBrowser() {
    fs::create_directory(folder_ / "temporary");
    setenv("TMPDIR", (folder_ / "temporary").c_str(), 1);
  }
  ~FakeBrowser() override {
    EXPECT_TRUE(fs::is_empty(folder_ / "temporary")) << "what a browser leaves";
    unsetenv("TMPDIR");
  }

  std::string script(const std::string& text, const std::string& name = "chromium") {
    const std::string file = folder_.write(name, "#!/bin/sh\n" + text);
    fs::permissions(file, fs::perms::owner_all);
    return file;
  }

  /// The error of a recording.
  static std::string error_of(const BrowserOptions& options) {
    try {
      record_motion("<html>", options, [](double) {});
    } catch (const OutputError& error) {
      return error.what();
    }
    return {};
  }

  /// A script that answers all calls of a recording, the last two by these values.
  std::string recorder(const std::string& first, const std::string& second) {
    return script(
        R"(printf '{"id":1,"result":{"targetId":"t"}}\0{"id":2,"result":{"sessionId":"s"}}\0' >&4
printf '{"method":"Other","params":{}}\0{"id":3,"result":{}}\0' >&4
printf '{"method":"Fetch.requestPaused","params":{"requestId":"r"}}\0{"id":5,"result":{}}\0' >&4
printf '{"id":4,"result":{}}\0{"id":6,"result":{"result":{}}}\0{"id":7,"result":{"result":{}}}\0' >&4
printf '{"id":8,"result":)" +
        first + R"(}\0{"id":9,"result":)" + second + R"(}\0' >&4
cat <&3 >/dev/null
)");
  }

  TemporaryFolder folder_;
};

TEST_F(FakeBrowser, RecordingGivesBytesAndProgress) {
  const std::string video("\x1a\x45\xdf\xa3\0\xff", 6);
  const BrowserOptions options = {
      .program = recorder(R"({"result":{"value":{"done":false,"value":0.5}}})",
                          R"({"result":{"value":{"done":true,"value":")" + base64(video) + "\"}}}"),
      .patience = 20s};
  double share = 0;
  EXPECT_EQ(record_motion("<html>", options, [&](double done) { share = done; }), video);
  EXPECT_EQ(share, 0.5);
}

TEST_F(FakeBrowser, ErrorsOfThePageAreQuoted) {
  const std::string error = error_of(
      {.program = recorder(
           R"({"exceptionDetails":{"text":"t","exception":{"description":"no WebGL"}}})", "{}"),
       .patience = 20s});
  EXPECT_TRUE(error.ends_with("failed in the page: no WebGL")) << error;
}

TEST_F(FakeBrowser, EarlyEndQuotesItsLastMessage) {
  const std::string error = error_of(
      {.program = script("echo first >&2\necho 'no display' >&2\nexit 3\n"), .patience = 20s});
  EXPECT_TRUE(error.ends_with("ended too early; its last message: no display")) << error;
}

TEST_F(FakeBrowser, HangingBrowserIsEndedAfterItsTime) {
  const std::string process = folder_ / "process";
  const auto start = std::chrono::steady_clock::now();
  const std::string error =
      error_of({.program = script("echo $$ >" + process + "\nsleep 1000\n"), .patience = 300ms});
  EXPECT_TRUE(error.ends_with("did not answer for 0.3 s")) << error;
  EXPECT_LT(std::chrono::steady_clock::now() - start, 60s);
  int id = 0;
  std::ifstream(process) >> id;
  ASSERT_GT(id, 0);
  EXPECT_NE(kill(id, 0), 0) << "it still runs";
}

TEST_F(FakeBrowser, InterruptedRecordingEnds) {
  const std::string error =
      error_of({.program = script("cat <&3 >/dev/null\n"), .patience = 60s, .interrupted = [] {
                  return true;
                }});
  EXPECT_TRUE(error.ends_with("was interrupted")) << error;
}

TEST_F(FakeBrowser, AnswersOutsideTheProtocolAreErrors) {
  for (const char* answer :
       {"nonsense", "7", R"({"id":1})", R"({"id":"x"})", R"({"id":1,"result":{}})"}) {
    const std::string error = error_of(
        {.program = script(std::string("printf '") + answer + "\\0' >&4\ncat <&3 >/dev/null\n"),
         .patience = 20s});
    EXPECT_TRUE(error.starts_with("the browser does not speak its protocol")) << answer << error;
  }
  const std::string error =
      error_of({.program = script("printf '{\"id\":1,\"error\":{\"message\":\"unknown\"}}\\0' >&4\n"
                                  "cat <&3 >/dev/null\n"),
                .patience = 20s});
  EXPECT_TRUE(error.ends_with("answered: unknown")) << error;
}

TEST_F(FakeBrowser, ProgramThatCannotRunIsAnError) {
  EXPECT_NE(error_of({.program = folder_ / "none"}).find("none' cannot be started"),
            std::string::npos);
}

TEST_F(FakeBrowser, FirstKnownNameOnThePathIsTaken) {
  const std::string former = getenv("PATH");
  setenv("PATH", (folder_.path().string() + ":" + (folder_ / "more").string()).c_str(), 1);
  EXPECT_EQ(find_browser(), std::nullopt);
  folder_.write("chromium", "not a program");
  fs::create_directories(folder_ / "more/chromium-browser");
  EXPECT_EQ(find_browser(), std::nullopt);
  script("", "more/google-chrome");
  EXPECT_EQ(find_browser(), folder_ / "more/google-chrome");
  script("", "more/chromium");
  EXPECT_EQ(find_browser(), folder_ / "more/chromium");
  setenv("PATH", "", 1);
  EXPECT_EQ(find_browser(), std::nullopt);
  setenv("PATH", former.c_str(), 1);
}

}  // namespace
}  // namespace conddp
