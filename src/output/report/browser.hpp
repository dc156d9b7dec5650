#pragma once

#include <array>
#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <sys/types.h>

#include "base/files/descriptor.hpp"
#include "base/json/ordered_json.hpp"

namespace conddp {

/// Programs that Browser can run.
inline constexpr const char* kBrowsers[] = {"chromium", "chromium-browser", "google-chrome",
                                            "google-chrome-stable"};

/// The first of kBrowsers on the search path; nothing if there is none.
std::optional<std::filesystem::path> find_browser();

struct BrowserOptions {
  std::filesystem::path program;
  std::chrono::milliseconds patience{120'000};  ///< for an answer
  std::function<bool()> interrupted = [] { return false; };
};

/// A Chromium without windows and network, driven through its DevTools protocol. If it ends early,
/// does not answer in time or is interrupted, methods throw OutputError. The destructor ends the
/// process and removes its folder.
class Browser {
 public:
  explicit Browser(BrowserOptions options);

  /// Opens a page. Browsers encode videos only for pages from an address that they trust; the page
  /// gets one, and the request for it is answered here.
  void open(const std::string& page);

  /// The value of a JavaScript expression in the page, or of its promise. Throws OutputError with
  /// the page's message if the expression throws.
  OrderedJson evaluate(const std::string& expression);

 private:
  struct Folder {
    Folder();
    ~Folder();
    std::filesystem::path path;
  };
  struct Process {
    /// `ends`: of the connection. `messages`: the file for what the process prints.
    Process(const std::array<int, 2>& ends, const std::string& program,
            const std::filesystem::path& profile, const std::filesystem::path& messages);
    ~Process();
    Descriptor socket;
    pid_t id = -1;
  };

  /// Sends a call and returns its number.
  int send(const std::string& method, OrderedJson parameters);
  /// The result of a call.
  OrderedJson result_of(int call);
  /// The parameters of the next event of this name.
  OrderedJson event(const std::string& name);
  /// The next message.
  OrderedJson receive();
  /// Waits until something can be received, or sent if anything waits, and does so.
  void transfer(std::chrono::milliseconds longest);
  [[noreturn]] void fail(const std::string& how) const;

  BrowserOptions options_;
  Folder folder_;
  std::filesystem::path messages_;
  Process process_;
  std::string session_;  ///< identifies the page
  int calls_ = 0;
  std::string unsent_, unread_;
};

}  // namespace conddp
