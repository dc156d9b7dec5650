#include "answer.hpp"

#include "output/report/certificate_report.hpp"
#include "output/report/report.hpp"
#include "output/solution/solution_json.hpp"
#include "summary/embedded_report.hpp"

namespace conddp::python {
namespace {

std::string page_of(const Answer& answer, const OrderedJson& document) {
  if (!missing_for_reports().empty())
    throw std::runtime_error("reports cannot be made: " + std::string(missing_for_reports()));
  return report_page(std::string(report_template()), report_data({{.label = answer.solver_name(),
                                                                   .document = document,
                                                                   .built = &answer.task.built}}));
}

}  // namespace

std::string Answer::verdict() const {
  return certificate ? std::string(to_string(certificate->checks.verdict())) : "";
}

bool Answer::solved() const {
  return is_success(result.status) &&
         (!certificate || !is_denied(certificate->checks.verdict()));
}

std::string Answer::names() const { return motion_names(task.built).dump(); }

std::string Answer::certificate_text() const {
  return certificate ? certificate_json(*certificate).dump() : "null";
}

std::string Answer::page() const { return page_of(*this, document()); }

std::vector<std::string> Answer::write(const std::string& folder, bool with_page,
                                       const std::string& formats) const {
  const auto chosen = parse_output_formats(formats);
  if (!chosen)
    throw std::invalid_argument("formats: '" + formats + "' is not a list of " +
                                std::string(kOutputFormats));
  const OrderedJson own = document();
  std::vector<std::string> written;
  for (const auto& path : write_solution(solution(), own, folder,
                                         with_page ? page_of(*this, own) : std::string(), *chosen))
    written.push_back(path.string());
  return written;
}

}  // namespace conddp::python
