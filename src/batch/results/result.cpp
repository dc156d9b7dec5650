#include "batch/results/result.hpp"

#include "base/json/json_text.hpp"

namespace conddp {

std::string result_line(const ItemResult& result) {
  const OrderedJson json = {
      {"id", result.id},
      {"status", result.status},
      {"success", result.success},
      {"attempt", result.attempt},
      {"solution", {result.solution_offset, result.solution_bytes, result.solution_sum}},
      {"answer", result.answer},
      {"times", result.times}};
  return compact_json(json);
}

ItemResult parse_result(std::string_view line) {
  const OrderedJson json = OrderedJson::parse(line);
  return {.id = json.at("id"),
          .status = json.at("status"),
          .success = json.at("success"),
          .attempt = json.at("attempt"),
          .solution_offset = json.at("solution").at(0),
          .solution_bytes = json.at("solution").at(1),
          .solution_sum = json.at("solution").at(2),
          .answer = json.at("answer"),
          .times = json.at("times")};
}

}  // namespace conddp
