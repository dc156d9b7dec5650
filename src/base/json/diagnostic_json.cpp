#include "base/json/diagnostic_json.hpp"

namespace conddp {

OrderedJson diagnostic_json(const Diagnostic& d) {
  const auto position = [](int number) { return number > 0 ? OrderedJson(number) : OrderedJson(); };
  return {{"file", d.file.empty() ? OrderedJson() : OrderedJson(d.file)},
          {"line", position(d.line)},
          {"column", position(d.line > 0 ? d.column : 0)},
          {"path", d.path},
          {"severity", severity_name(d.severity)},
          {"message", d.message},
          {"hint", d.hint},
          {"accepted", d.accepted}};
}

}  // namespace conddp
