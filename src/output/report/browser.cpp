#include "output/report/browser.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/text_file.hpp"
#include "base/text/base64.hpp"
#include "base/text/utf8.hpp"

extern char** environ;

namespace conddp {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using BrowserClock = std::chrono::steady_clock;

/// Software draws the same picture on every machine.
constexpr const char* kBrowserOptions[] = {"--headless=new",
                                           "--remote-debugging-pipe",
                                           "--use-angle=swiftshader",
                                           "--enable-unsafe-swiftshader",
                                           "--ignore-gpu-blocklist",
                                           "--force-device-scale-factor=1",
                                           "--no-first-run",
                                           "--no-default-browser-check",
                                           "--disable-extensions",
                                           "--disable-sync",
                                           "--disable-component-update",
                                           "--disable-background-networking",
                                           "--host-resolver-rules=MAP * ~NOTFOUND"};

/// The last line of a text that is not empty.
std::string last_line(std::string_view text) {
  const std::size_t end = text.find_last_not_of(" \r\n");
  if (end == text.npos) return {};
  text = text.substr(0, end + 1);
  return std::string(text.substr(text.find_last_of('\n') + 1));
}

std::array<int, 2> connection() {
  std::array<int, 2> ends;
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw OutputError(fmt::format("no connection to a browser: {}", std::strerror(errno)));
  return ends;
}

/// Returns false if a process still runs after this time.
bool ends_within(pid_t process, BrowserClock::duration time) {
  for (const auto end = BrowserClock::now() + time;;) {
    const pid_t ended = ::waitpid(process, nullptr, WNOHANG);
    if (ended == process || (ended < 0 && errno != EINTR)) return true;
    if (BrowserClock::now() > end) return false;
    std::this_thread::sleep_for(10ms);
  }
}

}  // namespace

std::optional<fs::path> find_browser() {
  const char* variable = std::getenv("PATH");
  const std::string_view folders = variable == nullptr ? "" : variable;
  for (const char* name : kBrowsers)
    for (std::size_t first = 0; first < folders.size();) {
      const std::size_t end = std::min(folders.find(':', first), folders.size());
      const fs::path file = fs::path(folders.substr(first, end - first)) / name;
      first = end + 1;
      std::error_code error;
      if (::access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file, error)) return file;
    }
  return std::nullopt;
}

Browser::Folder::Folder() {
  std::string name = fs::temp_directory_path() / "conddp_browser_XXXXXX";
  if (::mkdtemp(name.data()) == nullptr)
    throw OutputError(fmt::format("'{}' cannot be created: {}", name, std::strerror(errno)));
  path = name;
}

Browser::Folder::~Folder() {
  // Helpers of a browser that was killed may still write for a moment.
  for (int tries = 0; tries < 20; ++tries) {
    std::error_code error;
    fs::remove_all(path, error);
    if (!error) return;
    std::this_thread::sleep_for(20ms);
  }
}

Browser::Process::Process(const std::array<int, 2>& ends, const std::string& program,
                          const fs::path& profile, const fs::path& messages)
    : socket(ends[0]) {
  const Descriptor other_end(ends[1]);
  std::vector<std::string> words = {program, "--user-data-dir=" + profile.string()};
  words.insert(words.end(), std::begin(kBrowserOptions), std::end(kBrowserOptions));
  // Chromium refuses to run as root in its sandbox.
  if (::geteuid() == 0) words.push_back("--no-sandbox");
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  // Chromium reads the protocol's calls from descriptor 3 and answers to 4.
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, other_end.get(), 3);
  posix_spawn_file_actions_adddup2(&actions, other_end.get(), 4);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, messages.c_str(), O_WRONLY | O_CREAT, 0600);
  // A process group of its own: the end of the browser is the end of its helpers.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  const int error =
      ::posix_spawn(&id, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0)
    throw OutputError(fmt::format("'{}' cannot be started: {}", program, std::strerror(error)));
}

Browser::Process::~Process() {
  // Without the connection, Chromium ends by itself.
  socket.close();
  const bool ended = ends_within(id, 3s);
  ::kill(-id, SIGKILL);
  if (!ended) ends_within(id, 3s);
}

