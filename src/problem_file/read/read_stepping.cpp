#include <cmath>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

void read_edges(const YamlReader& reader, Vector3<double>& size) {
  const auto read = read_vector3(reader, "[x, y, z] in m");
  if (read && !(read->x > 0 && read->y > 0 && read->z > 0))
    reader.error("the edges of a box have positive lengths");
  else
    size = read.value_or(size);
}

BoxSpec read_box(const YamlReader& reader) {
  BoxSpec box;
  YamlMap map(reader);
  if (!map.valid()) return box;
  if (const auto r = map.require("size")) read_edges(*r, box.size);
  if (const auto r = map.find("placement")) box.placement = read_pose(*r).value_or(PoseSpec{});
  return box;
}

/// Reads a shape, and the frame that carries it, if any.
void read_shape(const YamlReader& reader, TouchedSpec& touched) {
  YamlMap map(reader);
  if (!map.valid()) return;
  if (const auto r = map.find("frame")) touched.frame = r->name();
  const auto half_space = map.find("half_space"), sphere = map.find("sphere"),
             box = map.find("box");
  map.exclusive({"half_space", "sphere"});
  map.exclusive({"half_space", "box"});
  map.exclusive({"sphere", "box"});
  if (half_space)
    touched.form = read_half_space(*half_space);
  else if (sphere)
    touched.form = read_sphere(*sphere);
  else if (box)
    touched.form = read_box(*box);
  else
    reader.error("the shape has no form", "give 'half_space', 'sphere' or 'box'");
}

/// [lower, upper]; null means unlimited.
std::optional<std::array<double, 2>> read_ends(const YamlReader& reader) {
  const auto items = reader.items();
  if (!items) return std::nullopt;
  std::array<double, 2> ends = {-kUnlimited, kUnlimited};
  if (items->size() != 2) return reader.error("limits are [lower, upper]"), std::nullopt;
  for (int i = 0; i < 2; ++i) {
    if ((*items)[i].is_null()) continue;
    const auto number = (*items)[i].number();
    if (!number) return std::nullopt;
    ends[i] = *number;
  }
  return ends;
}

/// The same, with at least one limited end.
std::optional<std::array<double, 2>> read_limits(const YamlReader& reader) {
  const auto limits = read_ends(reader);
  if (!limits) return std::nullopt;
  const auto& [lower, upper] = *limits;
  if (std::isinf(lower) && std::isinf(upper))
    return reader.error("neither end is limited"), std::nullopt;
  if (!(lower < upper))
    return reader.error("the lower limit is not below the upper one"), std::nullopt;
  return limits;
}

void read_joint_limits(const YamlReader& reader, SteppingSpec& stepping) {
  if (reader.is_scalar()) {
    stepping.all_limits = reader.choice(kJointLimitWords, "source of joint limits").value_or(false);
    return;
  }
  const auto entries = reader.named_entries();
  if (!entries) return;
  for (const auto& [name, value] : *entries)
    if (const auto limits = read_limits(value)) stepping.joint_limits.emplace_back(name, *limits);
}

CandidateSpec read_candidate(const Name& name, const YamlReader& reader) {
  if (name.value.find_first_of("/,") != std::string::npos)
    reader.diagnostics().error(name.place, "a candidate's name has no '/' and no ','");
  CandidateSpec candidate{.name = name};
  YamlMap map(reader);
  if (const auto r = map.require("frame")) candidate.frame = r->name().value_or(Name{});
  read_vector3(map, "point", "[x, y, z] in m", candidate.point);
  map.number("radius", candidate.radius, kNotNegative);
  map.read("against", candidate.against, read_touched);
  map.number("friction", candidate.friction, kNotNegative);
  if (const auto r = map.find("stiffness")) candidate.stiffness = r->number(kPositive);
  return candidate;
}

}  // namespace

TouchedSpec read_touched(const YamlReader& reader) {
  TouchedSpec touched{.place = reader.place()};
  if (!reader.is_scalar()) {
    read_shape(reader, touched);
  } else if (reader.node().text != "ground") {
    reader.error("what a candidate may touch is 'ground' or a mapping",
                 "write '{half_space: ...}', '{sphere: ...}' or '{box: ...}', with a 'frame' "
                 "where one carries it");
  }
  return touched;
}

std::vector<CandidateSpec> read_candidates(const YamlReader& reader) {
  std::vector<CandidateSpec> candidates;
  if (const auto entries = reader.named_entries())
    for (const auto& [name, value] : *entries) candidates.push_back(read_candidate(name, value));
  return candidates;
}

SteppingSpec read_stepping(const YamlReader& reader) {
  SteppingSpec stepping{.place = reader.place()};
  YamlMap map(reader);
  if (!map.valid()) return stepping;
  map.choice("scheme", stepping.scheme, kSchemeWords, "stepping scheme");
  map.choice("friction", stepping.friction, kFrictionWords, "friction model");
  if (const auto r = map.find("plane")) stepping.plane = read_direction(*r);
  if (const auto r = map.find("joint_limits")) read_joint_limits(*r, stepping);
  if (const auto r = map.find("joint_friction"))
    stepping.joint_friction = read_named_numbers(*r, kPositive);
  map.number("regularization", stepping.regularization, kNotNegative);
  return stepping;
}

}  // namespace conddp
