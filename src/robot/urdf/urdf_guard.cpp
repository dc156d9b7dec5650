#include "robot/urdf/urdf_guard.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <set>

#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"
#include "robot/urdf/xml_outline.hpp"

namespace conddp {
namespace {

/// Attribute of an element that is read. `numbers` > 0: its value is that many finite numbers.
struct AttributeRule {
  std::string_view name;
  int numbers = 0;
};
struct ElementRule {
  std::string_view parent;  ///< tag of the enclosing element
  std::string_view tag;
  std::vector<AttributeRule> attributes;
};

const std::vector<ElementRule>& rules() {
  static const std::vector<ElementRule> table{
      {"robot", "link", {{"name"}}},
      {"robot", "joint", {{"name"}, {"type"}}},
      {"link", "inertial", {}},
      {"inertial", "origin", {{"xyz", 3}, {"rpy", 3}}},
      {"inertial", "mass", {{"value", 1}}},
      {"inertial",
       "inertia",
       {{"ixx", 1}, {"ixy", 1}, {"ixz", 1}, {"iyy", 1}, {"iyz", 1}, {"izz", 1}}},
      {"joint", "origin", {{"xyz", 3}, {"rpy", 3}}},
      {"joint", "parent", {{"link"}}},
      {"joint", "child", {{"link"}}},
      {"joint", "axis", {{"xyz", 3}}},
      {"joint", "limit", {{"lower", 1}, {"upper", 1}, {"effort", 1}, {"velocity", 1}}},
      {"joint", "dynamics", {{"damping", 1}, {"friction", 1}}},
      {"joint", "mimic", {{"joint"}, {"multiplier", 1}, {"offset", 1}}},
  };
  return table;
}

/// Known elements that are not read, as (parent, tag).
constexpr std::array<std::pair<std::string_view, std::string_view>, 8> kIgnored{{
    {"robot", "material"},
    {"robot", "transmission"},
    {"robot", "gazebo"},
    {"robot", "sensor"},
    {"link", "visual"},
    {"link", "collision"},
    {"joint", "safety_controller"},
    {"joint", "calibration"},
}};

std::string_view parent_tag(const XmlOutline& outline, const XmlElement& element) {
  return element.parent < 0 ? std::string_view{} : outline.elements[element.parent].tag;
}

/// Rule of an element, or null unless the element and every element around it are read.
const ElementRule* rule_of(const XmlOutline& outline, const XmlElement& element) {
  if (element.parent < 0) return nullptr;
  const XmlElement& parent = outline.elements[element.parent];
  const bool known_parent = parent.depth == 0 || rule_of(outline, parent) != nullptr;
  if (!known_parent) return nullptr;
  const auto rule = std::find_if(rules().begin(), rules().end(), [&](const ElementRule& r) {
    return r.parent == parent.tag && r.tag == element.tag;
  });
  return rule == rules().end() ? nullptr : &*rule;
}

/// Name of the link or joint around an element (or the element itself), and its message prefix.
std::pair<std::string, std::string> owner(const XmlOutline& outline, int element) {
  while (element >= 0 && outline.elements[element].depth > 1)
    element = outline.elements[element].parent;
  if (element < 0 || outline.elements[element].depth != 1) return {};
  const XmlElement& top = outline.elements[element];
  const std::string name(top.attribute("name").value_or(""));
  return {name, std::string(top.tag) + " '" + name + "': "};
}

/// Reason why a word is not a finite number, if any.
std::optional<std::string> number_defect(std::string_view word) {
  const std::string quoted = "'" + std::string(word.substr(0, 40)) + "'";
  if (word.size() > 1 && word[0] == '+') word.remove_prefix(1);
  double value = 0;
  const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (stop != word.data() + word.size() || error == std::errc::invalid_argument)
    return quoted + " is not a number";
  if (error != std::errc{} || !std::isfinite(value))
    return quoted + " is not a finite number in range";
  return std::nullopt;
}

/// Reason why the text is not a list of `count` finite numbers, if any.
std::optional<std::string> number_defect(std::string_view text, int count) {
  int found = 0;
  for (std::size_t at = 0; (at = text.find_first_not_of(kXmlSpace, at)) != text.npos; ++found) {
    const std::size_t end = std::min(text.find_first_of(kXmlSpace, at), text.size());
    if (auto defect = number_defect(text.substr(at, end - at))) return defect;
    at = end;
  }
  if (found != count)
    return "has " + std::to_string(found) + " numbers, expected " + std::to_string(count);
  return std::nullopt;
}

bool may_be_in_name(char c) {
  return static_cast<unsigned char>(c) >= 0x20 && c != '&' && c != ',' && c != '"';
}

void check_name(const XmlOutline& outline, int index, std::string_view attribute,
                UrdfReport& report) {
  const auto name = outline.elements[index].attribute(attribute);
  if (!name) return;
  const std::string where = owner(outline, index).second;
  if (name->empty() && index == 0) return report.warning_at(0, "", "<robot>: its name is empty");
  if (name->empty())
    return report.error_at(index, "", where + std::string(attribute) + " is empty");
  if (!std::all_of(name->begin(), name->end(), may_be_in_name))
    return report.error_at(index, std::string(*name),
                           where +
                               "a name may not hold control characters, commas, double "
                               "quotes or XML entities");
}

/// Reports an attribute that the element's rule does not list.
void check_unknown_attribute(const XmlOutline& outline, int index, const ElementRule& rule,
                             std::string_view attribute, std::set<std::string>& ignored,
                             UrdfReport& report) {
  const XmlElement& element = outline.elements[index];
  const auto [name, subject] = owner(outline, index);
  const std::string unknown =
      subject + "<" + std::string(element.tag) + "> has an attribute " + std::string(attribute);
  std::vector<std::string> known;
  for (const AttributeRule& a : rule.attributes) known.emplace_back(a.name);
  if (element.tag == "origin")
    report.error_at(index, name, unknown + ", which URDF 1.0 does not have",
                    "write xyz (m) and rpy (rad)");
  else if (!similar_names(attribute, known).empty())
    report.warning_at(index, name, unknown + ", which is ignored",
                      name_hint(attribute, known, "attributes"));
  else if (element.depth > 1)
    ignored.insert(std::string(element.tag) + "/" + std::string(attribute));
}

void check_attributes(const XmlOutline& outline, int index, const ElementRule& rule,
                      std::set<std::string>& ignored, UrdfReport& report) {
  const XmlElement& element = outline.elements[index];
  for (const XmlAttribute& attribute : element.attributes) {
    const auto found =
        std::find_if(rule.attributes.begin(), rule.attributes.end(),
                     [&](const AttributeRule& a) { return a.name == attribute.name; });
    if (found == rule.attributes.end()) {
      check_unknown_attribute(outline, index, rule, attribute.name, ignored, report);
    } else if (found->numbers > 0) {
      const auto [name, subject] = owner(outline, index);
      if (const auto defect = number_defect(attribute.value, found->numbers))
        report.error_at(index, name,
                        subject + "<" + std::string(element.tag) + "> " +
                            std::string(attribute.name) + ": " + *defect);
    }
  }
}

/// True if an element that is read has a xacro expression in an attribute.
bool holds_expression(const XmlOutline& outline, const XmlElement& element) {
  return rule_of(outline, element) &&
         std::any_of(element.attributes.begin(), element.attributes.end(), [](const auto& a) {
           return a.value.find("${") != a.value.npos || a.value.find("$(") != a.value.npos;
         });
}

/// True if the parent element is a part of the robot that is read.
bool would_be_content(const XmlOutline& outline, const XmlElement& element) {
  if (element.parent < 0) return false;
  const XmlElement& parent = outline.elements[element.parent];
  return parent.depth > 0 && rule_of(outline, parent) != nullptr;
}

/// True for xacro elements, which evaluation removes.
bool is_xacro(const XmlElement& element) { return element.tag.starts_with("xacro:"); }

/// True for xacro expressions, xacro elements that would become content of a link or joint, and any
/// xacro element in a file without links. Other xacro elements are merely left over.
bool is_unevaluated(const XmlOutline& outline, const XmlElement& element, bool has_links) {
  if (holds_expression(outline, element)) return true;
  return is_xacro(element) && (!has_links || would_be_content(outline, element));
}

void check_xacro(const XmlOutline& outline, UrdfReport& report) {
  const bool has_links = !outline.children(0, "link").empty();
  for (int i = 0; i < static_cast<int>(outline.elements.size()); ++i) {
    const XmlElement& element = outline.elements[i];
    if (is_unevaluated(outline, element, has_links))
      return report.error_at(i, "", "this is a xacro file that has not been evaluated",
                             "run `xacro FILE > robot.urdf` first and give the result");
    if (is_xacro(element) && element.depth == 1)
      report.warning_at(i, "",
                        "<" + std::string(element.tag) +
                            "> is left over from xacro and is ignored, with what is in it");
  }
}

bool holds_numbers(const ElementRule& rule, std::string_view attribute) {
  return std::any_of(rule.attributes.begin(), rule.attributes.end(),
                     [&](const AttributeRule& a) { return a.name == attribute && a.numbers > 0; });
}

/// Writes the numbers of an attribute (`written`, up to its closing quote) separated by single
/// blanks, the only white space that urdfdom accepts. Blanks after the quote fill the remaining
/// space.
void tidy_numbers(char* to, std::string_view written) {
  const char quote = to[written.size()];
  char* const end = to + written.size() + 1;
  const char* const begin = to;
  for (std::size_t at = 0; (at = written.find_first_not_of(kXmlSpace, at)) != written.npos;) {
    const std::size_t stop = std::min(written.find_first_of(kXmlSpace, at), written.size());
    if (to != begin) *to++ = ' ';
    to = std::copy(written.begin() + at, written.begin() + stop, to);
    at = stop;
  }
  *to++ = quote;
  std::fill(to, end, ' ');
}

}  // namespace

std::optional<UrdfProblem> check_urdf_text(std::string_view text, const std::string& file_name) {
  if (text.find_first_not_of(" \t\r\n") == text.npos)
    return UrdfProblem{.message = "'" + file_name + "' is empty"};
  if (text.size() > kMaxUrdfBytes)
    return UrdfProblem{.message = "'" + file_name + "' is larger than " +
                                  std::to_string(kMaxUrdfBytes >> 20) + " MiB"};
  if (const std::size_t bad = find_bad_character(text); bad != text.npos) {
    const std::string_view before = text.substr(0, bad);
    const std::string_view line = before.substr(before.rfind('\n') + 1);  // npos + 1 is 0
    const auto characters = std::count_if(line.begin(), line.end(), [](char c) {
      return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    });
    const bool foreign = static_cast<unsigned char>(text[bad]) >= 0x80;
    return UrdfProblem{.message = describe_bad_character(text, bad),
                       .line = static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1,
                       .column = static_cast<int>(characters) + 1,
                       .hint = foreign ? "convert it, e.g. with iconv -f latin1 -t utf-8" : ""};
  }
  return std::nullopt;
}

namespace {

/// Checks the elements of a robot one by one.
class ElementCheck {
 public:
  ElementCheck(const XmlOutline& outline, UrdfReport& report)
      : outline_(outline), report_(report) {}