Browser::Browser(BrowserOptions options)
    : options_(std::move(options)),
      messages_(folder_.path / "messages"),
      process_(connection(), options_.program.string(), folder_.path / "profile", messages_) {
  const OrderedJson target = result_of(send("Target.createTarget", {{"url", "about:blank"}}));
  session_ = result_of(send("Target.attachToTarget",
                            {{"targetId", target.at("targetId")}, {"flatten", true}}))
                 .at("sessionId");
}

void Browser::open(const std::string& page) {
  result_of(send("Fetch.enable", OrderedJson::object()));
  const int navigation = send("Page.navigate", {{"url", "http://localhost/"}});
  const OrderedJson request = event("Fetch.requestPaused");
  result_of(send("Fetch.fulfillRequest",
                 {{"requestId", request.at("requestId")},
                  {"responseCode", 200},
                  {"responseHeaders",
                   OrderedJson::array({{{"name", "Content-Type"}, {"value", "text/html"}}})},
                  {"body", base64(page)}}));
  result_of(navigation);
  evaluate(
      "new Promise(done => document.readyState === 'complete' ? done() : "
      "addEventListener('load', () => done()))");
}

OrderedJson Browser::evaluate(const std::string& expression) {
  const OrderedJson answer = result_of(
      send("Runtime.evaluate",
           {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}}));
  if (answer.contains("exceptionDetails")) {
    const OrderedJson& details = answer["exceptionDetails"];
    const std::string text = details.value("text", "");
    fail("failed in the page: " + printable(details.contains("exception")
                                                ? details["exception"].value("description", text)
                                                : text));
  }
  const OrderedJson& result = answer.at("result");
  return result.contains("value") ? result["value"] : OrderedJson();
}

int Browser::send(const std::string& method, OrderedJson parameters) {
  OrderedJson call = {{"id", ++calls_}, {"method", method}, {"params", std::move(parameters)}};
  if (!session_.empty()) call["sessionId"] = session_;
  unsent_ += compact_json(call) + '\0';
  return calls_;
}

OrderedJson Browser::result_of(int call) {
  for (;;) {
    OrderedJson message = receive();
    if (message.value("id", 0) != call) continue;
    if (message.contains("error"))
      fail("answered: " + printable(message["error"].value("message", "")));
    return message.at("result");
  }
}

OrderedJson Browser::event(const std::string& name) {
  for (;;) {
    OrderedJson message = receive();
    if (message.value("method", "") == name) return message.at("params");
  }
}

OrderedJson Browser::receive() {
  const auto deadline = BrowserClock::now() + options_.patience;
  for (std::size_t searched = 0;;) {
    const std::size_t end = unread_.find('\0', searched);
    if (end != unread_.npos) {
      OrderedJson message = OrderedJson::parse(unread_.begin(), unread_.begin() + end);
      unread_.erase(0, end + 1);
      return message;
    }
    searched = unread_.size();
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(deadline - BrowserClock::now());
    if (left <= 0ms)
      fail(fmt::format("did not answer for {:g} s",
                       std::chrono::duration<double>(options_.patience).count()));
    transfer(left);
  }
}

void Browser::transfer(std::chrono::milliseconds longest) {
  const short wanted = unsent_.empty() ? POLLIN : POLLIN | POLLOUT;
  pollfd polled{process_.socket.get(), wanted, 0};
  const int ready = ::poll(&polled, 1, static_cast<int>(longest.count()));
  if (options_.interrupted()) fail("was interrupted");
  if (ready <= 0) return;
  if ((polled.revents & POLLOUT) != 0) {
    const ssize_t sent =
        ::send(polled.fd, unsent_.data(), unsent_.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent > 0) unsent_.erase(0, static_cast<std::size_t>(sent));
  }
  if ((polled.revents & ~POLLOUT) == 0) return;
  char buffer[1 << 16];
  const ssize_t received = ::recv(polled.fd, buffer, sizeof buffer, MSG_DONTWAIT);
  if (received > 0) unread_.append(buffer, static_cast<std::size_t>(received));
  const bool later = received < 0 && (errno == EAGAIN || errno == EINTR);
  if (received <= 0 && !later) fail("ended too early");
}

void Browser::fail(const std::string& how) const {
  constexpr std::size_t kLongest = 1 << 20;
  const std::string said = last_line(read_text_file(messages_, kLongest).text);
  throw OutputError(fmt::format("'{}' {}{}", options_.program.string(), how,
                                said.empty() ? "" : "; its last message: " + printable(said)));
}

}  // namespace conddp
