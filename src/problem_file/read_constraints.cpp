#include <fmt/format.h>

#include "problem_file/read_sections.hpp"
#include "problem_file/words.hpp"

namespace conddp {
namespace {

ControlBoundsSpec read_control_bounds(const Name& name, const YamlReader& reader) {
  ControlBoundsSpec spec{.name = name};
  YamlMap map(reader);
  if (!map.valid()) return spec;
  const auto bounds = map.find("bounds");
  if (!bounds) {
    reader.error(fmt::format("the constraint '{}' lacks the key 'bounds'", name.value),
                 "constraints of this version are bounds on the control: 'bounds: control'");
    map.ignore_others();
    return spec;
  }
  if (!bounds->choice(kBoundedWords, "quantity that can have bounds")) {
    map.ignore_others();
    return spec;
  }
  if (const auto r = map.find("from")) {
    static constexpr Choice<bool> kSources[] = {{"urdf", true}};
    spec.from_urdf = r->choice(kSources, "source of bounds").value_or(false);
    spec.from_place = r->place();
  }
  if (const auto r = map.find("lower")) spec.lower = read_components(*r);
  if (const auto r = map.find("upper")) spec.upper = read_components(*r);
  if (!map.find("from") && !map.find("lower") && !map.find("upper"))
    reader.error(fmt::format("the bounds '{}' need 'lower', 'upper' or 'from: urdf'", name.value));
  if (const auto r = map.find("phases")) spec.phases = r->name_or_names();
  return spec;
}

}  // namespace

std::vector<ControlBoundsSpec> read_constraints(const YamlReader& reader) {
  std::vector<ControlBoundsSpec> constraints;
  if (const auto entries = reader.named_entries())
    for (const auto& [name, value] : *entries)
      constraints.push_back(read_control_bounds(name, value));
  return constraints;
}

}  // namespace conddp