  void check(int index) {
    const XmlElement& element = outline_.elements[index];
    if (const ElementRule* rule = rule_of(outline_, element)) return check_known(index, *rule);
    const XmlElement& parent = outline_.elements[element.parent];
    if (parent.depth > 0 && rule_of(outline_, parent) == nullptr) return;  // inside ignored parts
    check_unknown(index);
  }

  int links() const { return links_; }
  /// Elements and attributes that are not read.
  const std::set<std::string>& ignored() const { return ignored_; }

 private:
  void check_known(int index, const ElementRule& rule) {
    const XmlElement& element = outline_.elements[index];
    links_ += element.tag == "link";
    check_name(outline_, index, "name", report_);
    check_attributes(outline_, index, rule, ignored_, report_);
    if (element.depth > 1 && !seen_.emplace(element.parent, element.tag).second)
      error(index, "a second <" + std::string(element.tag) + "> in <" + parent_of(index) + ">");
  }

  void check_unknown(int index) {
    const XmlElement& element = outline_.elements[index];
    const std::string tag(element.tag);
    if (element.depth > 1 && (tag == "link" || tag == "joint"))
      return error(index, "<" + tag + "> stands inside <" + parent_of(index) + ">",
                   "links and joints stand directly in <robot>");
    const std::vector<std::string> readable = readable_in(parent_of(index));
    if (!is_ignored(element) && !similar_names(tag, readable).empty()) {
      const auto [name, subject] = owner(outline_, index);
      report_.warning_at(index, name,
                         subject + "<" + tag + "> is not a URDF element and is ignored",
                         name_hint(tag, readable, "elements"));
    }
    ignored_.insert("<" + tag + ">");
  }

