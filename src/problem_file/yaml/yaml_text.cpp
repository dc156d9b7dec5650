#include "problem_file/yaml/yaml_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>
#include <yaml-cpp/emitter.h>
#include <yaml-cpp/emittermanip.h>

namespace conddp {
namespace {

bool is_letter(unsigned char c) { return std::isalpha(c) != 0; }

bool is_part_of_word(unsigned char c) {
  constexpr std::string_view kOthers = "_/.- ";
  return std::isalnum(c) != 0 || kOthers.find(static_cast<char>(c)) != kOthers.npos;
}

/// True if some version of YAML reads a text as null or a truth value.
bool is_reserved(std::string text) {
  static constexpr std::array<std::string_view, 9> kReserved = {
      "null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::find(kReserved.begin(), kReserved.end(), text) != kReserved.end();
}

/// True if all YAML readers take the unquoted text literally: a word of letters, digits, '_', '/',
/// '.', '-' and inner spaces that begins with a letter and is not reserved.
bool is_plain(const std::string& text) {
  if (text.empty() || !is_letter(text.front()) || text.back() == ' ') return false;
  return std::all_of(text.begin(), text.end(), is_part_of_word) && !is_reserved(text);
}

/// The shortest text that reads back as the number. YAML 1.1 readers accept an exponent only after
/// a decimal point and with a sign.
std::string number_text(double value) {
  std::string text = fmt::format("{}", value);
  const std::size_t exponent = text.find('e');
  if (exponent != text.npos && text.find('.') == text.npos) text.insert(exponent, ".0");
  return text;
}

void write_text(const std::string& text, YAML::Emitter& out) {
  if (!is_plain(text)) out << YAML::DoubleQuoted;
  out << text;
}

bool fits_on_a_line(const OrderedJson& value) {
  constexpr std::size_t kWidth = 72;
  const bool flat = std::none_of(value.begin(), value.end(),
                                 [](const OrderedJson& part) { return part.is_structured(); });
  return flat && (value.is_array() || value.dump().size() <= kWidth);
}

void write(const OrderedJson& value, YAML::Emitter& out) {
  if (value.is_string()) return write_text(value.get_ref<const std::string&>(), out);
  if (value.is_null()) return void(out << YAML::Null);
  if (value.is_number_float()) return void(out << number_text(value.get<double>()));
  if (!value.is_structured()) return void(out << value.dump());
  if (value.empty() || fits_on_a_line(value)) out << YAML::Flow;
  if (value.is_array()) {
    out << YAML::BeginSeq;
    for (const OrderedJson& item : value) write(item, out);
    out << YAML::EndSeq;
    return;
  }
  out << YAML::BeginMap;
  for (auto entry = value.begin(); entry != value.end(); ++entry) {
    out << YAML::Key;
    write_text(entry.key(), out);
    out << YAML::Value;
    write(*entry, out);
  }
  out << YAML::EndMap;
}

}  // namespace

std::string yaml_text(const OrderedJson& document) {
  YAML::Emitter out;
  out.SetNullFormat(YAML::LowerNull);
  write(document, out);
  return std::string(out.c_str(), out.size()) + '\n';
}

}  // namespace conddp
