#pragma once

#include <regex>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

namespace conddp {

/// Plain scalars that a YAML 1.1 reader interprets differently from a YAML 1.2 reader. "1e-3" is a
/// text there (yaml.org/type/float.html requires a point and the sign of the exponent), "010" is
/// eight, "1:30" is ninety, and "on" is a boolean. "y" and "n" would be booleans too, but PyYAML
/// reads them as texts.
class Yaml11Reader {
 public:
  static std::vector<std::string> misread(const std::string& text) {
    Yaml11Reader reader;
    reader.walk(YAML::Load(text));
    return std::move(reader.found_);
  }

 private:
  void walk(const YAML::Node& node) {
    if (node.IsScalar() && node.Tag() == "?") scalar(node.Scalar());
    if (node.IsSequence())
      for (const YAML::Node& entry : node) walk(entry);
    if (node.IsMap())
      for (const auto& entry : node) {
        walk(entry.first);
        walk(entry.second);
      }
  }
  void scalar(const std::string& text) {
    static const std::regex number_1_2(R"([-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?)"),
        number_1_1(R"([-+]?(0|[1-9][0-9]*|[0-9]*\.[0-9]*([eE][-+][0-9]+)?))"),
        other_1_1(
            R"([-+]?[0-9_]+(:[0-5]?[0-9])+(\.[0-9_]*)?|[-+]?0[bx][0-9a-fA-F_]+|[0-9]+_[0-9_]*|)"
            R"([0-9]{4}-[0-9]+-[0-9]+.*|yes|Yes|YES|no|No|NO|on|On|ON|off|Off|OFF)");
    const bool number = std::regex_match(text, number_1_2);
    if (number ? !std::regex_match(text, number_1_1) : std::regex_match(text, other_1_1))
      found_.push_back(text);
  }
  std::vector<std::string> found_;
};

}  // namespace conddp
