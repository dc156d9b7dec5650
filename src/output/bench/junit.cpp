#include "output/bench/junit.hpp"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Escapes a character for an attribute.
std::string escape(char c) {
  static constexpr std::pair<char, std::string_view> kEscapes[] = {
      {'&', "&amp;"},
      {'<', "&lt;"},
      {'>', "&gt;"},
      {'"', "&quot;"},
      {'\n', "&#10;"}};  // otherwise lost in an attribute
  for (const auto& [character, escaped] : kEscapes)
    if (c == character) return std::string(escaped);
  return std::string(1, static_cast<unsigned char>(c) < 0x20 ? '?' : c);
}

std::string escape(const std::string& text) {
  std::string out;
  for (const char c : text) out += escape(c);
  return out;
}

std::string element(const std::string& suite, const JunitCase& test) {
  std::string text = fmt::format("  <testcase classname=\"{}\" name=\"{}\" time=\"{:.6f}\"",
                                 escape(suite), escape(test.name), test.time_s);
  if (test.failures.empty() && test.error.empty()) return text + "/>\n";
  text += ">\n";
  if (!test.error.empty()) text += fmt::format("    <error message=\"{}\"/>\n", escape(test.error));
  if (!test.failures.empty()) {
    std::string lines;
    for (const std::string& failure : test.failures) lines += escape(failure) + '\n';
    text += fmt::format("    <failure message=\"{}\">{}</failure>\n", escape(test.failures.front()),
                        lines);
  }
  return text + "  </testcase>\n";
}

}  // namespace

std::string junit_xml(const std::string& suite, const std::vector<JunitCase>& cases) {
  const auto count = [&](auto holds) { return std::count_if(cases.begin(), cases.end(), holds); };
  double time_s = 0;
  for (const JunitCase& test : cases) time_s += test.time_s;
  std::string text = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<testsuite name=\"{}\" tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"{:.6f}\">\n",
      escape(suite), cases.size(), count([](const JunitCase& t) { return !t.failures.empty(); }),
      count([](const JunitCase& t) { return !t.error.empty(); }), time_s);
  for (const JunitCase& test : cases) text += element(suite, test);
  return text + "</testsuite>\n";
}

}  // namespace conddp