  void error(int index, const std::string& message, const std::string& hint = {}) {
    const auto [name, subject] = owner(outline_, index);
    report_.error_at(index, name, subject + message, hint);
  }

  bool is_ignored(const XmlElement& element) const {
    return std::any_of(kIgnored.begin(), kIgnored.end(), [&](const auto& entry) {
      return entry.first == parent_tag(outline_, element) && entry.second == element.tag;
    });
  }
  static std::vector<std::string> readable_in(const std::string& parent) {
    std::vector<std::string> readable;
    for (const ElementRule& rule : rules())
      if (rule.parent == parent) readable.emplace_back(rule.tag);
    return readable;
  }
  std::string parent_of(int index) const {
    return std::string(parent_tag(outline_, outline_.elements[index]));
  }

  const XmlOutline& outline_;
  UrdfReport& report_;
  int links_ = 0;
  std::set<std::pair<int, std::string_view>> seen_;  ///< (parent, tag), allowed only once
  std::set<std::string> ignored_;
};

}  // namespace

namespace {

bool check_link_count(int links, UrdfReport& report) {
  if (links == 0) report.error_at(0, "", "the file has no links");
  if (links > kMaxUrdfLinks)
    report.error_at(0, "",
                    "the file has " + std::to_string(links) + " links, more than " +
                        std::to_string(kMaxUrdfLinks));
  return links > 0 && links <= kMaxUrdfLinks;
}

/// Copy of a text with the kept parts at their original offsets and blanks elsewhere.
class PartialCopy {
 public:
  explicit PartialCopy(std::string_view text) : text_(text), copy_(text.size(), ' ') {}

