#include <cmath>

#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {

OrderedJson expand_touched(const TouchedSpec& touched) {
  OrderedJson json = OrderedJson::object();
  if (touched.frame) json["frame"] = touched.frame->value;
  if (const auto* box = std::get_if<BoxSpec>(&touched.form)) {
    json["box"] = {{"size", expand_vector(box->size)}, {"placement", expand_pose(box->placement)}};
  } else if (const auto* sphere = std::get_if<SphereSpec>(&touched.form)) {
    json.update(expand_form(*sphere));
  } else {
    json.update(expand_form(std::get<HalfSpaceSpec>(touched.form)));
  }
  return json;
}

OrderedJson expand_candidates(const std::vector<CandidateSpec>& candidates) {
  OrderedJson json = OrderedJson::object();
  for (const CandidateSpec& candidate : candidates) {
    OrderedJson entry = {{"frame", candidate.frame.value},
                         {"point", expand_vector(candidate.point)},
                         {"radius", candidate.radius},
                         {"against", expand_touched(candidate.against)},
                         {"friction", candidate.friction}};
    if (candidate.stiffness) entry["stiffness"] = *candidate.stiffness;
    json[candidate.name.value] = std::move(entry);
  }
  return json;
}

OrderedJson expand_stepping(const SteppingSpec& stepping) {
  OrderedJson json = {{"scheme", word_of(kSchemeWords, stepping.scheme)},
                      {"friction", word_of(kFrictionWords, stepping.friction)}};
  if (stepping.plane) json["plane"] = expand_vector(*stepping.plane);
  json["joint_limits"] = OrderedJson::object();
  for (const auto& [name, limits] : stepping.joint_limits) {
    OrderedJson pair = OrderedJson::array();
    for (const double limit : limits)
      pair.push_back(std::isfinite(limit) ? OrderedJson(limit) : OrderedJson(nullptr));
    json["joint_limits"][name.value] = std::move(pair);
  }
  if (stepping.all_limits) json["joint_limits"] = word_of(kJointLimitWords, true);
  json["joint_friction"] = expand_numbers(stepping.joint_friction);
  json["regularization"] = stepping.regularization;
  return json;
}

}  // namespace conddp