  void keep(std::string_view part) {
    if (!part.empty()) part.copy(place_of(part), part.size());
  }
  /// Tidies the numbers of a kept attribute.
  void tidy(std::string_view numbers) {
    if (!numbers.empty()) tidy_numbers(place_of(numbers), numbers);
  }
  std::string take() { return std::move(copy_); }

 private:
  char* place_of(std::string_view part) { return &copy_[part.data() - text_.data()]; }

  std::string_view text_;
  std::string copy_;
};

void tidy_attributes(const XmlElement& element, const ElementRule& rule, PartialCopy& copy) {
  for (const XmlAttribute& attribute : element.attributes)
    if (holds_numbers(rule, attribute.name)) copy.tidy(attribute.value);
}

}  // namespace

bool check_urdf_elements(const XmlOutline& outline, UrdfReport& report) {
  const XmlElement& root = outline.elements.front();
  if (root.tag != "robot") {
    report.error_at(0, "", "the root element is <" + std::string(root.tag) + ">, not <robot>",
                    "a URDF file is expected");
    return false;
  }
  check_xacro(outline, report);
  if (report.has_errors()) return false;
  if (!root.attribute("name")) report.error_at(0, "", "<robot> has no name");
  check_name(outline, 0, "name", report);

  ElementCheck elements(outline, report);
  for (int i = 1; i < static_cast<int>(outline.elements.size()); ++i) elements.check(i);
  const bool links_fit = check_link_count(elements.links(), report);
  const std::set<std::string>& ignored = elements.ignored();
  if (!ignored.empty()) report.note("not read: " + listed({ignored.begin(), ignored.end()}, 12));
  return links_fit;
}

std::string relevant_urdf(const XmlOutline& outline, std::string_view text) {
  PartialCopy relevant(text);
  for (const XmlElement& element : outline.elements) {
    const ElementRule* rule = rule_of(outline, element);
    if (element.depth > 0 && !rule) continue;
    relevant.keep(element.start_tag);
    relevant.keep(element.end_tag);
    if (rule) tidy_attributes(element, *rule, relevant);
  }
  return relevant.take();
}

}  // namespace conddp
